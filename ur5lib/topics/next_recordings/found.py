"""The next recording, as a step: the one that narrows the band of forces most, or a rest."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.records.phrases import number
from ur5lib.report.results import Results
from ur5lib.report.stated import Step, designing

TABLES = ("next_recordings",)
NOW = "now"  # the bands without another recording
AS_GOOD = 1.01  # times the least band; nobody mounts a load for less

Outlook = tuple[str, pd.Series, pd.Series]
"""An arm, its present bands, and its bands after the recording that narrows forces most."""


def to_record(results: Results) -> Iterator[Step]:
    """Ask for the recording that narrows the band of forces, or for rest before contacts if no
    recording does.
    """
    known = [*outlooks(results)]
    for robot, now, best in known:
        if best["worthwhile"] == "yes":
            load = results.loads.get(robot) if " with " in best["after"] else None
            bands = (number(one["force"], ".3g") for one in (now, best))
            narrows = f"this narrows the 95 % band of forces from ± {' to ± '.join(bands)} N"
            sentence = f"Record {best['after']}, with {robot}: {narrows}."
            yield Step(sentence, designing(results, robot, load))
    for robot, now, best in known:
        if best["worthwhile"] == "no" and not _rests(results, robot):
            sentence = (
                f"Let {robot} rest untouched for 1 s before contacts, and declare this span: "
                f"further motion would narrow the ± {number(now['force'], '.2g')} N of its forces "
                "by less than a tenth."
            )
            yield Step(sentence, "untouched: [0, 1]")


def outlooks(results: Results) -> Iterator[Outlook]:
    """Yield the outlook of each arm."""
    for robot, rows in results.rows("next_recordings").groupby("robot", sort=False):
        now = rows[rows["after"] == NOW].iloc[0]
        yield str(robot), now, _best(rows)


def _best(rows: pd.DataFrame) -> pd.Series:
    """Return the recording that narrows forces most; without a load, if that does as well."""
    alike = rows[rows["force"] <= AS_GOOD * rows["force"].min()]
    unloaded = alike[~alike["after"].str.contains(" with ")]
    return (unloaded if len(unloaded) else alike).sort_values("force", kind="stable").iloc[0]


def _rests(results: Results, robot: str) -> bool:
    """Return whether every contact recording of an arm declares a span in which nothing touches the
    resting arm.
    """
    arms, entries = results.arms(), results.study["recordings"]
    own = [one for one in entries if arms[one["name"]] == robot and one["role"] == "contact"]
    return bool(own) and all(one.get("untouched") for one in own)
