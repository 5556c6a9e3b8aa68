"""Folders of a user's own, in which the workflow of the package runs."""
