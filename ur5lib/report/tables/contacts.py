"""Each alarm: when, the largest force in it, and the mass of a load."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "estimate",
    "start_s",
    "end_s",
    "peak_s",
    "Fx",
    "Fx_std",
    "Fy",
    "Fy_std",
    "Fz",
    "Fz_std",
    "kind",
    "load_mass",
    "load_mass_std",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("detection"):
        yield from contact_rows(name, summary)


def contact_rows(recording: str, detection: Mapping[str, Any]) -> Iterator[Row]:
    """Yield each alarm: its time, largest force, and the mass of a load, from detection.json."""
    for estimate, found in detection.items():
        for alarm in found["raised"]:
            values = zip("xyz", alarm["force"], alarm["force_std"], strict=True)
            yield {
                "recording": recording,
                "estimate": estimate,
                "kind": alarm.get("kind", "contact"),
                "load_mass": alarm.get("load_mass"),
                "load_mass_std": alarm.get("load_mass_std"),
                "start_s": alarm["start"],
                "end_s": alarm["end"],
                "peak_s": alarm["peak"],
                **{
                    name: number
                    for axis, force, std in values
                    for name, number in ((f"F{axis}", force), (f"F{axis}_std", std))
                },
            }
