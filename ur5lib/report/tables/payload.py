"""The undeclared payload on the flange."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "mass",
    "std_error",
    "low",
    "high",
    "center_of_mass_x",
    "center_of_mass_y",
    "center_of_mass_z",
    "configured",
    "taken",
    "center_of_mass_std_x",
    "center_of_mass_std_y",
    "center_of_mass_std_z",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("currents"):
        yield from payload_rows(name, summary)


def payload_rows(recording: str, currents: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the undeclared payload on the flange, from currents.json; none at rest."""
    if load := currents.get("load"):
        low, high = load["interval"]
        place = {
            f"{name}_{axis}": value
            for name in ("center_of_mass", "center_of_mass_std")
            for axis, value in zip("xyz", load[name], strict=True)
        }
        yield {
            "recording": recording,
            "mass": load["mass"],
            "std_error": load["std_error"],
            "low": low,
            "high": high,
            **place,
            "configured": load["configured"],
            "taken": "yes" if load["taken"] else "no",
        }
