"""How long recordings are, how regular their frames, and which joints move."""

from collections.abc import Iterator

import numpy as np

from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "duration_s",
    "rows_read",
    "frames",
    "longest_step_s",
    "jitter_s",
    "devices",
    "moving_joints",
]
TRAVEL = 0.02  # rad, between the ends of the path of a joint that moves


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    signals = results.paths_of("signals")
    for recording, quality in results.each("quality"):
        yield {
            "recording": recording,
            "duration_s": quality["duration_s"],
            "rows_read": quality["rows"],
            "frames": quality["frames"],
            "longest_step_s": quality["longest_step_s"],
            "jitter_s": quality["jitter_s"]["99 %"],
            "devices": " ".join(quality["devices"]),
            "moving_joints": " ".join(map(str, moving_joints(Signals.read(signals[recording])))),
        }


def moving_joints(signals: Signals) -> list[int]:
    """Return the joints, from 1, that do not rest throughout a recording."""
    travel = np.nanmax(signals.actual_q, axis=0) - np.nanmin(signals.actual_q, axis=0)
    return [int(joint) + 1 for joint in np.flatnonzero(travel > TRAVEL)]
