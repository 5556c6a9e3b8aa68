"""Clocks, resampling, low-pass, motion."""
