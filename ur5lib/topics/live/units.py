"""Units of its tables, which `ur5lib.records.units` reads."""

UNITS = {"live_pushes": {"^(value|std_error|low|high|largest_tried)$": "N"}}
