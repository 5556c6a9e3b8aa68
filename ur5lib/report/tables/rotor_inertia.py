"""Rotor inertias, and the terms beside them that should be zero."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "joint",
    "value",
    "std_error",
    "offset",
    "offset_std_error",
    "coulomb",
    "coulomb_std_error",
    "viscous",
    "viscous_std_error",
    "robot",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("rotors"):
        yield from rotor_rows(name, summary)


def rotor_rows(robot: str, rotors: Mapping[str, Any]) -> Iterator[Row]:
    """Yield rotor inertias and the terms that should be zero, from rotor_inertia.json."""
    if not rotors["from"]:
        return
    value, std = rotors["value"], rotors["std_error"]
    for joint in range(6):
        terms = {
            name: part[term][joint]
            for term in ("offset", "coulomb", "viscous")
            for name, part in ((term, value), (f"{term}_std_error", std))
        }
        yield {
            "joint": joint + 1,
            "value": value["inertia"][joint],
            "std_error": std["inertia"][joint],
            **terms,
            "robot": robot,
        }
