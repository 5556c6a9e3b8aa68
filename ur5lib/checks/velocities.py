"""Checks of velocities by the slopes of their positions: their unit and columns, and the clock."""

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.checks.channels import (
    DERIVATIVES,
    MAX_SLOPE,
    MIN_SLOPE,
    are_recorded,
    slopes_over_velocities,
)
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.timeseries.arrays import Array

# A velocity this far from its position's slope is misread.
MIN_VELOCITY_RATIO, MAX_VELOCITY_RATIO = 0.5, 2.0
DEGREE = math.pi / 180
# The ratios of most joints differ by less than this where one factor explains them. Of a Baxter,
# whose velocities are filtered, one joint of seven differs by more.
MAX_SPREAD, MOST_JOINTS_ALIKE = 0.05, 0.75
MAX_PACE = 10.0  # a clock's, or its inverse; beyond it, a unit is wrong


def misread_velocities(robot: pd.DataFrame, period: float) -> Iterator[Finding]:
    """Find velocities in another unit or column than their positions, and a clock at another pace
    than the one of the velocities; period: [s].
    """
    for below, above in DERIVATIVES[:2]:
        if are_recorded(robot, below, above):
            by_joint = slopes_over_velocities(robot, below, above, period)
            slopes = np.array([*by_joint.values()])
            wrong = slopes[(slopes <= MIN_VELOCITY_RATIO) | (slopes >= MAX_VELOCITY_RATIO)]
            if (ratio := common_ratio(slopes)) is not None:
                yield _one_factor(below, above, ratio)
            elif len(wrong) > len(slopes) / 2:
                times = number(np.median(wrong), ".3g")
                detail = (
                    f"{above} is not the velocity of {below}: the slopes of {below} are {times} "
                    "times as large; correct columns and units"
                )
                yield contradiction(CauseCode.NO_VELOCITY, "velocity", detail)


def common_ratio(slopes: Array) -> float | None:
    """Return the positive ratio of slopes to velocities that most joints have in common, None if
    they have none, or the right one.
    """
    if len(slopes) < 2 or slopes.min() <= 0:
        return None
    ratio = float(np.median(slopes))
    alike = np.mean(np.abs(slopes / ratio - 1) < MAX_SPREAD) > MOST_JOINTS_ALIKE
    return ratio if alike and not MIN_SLOPE <= ratio <= MAX_SLOPE else None


def _one_factor(below: str, above: str, ratio: float) -> Finding:
    """Return the stop sign of positions with slopes `ratio` times their velocities on all joints:
    one is in degrees, or the clock has another pace.
    """
    for name, unit, factor in ((below, "deg", 1 / DEGREE), (above, "deg/s", DEGREE)):
        if abs(ratio / factor - 1) < MAX_SPREAD:
            detail = f"{name} is in {unit}: give its unit, `{name}: {unit}`, under `units`"
            return contradiction(CauseCode.IN_DEGREES, "velocity", detail)
    times = number(ratio, ".3g")
    seen = f"on all joints, the slopes of {below} are {times} times as large as {above}"
    if not 1 / MAX_PACE < ratio < MAX_PACE:
        detail = f"{seen}; correct columns and units"
        return contradiction(CauseCode.NO_VELOCITY, "velocity", detail)
    pace = number(max(ratio, 1 / ratio), ".3g")
    cause, how = (CauseCode.FAST_CLOCK, "fast") if ratio < 1 else (CauseCode.SLOW_CLOCK, "slow")
    detail = (
        f"the clock is {pace} times too {how}: {seen}; correct `rate`, or give `time: [{times}]` "
        f"under `units`; if the clock is right, correct the unit of {above}"
    )
    return contradiction(cause, "velocity", detail)
