"""Verdicts from tables: which results may be used, by which number, and why not better."""
