"""The studies of the working folder: `ur5 list`, and the answer to a command without a study."""

import time
from collections.abc import Iterator
from pathlib import Path

from ur5lib.study.address import NO_STUDY, RESULTS_FOLDER, studies


def studies_here() -> Iterator[str]:
    """Yield a line for each study of the working folder: its name, its file, and its report."""
    rows = [(name, str(file), _built(name)) for file, name in studies()]
    if not rows:
        yield NO_STUDY
    wide = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    for name, file, built in rows:
        yield f"{name:{wide[0]}}  {file:{wide[1]}}  {built}"


def written(report: Path) -> str | None:
    """Return the time at which a report was written; None without a report."""
    if not report.is_file():
        return None
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(report.stat().st_mtime))


def _built(name: str) -> str:
    """Return in words whether a study has a report."""
    day = written(RESULTS_FOLDER / name / "report.html")
    return f"report of {day}" if day else "not built"
