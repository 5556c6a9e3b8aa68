"""A study of many recordings by arm and month, in place of tables with a row for each recording."""

from collections.abc import Iterator, Mapping
from functools import reduce

import pandas as pd

from ur5lib.force.estimators import LEADING
from ur5lib.report.page.document import MOST_SHOWN
from ur5lib.report.page.findings import SEVERITIES
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.contacts import errors_in_contact
from ur5lib.report.views.currents import in_motion, loaded
from ur5lib.report.views.recordings import lost_shares


def arms(results: Results) -> list[str]:
    """Return the arms of a study of many recordings; of others, none."""
    return results.robots() if results.many else []


def pages(results: Results) -> Iterator[str]:
    """Say how a recording's own page is made, and name recordings that were left out."""
    if results.many:
        yield say("overview.pages", study=results.study["study"], name=next(iter(results.roles())))
        absent = results.unusable()
        more = len(absent) - MOST_SHOWN
        if absent:
            yield say("overview.left out", count=len(absent), names=absent[:MOST_SHOWN], more=more)


def quality(results: Results, robot: str) -> pd.DataFrame:
    """Return each month's recordings, those with findings by severity, and lost frames."""
    with_findings = results.tables["quality"].groupby("severity")["recording"].unique()
    sets = {severity: with_findings.get(severity, ()) for severity in SEVERITIES[:-1]}
    sets["used"] = results.tables["recordings"]["recording"]
    months = _months(results, robot)
    marks = pd.DataFrame(
        {name: months.index.isin(names) for name, names in sets.items()}, months.index
    )
    counts = marks.groupby(months).sum()
    return _by_month(months, {"lost": lost_shares(results)}).join(counts).reset_index()


def estimates(results: Results, robot: str) -> pd.DataFrame:
    """Return each month's errors of currents and forces, undeclared loads, and false alarms.

    current: RMSE of the predicted current relative to that of a constant one, mean over moving
    joints, without contact; load: mass [kg], where certain; alarm: false alarms a minute; force:
    error in contact, mean over x, y, z [N].
    """
    free = {name for name, role in results.roles().items() if role != "contact"}
    currents = in_motion(results, free).query("model == 'fitted'")
    alarms = results.rows("detection", estimate=LEADING).drop_duplicates("recording")
    alarms = alarms[alarms["recording"].isin(free)].set_index("recording")
    forces = errors_in_contact(results)
    values = {
        "current": (currents["rmse_2hz"] / currents["zero"]).groupby(currents["recording"]).mean(),
        "load": loaded(results).set_index("recording")["mass"],
        "alarm": alarms["false_alarms_per_min"].fillna(alarms["alarms_per_min"]),
        "force": forces["mae"].groupby(forces["recording"]).mean(),
    }
    return _by_month(_months(results, robot), values).reset_index()


def friction(results: Results, robot: str) -> pd.DataFrame:
    """Return the median Coulomb friction of each joint by month, and the joints' temperature."""
    rows = results.rows("health", robot=robot, quantity="coulomb")
    rows = rows.assign(month=rows["date"].astype(str).str[:7])
    medians = rows.groupby(["month", "joint"])[["value", "temperature_c"]].median().reset_index()
    return medians.assign(warmth=medians.groupby("month")["temperature_c"].transform("mean"))


def _months(results: Results, robot: str) -> pd.Series:
    """Return the month of each recording of an arm, by its name."""
    of_arm = {name for name, arm in results.arms().items() if arm == robot}
    months = results.months()
    return months[months.index.isin(of_arm)]


def _by_month(
    months: pd.Series, values: Mapping[str, Mapping[str, float] | pd.Series]
) -> pd.DataFrame:
    """Return the number of recordings of each month and, of each value by recording, the count, the
    median, the largest, and the recording of this: `name`_count, `name`_median, `name`_most,
    `name`_of; NaN in months without a value.
    """
    parts = [months.value_counts().sort_index().rename("recordings").to_frame()]
    for name, by_recording in values.items():
        of_months = pd.Series(by_recording, dtype=float).dropna().groupby(months)
        summaries = of_months.agg(["count", "median", "max", "idxmax"])
        summaries.columns = [f"{name}_{kind}" for kind in ("count", "median", "most", "of")]
        parts.append(summaries)
    return reduce(pd.DataFrame.join, parts)
