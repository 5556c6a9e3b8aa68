"""Readers of raw device files, frame repair, quality."""
