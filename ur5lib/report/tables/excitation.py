"""How well the recordings excite an arm."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "combinations", "undetermined", "gravity", "inertia", "rotors", "all", "advice"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("identification"):
        yield from excitation_rows(name, summary)


def excitation_rows(robot: str, identification: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the excitation of each arm by its recordings, from identification.json."""
    found = identification.get("excitation")
    if found:
        yield {
            "robot": robot,
            "combinations": found["combinations"],
            "undetermined": len(found["undetermined"]),
            **found["condition"],
            "advice": "; ".join(found["advice"]),
        }
