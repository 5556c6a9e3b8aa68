"""Comparison of the results of two studies: numbers that changed by more than their error."""
