"""Verdicts on the first screen of a report, one module for each topic."""
