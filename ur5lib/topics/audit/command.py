"""The command `ur5 audit`."""

from collections.abc import Iterator
from pathlib import Path

from ur5lib.commands.arguments import StudyFile, print_lines


def audit(study: StudyFile) -> None:
    """Print the faults of the wrist sensors, and the remedies.

    Example: ur5 audit mine
    """
    print_lines(audit_answers(study))


def audit_answers(study: Path) -> Iterator[str]:
    """Yield the verdicts on the wrist sensors of a study's recordings, line by line.

    Raises InputError where the study was not run, or has no wrist sensor.
    """
    from ur5lib.commands.answers import finished_study  # slow to import
    from ur5lib.errors import InputError
    from ur5lib.topics.audit.report import verdicts

    rows = finished_study(study).table("audit")
    if rows.empty:
        raise InputError(
            f"{study}: no recording has a wrist sensor's reading (ft_raw_wrench or "
            "actual_TCP_force of an e-Series arm); record one of them"
        )
    for name, part in rows.groupby("recording", sort=False):
        yield f"{name}:"
        yield from (f"  {sentence}" for sentence in verdicts(part))
