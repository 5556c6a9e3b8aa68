"""Units of its tables, which `ur5lib.records.units` reads."""

UNITS = {"next_recordings": {"force": "N", "current": "A", "mass": "kg"}}
