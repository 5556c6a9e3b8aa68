"""Readers of raw device files and frame repair: from files to frames."""
