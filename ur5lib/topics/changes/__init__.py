"""A study's results beside those of other studies."""
