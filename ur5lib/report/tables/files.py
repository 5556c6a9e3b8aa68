"""The files that each recording was read from."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "file", "sha256"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for recording, quality in results.each("quality"):
        for file, checksum in quality["read"].items():
            yield {"recording": recording, "file": file, "sha256": checksum}
