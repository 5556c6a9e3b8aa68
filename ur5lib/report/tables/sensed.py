"""What force sensors read, whether or not a force was estimated beside them."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "largest_force_n", "at_s", "share_in_contact", "contacts"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("forces"):
        if felt := summary.get("felt"):
            values = (felt["largest"], felt["at_s"], felt["contact"], felt["contacts"])
            yield {"recording": name, **dict(zip(COLUMNS[1:], values, strict=True))}
