"""The report's part on what to record next: the bands after it, and the command that designs it."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.tidy.friction import without_totals
from ur5lib.topics.next_recordings.rows import NOW

MAX_NAMED_PARAMETERS = 3  # parameters that the next recording is designed for


Outlook = tuple[str, pd.Series, pd.Series]
"""An arm, its bands as they are, and after the recording that narrows forces most."""


def outlooks(results: Results) -> Iterator[Outlook]:
    """Yield the outlook of each arm."""
    for robot, rows in results.rows("next_recordings").groupby("robot", sort=False):
        now = rows[rows["after"] == NOW].iloc[0]
        yield str(robot), now, rows.sort_values("force", kind="stable").iloc[0]


def worthwhile(results: Results) -> pd.DataFrame:
    """Return what to record next of the arms for which that is worth it."""
    named = [robot for robot, _, best in outlooks(results) if best["worthwhile"] == "yes"]
    return results.rows("next_recordings", robot=named)


def limits(results: Results) -> Iterator[str]:
    """Say what limits the band of forces where another recording would not narrow it."""
    for robot, now, best in outlooks(results):
        if best["worthwhile"] == "no":
            yield say("next_recordings.limit", robot=robot, now=now, best=best)


def designs(results: Results) -> Iterator[str]:
    """Yield each arm's least determined parameters, and the command that designs a recording."""
    study, lab = results.study["study"], results.study.get("devices") or {}
    table = lab.get("table_m") or 0.0
    parameters = without_totals(results.tables["friction"])
    for robot, rows in parameters.groupby("robot", sort=False):
        worst = rows.sort_values("prior_share", ascending=False)[:MAX_NAMED_PARAMETERS]
        words = {"robot": robot, "study": study, "table": f"{table:g}", "last": rows["joint"].max()}
        words["load"] = results.loads.get(robot)
        yield say("next_recordings.design", worst=[*worst.itertuples()], **words)


def to_record(results: Results) -> Iterator[str]:
    """Ask for the recording that narrows the band of forces, or say what limits it."""
    for robot, now, best in outlooks(results):
        if best["worthwhile"] == "yes":
            yield say("next_recordings.narrower", robot=robot, now=now, best=best)
    yield from limits(results)
