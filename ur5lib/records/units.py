"""The units of the tables of results, by column.

Columns with different units by row are not listed: `unit` or `parameter` gives the unit there.
"""

from collections.abc import Iterable, Mapping
from re import search

ByTable = Mapping[str, Mapping[str, str]]
WRENCH, ACCELERATION, EFFORT = "N, Nm", "m/s2, rad/s2", "effort"  # by component, and by arm
BY_ENDING = {
    "s": "s",
    "m": "m",
    "n": "N",
    "deg": "deg",
    "ppm": "ppm",
    "per_min": "1/min",
    "per_min_high": "1/min",
    "mb": "MB",
}
BY_NAME = {"minutes": "min", "seconds": "s"}
BY_TABLE: dict[str, dict[str, str]] = {  # a pattern of columns' names, and their unit
    "acceleration_mae": {"mae$": ACCELERATION},
    "contact_errors": {"^impulse": "N s", "^(peak|peak_error|largest.*|mae.*|band)$": "N"},
    "contacts": {"^F|^largest": "N", "flange_speed": "m/s", "load_mass": "kg"},
    "cross_validation": {"rmse": EFFORT},
    "current_rmse": {"rmse|^mae$": EFFORT},
    "error_parts": {"^(error|missed|late_alarms|gain|friction)$": "N", "^drift": "N/min"},
    "force_mae": {
        "^(zero_|even_)?(mae.*|max|interval_score95)$|^width95$|mean_force": WRENCH,
    },
    "friction": {"^load$": "Nm", "known|contradicted": f"Nm/{EFFORT}"},
    "judged_errors": {"torque$": "Nm"},
    "model_errors": {"mae": "Nm"},
    "noticed": {"^(largest_missed|smallest_found|peak_bias|band)$": "N"},
    "payload": {"center_of_mass": "m", "^(mass|std_error|low|high|configured)$": "kg"},
    "push_curve": {"force": "N"},
    "push_directions": {"^(unit|value|std_error)$": "N"},
    "pushes": {"^(value|std_error|low|high|largest_tried)$": "N"},
    "rotor_inertia": {
        "^(value|std_error)$": "kg m2",
        "offset|coulomb": "Nm",
        "viscous": "Nm s/rad",
    },
    "sensed": {"^bias": "N", "^drift": "N/min"},
    "torque_constants": {"^(torque|std|low|high|known|contra)": f"Nm/{EFFORT}"},
    "torque_mae": {"mae": "Nm"},
}


def column_units(
    table: str, columns: Iterable[str], effort: str, own: ByTable | None = None
) -> dict[str, str]:
    """Return the units of a table's columns that have the same unit in all rows.

    `N, Nm`: of forces and moments, by `component`; effort: `A`, or `Nm` for an arm that measures
    torques; own: units of further tables, such as those of a topic.
    """
    patterns = {**BY_TABLE, **(own or {})}.get(table, {})
    found = {name: _unit(patterns, name) for name in columns}
    return {name: unit.replace(EFFORT, effort) for name, unit in found.items() if unit}


def _unit(patterns: Mapping[str, str], column: str) -> str:
    for pattern, unit in patterns.items():
        if search(pattern, column):
            return unit
    ends = (unit for ending, unit in BY_ENDING.items() if f"_{column}".endswith(f"_{ending}"))
    return BY_NAME.get(column) or next(ends, "")
