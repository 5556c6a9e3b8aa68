"""Readers of raw device files, frame repair and quality checks."""
