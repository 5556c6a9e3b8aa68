"""Contacts detected by each estimate, by the force they reach."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "estimate",
    "threshold",
    "force_class_n",
    "contacts",
    "found",
    "precision",
    "recall",
    "false_alarms_per_min",
    "extra_alarms",
    "time_in_alarm",
    "free_time_in_alarm",
    "median_delay_s",
    "causal_delay_s",
    "smallest_force_95_x",
    "smallest_force_95_y",
    "smallest_force_95_z",
    "alarms",
    "alarms_per_min",
    "roc_area",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("detection"):
        yield from detection_rows(name, summary)


def detection_rows(recording: str, detection: Mapping[str, Any]) -> Iterator[Row]:
    """Yield detections by estimate and by the force of the contacts, from detection.json.

    Without a force sensor, one row an estimate and no force.
    """
    for estimate, found in detection.items():
        smallest = found.get("smallest_force_95", {})
        pushes = {
            f"smallest_force_95_{axis}": figures["force"] for axis, figures in smallest.items()
        }
        for i, part in enumerate(found.get("classes", [{}])):
            yield {
                "recording": recording,
                "estimate": estimate,
                "threshold": found["threshold"],
                "force_class_n": part.get("force"),
                **{name: part.get(name) for name in ("contacts", "found", "recall")},
                "false_alarms_per_min": found.get("false_per_min"),
                "extra_alarms": found.get("extra"),
                **{name: found.get(name) for name in ("time_in_alarm", "free_time_in_alarm")},
                "median_delay_s": part.get("median_delay"),
                "causal_delay_s": part.get("causal_delay"),
                **(pushes if i == 0 else {}),
                "precision": found.get("precision"),
                "alarms": len(found["raised"]),
                "alarms_per_min": found["alarms_per_min"],
                "roc_area": found.get("roc_area"),
            }
