"""End effector's accelerations compared with the IMU, its calibration, tests of the smoother."""

from dataclasses import replace

import pandas as pd

from ur5lib.report.page.document import Verdict
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results, with_zero
from ur5lib.report.views.arms import of_each_arm
from ur5lib.report.views.baseline import AgainstBaseline, Rival

MOTION_TOPIC = "Motion"  # topic


def drawn(results: Results) -> list[str]:
    """Return the recordings whose acceleration is drawn: with printed errors, or the first."""
    printed = results.shown(results.printed("acceleration_mae"))
    return printed or results.shown(results.listed("acceleration_mae"), 1)


def errors(results: Results) -> pd.DataFrame:
    """Return the errors with and without IMU, and of zero, for recordings with a valid IMU."""
    rows = results.tables["acceleration_mae"]
    rows = rows[~rows["estimate"].str.startswith("euler")]
    rows = rows.assign(value=rows["mae"], zero=rows["zero_mae"])
    return with_zero(rows, "estimate", ["component"])


def beside_zero(results: Results) -> AgainstBaseline:
    """Return the errors of the acceleration from encoders, beside those of no acceleration."""
    methods = results.rows("acceleration_mae")
    rows = methods[methods["estimate"] == "encoders"]
    models = {"encoders": "ours", "filterpy": "rival"}
    rival = Rival.beside("filterpy's plain smoother", methods, "mae", "component", models)
    return AgainstBaseline(rows, "mae", "zero_mae", "m/s²", "component", rival=rival)


def decided(results: Results) -> pd.DataFrame:
    """Return the errors by which the motion of each arm is judged, by component.

    fused, plain: errors with the IMU's measurements, and of filterpy's.
    """

    def of_arm(own: Results) -> pd.DataFrame:
        rows = own.tables["acceleration_mae"]
        names = {"encoders+imu": "fused", "filterpy": "plain"}
        means = rows.pivot_table("mae", "component", "estimate").reindex(columns=[*names])
        return beside_zero(own).by_place().join(means.rename(columns=names))

    return of_each_arm(results, of_arm)


def judge_motion(results: Results) -> Verdict | None:
    """Judge the acceleration from encoders by its worst component, beside filterpy's plain
    smoother; None without an IMU.
    """
    against = beside_zero(results)
    if against.errors.empty:
        return None
    if str(against.worst.name).startswith("r"):
        against = replace(against, unit="rad/s²")
    return Verdict(
        topic=MOTION_TOPIC,
        state=against.state(),
        sentence=against.after(say("motion.verdict", against=against)),
        evidence=say("motion.evidence", against=against),
        numbers=against.numbers("mean absolute error"),
    )
