"""What a comparison with other studies adds to the findings."""

from collections.abc import Iterator

from ur5lib.report.results import Results
from ur5lib.report.stated import listed

TABLES = ("changes",)


def findings(results: Results) -> Iterator[str]:
    """Report for each other study how much changed, and in which topics."""
    for study in results.listed("changes", "study"):
        rows = results.rows("changes", study=study)
        changed = rows[rows["changed"] == "yes"]
        if len(changed):
            topics = listed([*changed["topic"].unique()])
            yield f"{len(changed)} of {len(rows)} numbers changed since {study}: {topics}."
