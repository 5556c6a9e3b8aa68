"""Workspaces: folders of users, with their studies, recordings and extensions."""
