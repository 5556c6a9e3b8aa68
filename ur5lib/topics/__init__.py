"""Topics: side results, a folder each, which a loop finds and nothing else uses.

A folder contains its steps with their rules (`rules.smk`), the rows of its tables, its figure, and
its part of the report (`section.typ`, `report.py`, `found.py`). Deleted, it takes these along and
changes no other.
"""
