"""The report's part on what to record next: the bands after it, and the command that designs it."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.currents import is_worthwhile, outlooks
from ur5lib.tidy.friction import without_totals

MAX_NAMED_PARAMETERS = 3  # parameters that the next recording is designed for


def worthwhile(results: Results) -> pd.DataFrame:
    """Return what to record next of the arms for which that is worth it."""
    named = [robot for robot, pair in outlooks(results).items() if is_worthwhile(*pair)]
    return results.rows("next_recordings", robot=named)


def limits(results: Results) -> Iterator[str]:
    """Say what limits the band of forces where another recording hardly narrows it."""
    for robot, (now, best) in outlooks(results).items():
        if not is_worthwhile(now, best):
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
    for robot, (now, best) in outlooks(results).items():
        if is_worthwhile(now, best):
            yield say("next_recordings.narrower", robot=robot, now=now, best=best)
    yield from limits(results)
