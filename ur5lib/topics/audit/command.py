"""The command `ur5 audit`."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ur5lib.commands.arguments import AsJson, StudyFile, as_text, print_lines
from ur5lib.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


def audit(study: StudyFile, as_json: AsJson = False) -> None:
    """Print the faults of the wrist sensors, and the remedies.

    Example: ur5 audit mine
    """
    rows = audit_rows(study)
    print_lines([as_text(rows.to_dict("records"))] if as_json else audit_answers(rows))


def audit_rows(study: Path) -> "pd.DataFrame":
    """Return the rows of `AuditRow` of a study's recordings.

    Raises InputError where the study was not run, or has no wrist sensor.
    """
    from ur5lib.commands.answers import finished_study  # slow to import

    rows = finished_study(study).table("audit")
    if rows.empty:
        raise InputError(
            f"{study}: no recording has a wrist sensor's reading (ft_raw_wrench or "
            "actual_TCP_force of an e-Series arm); record one of them"
        )
    return rows


def audit_answers(rows: "pd.DataFrame") -> Iterator[str]:
    """Yield the verdicts on the wrist sensors of recordings, line by line."""
    from ur5lib.topics.audit.sentences import verdicts

    for name, part in rows.groupby("recording", sort=False):
        yield f"{name}:"
        yield from (f"  {sentence}" for sentence in verdicts(part))
