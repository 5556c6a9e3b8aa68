"""How long recordings are and how regular their frames."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "duration_s",
    "rows_read",
    "frames",
    "longest_step_s",
    "jitter_s",
    "devices",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for recording, quality in results.each("quality"):
        yield {
            "recording": recording,
            "duration_s": quality["duration_s"],
            "rows_read": quality["rows"],
            "frames": quality["frames"],
            "longest_step_s": quality["longest_step_s"],
            "jitter_s": quality["jitter_s"]["99 %"],
            "devices": " ".join(quality["devices"]),
        }
