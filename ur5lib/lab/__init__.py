"""A laboratory: its recorder, a virtual test stand, and doubles of its devices on that stand."""
