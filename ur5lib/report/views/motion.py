"""End effector's accelerations compared with the IMU, its calibration, tests of the smoother."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from ur5lib.report.page.document import Verdict
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results, with_zero
from ur5lib.report.views.baseline import AgainstBaseline, Rival

LINEAR_LABEL, ANGULAR_LABEL = "x, y, z [m/s²]", "rx, ry, rz [rad/s²]"
MOTION_TOPIC = "Motion"  # topic


def drawn(results: Results) -> list[str]:
    """Return the recordings whose acceleration is drawn: with printed errors, or the first."""
    printed = results.shown(results.printed("acceleration_mae"))
    return printed or results.shown(results.listed("acceleration_mae"), 1)


def filtered_first(results: Results) -> list[str]:
    """Return the recordings whose IMU is drawn filtered before rotation, as printed errors need."""
    file = "accelerations_filtered_first.svg"
    names = results.printed("acceleration_mae")
    return [name for name in names if (results.figures / name / file).is_file()]


def errors(results: Results) -> pd.DataFrame:
    """Return the errors with and without IMU, and of zero, for recordings with a valid IMU."""
    rows = results.tables["acceleration_mae"]
    rows = rows[~rows["estimate"].str.startswith("euler")]
    rows = rows.assign(value=rows["mae"], zero=rows["zero_mae"])
    return with_zero(rows, "estimate", ["component"])


def beside_imu(results: Results) -> Iterator[str]:
    """Report the error of the encoders against the IMU, averaged over recordings with one."""
    rows = results.rows("acceleration_mae", estimate="encoders")
    if len(rows):
        mean = rows.groupby("component", sort=False)[["mae", "zero_mae"]].mean()
        errors, count = mean[:3], rows["recording"].nunique()
        yield say("motion.beside imu", mae=errors["mae"], zero=errors["zero_mae"], count=count)


def bands(results: Results) -> pd.DataFrame:
    """Return the differences from the IMU and their bands: three components a row."""
    rows = results.tables["acceleration_bands"]
    angular = rows["component"].str.startswith("r")
    rows = rows.assign(axes=np.where(angular, ANGULAR_LABEL, LINEAR_LABEL), held=100 * rows["held"])
    key, errors = ["range", "during", "axes"], ["rms", "filterpy_rms"]
    rows[errors] = rows[errors] ** 2
    means = rows.groupby([*key, "component"], sort=False)[[*errors, "held"]].mean()
    means[errors] = np.sqrt(means[errors])
    return means.groupby(key, sort=False).agg(list).reset_index()


def place(results: Results) -> Iterator[str]:
    """Report how far the IMU is from its described place, and which of the two is used."""
    table = results.tables["imu_calibration"]
    for arm, rows in table[table["quantity"] == "place"].groupby("robot", sort=False):
        off = 1e3 * (rows["value"] - rows["described"])
        pairs = [*zip(off, 1e3 * rows["std_error"], strict=True)]
        yield say("motion.place", arm=arm, off=pairs, ratio=rows["held_out"].iloc[0])


def innovations(results: Results) -> Iterator[str]:
    """Report how many channels pass the tests of the innovations."""
    table = results.tables["innovations"]
    tests = {test: table[test] == "yes" for test in ("consistent", "white")}
    channels = table.assign(count=1, **tests).groupby("estimate", sort=False)
    if len(table):
        passed = channels[["count", *tests]].sum().to_dict("index").items()
        widest, coloured = np.sqrt(table["colour"]).max(), not tests["white"].all()
        yield say("motion.innovations", passed=passed, widest=widest, coloured=coloured)


def judge_motion(results: Results) -> Verdict | None:
    """Judge the acceleration from encoders by its worst component, beside filterpy's plain filter;
    None without an IMU.
    """
    models, methods = {"encoders": "ours", "filterpy": "rival"}, results.rows("acceleration_mae")
    rival = Rival.beside("filterpy's plain filter", methods, "mae", "component", models)
    rows = results.rows("acceleration_mae", estimate="encoders")
    against = AgainstBaseline(rows, "mae", "zero_mae", "m/s²", 3, "component")
    if against.errors.empty:
        return None
    if str(against.worst.name).startswith("r"):
        against = replace(against, unit="rad/s²")
    return Verdict(
        topic=MOTION_TOPIC,
        state=against.state(tested=rival.better.empty),
        sentence=rival.after(say("motion.verdict", against=against), against.unit, 3),
        evidence=say("motion.evidence", against=against),
        drawing=against.drawing(),
        caption=say("motion.caption"),
        numbers=against.numbers("mean absolute error"),
    )
