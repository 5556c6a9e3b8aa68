"""Estimates from simulated recordings beside the truth."""
