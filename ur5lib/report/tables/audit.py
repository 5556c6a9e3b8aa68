"""What is wrong with the force sensors in arms' wrists."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "quantity",
    "component",
    "value",
    "std_error",
    "low",
    "high",
    "unit",
    "expected",
    "verdict",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows; a recording with too little time without contact has a single one."""
    for name, summary in results.each("audit"):
        if summary:
            free = {"quantity": "free_time", "value": summary["free_s"], "unit": "s"}
            yield from ({"recording": name, **row} for row in [free, *summary["rows"]])
