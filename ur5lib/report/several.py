"""The page of several studies: each arm's verdicts side by side, by date, from their summaries."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml

from ur5lib.errors import InputError
from ur5lib.report.page.handed import of_no_study, sources
from ur5lib.report.page.typeset import html_page
from ur5lib.report.summary import StatedVerdict, Summary, last_summary
from ur5lib.strict import FAST_LOADER

# Columns of the page: the question, and the number's quantity or else its rank.
SHOWN: dict[str, tuple[str, int | str]] = {
    "data": ("recordings", 1),
    "constants": ("constants", 1),
    "friction": ("friction", 2),
    "currents": ("currents", 1),
    "link model": ("links", 1),
    "load": ("load", 1),
    "force": ("force", 1),
    "peak": ("contacts", "mean absolute error of found peaks"),
    "contacts": ("contacts", 1),
    "false alarms": ("alarms", "false alarms, all recordings"),
    "push": ("pushes", "trial push found with 95 %, by posture and direction"),
    "motion": ("motion", 1),
    "drift": ("drift", 1),
}
MOST_CHANGED = 5  # numbers of a study that the page names


def several_page(folders: Sequence[Path], page: Path) -> str:
    """Return the page of several studies as HTML, the latest first.

    folders: of their results; page: where it will be, from which its links lead. Raises InputError
    for a folder without a summary of this version.
    """
    rows = [row for folder in folders for row in _rows(folder, page)]
    rows.sort(key=lambda row: (row["date"], row["study"]), reverse=True)
    with sources({**of_no_study(), "several": {"rows": rows, "heads": [*SHOWN]}}) as root:
        return html_page(root, "several")


def _rows(folder: Path, page: Path) -> Iterator[dict[str, Any]]:
    """Yield a row for each arm of a study."""
    summary = last_summary(folder / "results.json")
    if summary is None:
        next_ = f"ur5 run {folder.name}"
        raise InputError(f"{folder}/results.json is of another version; next: {next_}")
    arms = sorted({one.arm for one in summary.verdicts if one.arm}) or [""]
    changed = [one for one in summary.verdicts if one.before is not None]
    for arm in arms:
        yield {
            "study": summary.study,
            "title": summary.title,
            "report": _link(folder / "report.html", page.parent),
            "arm": arm,
            "date": _date(folder, summary),
            "cells": {head: _cell(summary, arm, *of) for head, of in SHOWN.items()},
            "changed": len(changed),
            "of": len(summary.verdicts),
            "named": [*map(asdict, changed[:MOST_CHANGED])] if arm == arms[0] else [],
        }


def _link(file: Path, start: Path) -> str:
    return Path(os.path.relpath(file, start)).as_posix()


def _cell(summary: Summary, arm: str, question: str, which: int | str) -> dict[str, Any] | None:
    """Return the verdict of a column, of the arm or else of the study; None without one."""
    own = [one for one in summary.verdicts if one.question == question and one.arm in (arm, "")]
    named = [one for one in own if which in (one.rank, one.quantity)]
    found: StatedVerdict | None = next(iter(sorted(named, key=lambda one: one.arm != arm)), None)
    if found is None:
        return None
    return {name: None if value == "" else value for name, value in asdict(found).items()}


def _date(folder: Path, summary: Summary) -> str:
    """Return the date of the latest recording (ISO), or else of the analysis."""
    file = folder / "configuration.yaml"
    study = yaml.load(file.read_text("utf-8"), FAST_LOADER) if file.is_file() else {}
    dates = [str(one["date"]) for one in study.get("recordings", []) if one.get("date")]
    return max(dates, default=summary.analysed)
