"""The report's part on what to record next: the bands after it, and the command that designs it."""

import pandas as pd

from ur5lib.records.friction import without_totals
from ur5lib.report.results import Results
from ur5lib.report.stated import designing
from ur5lib.topics.next_recordings.found import outlooks

MAX_NAMED_PARAMETERS = 3  # the next recording is designed for this many parameters


def outlook(results: Results) -> pd.DataFrame:
    """Return for each arm the half-width of the force's 95 % band [N] now (`now`) and after the
    best recording to come, the kind of that recording, and whether it is worthwhile.
    """
    return pd.DataFrame([{**best, "now": now["force"]} for _, now, best in outlooks(results)])


def least_determined(results: Results) -> pd.DataFrame:
    """Return the least determined parameters of each arm, the least first."""
    rows = without_totals(results.rows("friction")).sort_values("prior_share", ascending=False)
    first = rows.groupby("robot", sort=False).head(MAX_NAMED_PARAMETERS)
    return first[["robot", "joint", "parameter", "std_error", "prior_share"]]


def commands(results: Results) -> pd.DataFrame:
    """Return for each arm with fitted friction the command that designs a recording for the least
    determined parameters, the number of its last joint, and a load [kg] for it, if there is any.
    """
    last = results.rows("friction").groupby("robot", sort=False)["joint"].max().reset_index()
    loads = [results.loads.get(robot) for robot in last["robot"]]
    designs = [designing(results, *own) for own in zip(last["robot"], loads, strict=True)]
    return last.assign(load=loads, command=[f"{own} --question undetermined" for own in designs])
