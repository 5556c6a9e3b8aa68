"""Units of its tables, which `ur5lib.records.units` reads."""

UNITS = {"published_constants": {"^torque_constant": "Nm/A", "^offset|mean_torque": "Nm"}}
