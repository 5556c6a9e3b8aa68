"""What of a recording tells of the controller's torque: states, and rows to compare with it."""

import numpy as np
import pandas as pd

from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

TARGETS = ("target_q", "target_qd", "target_qdd")
MEASURED = ("q", "qd", "qdd")


def torque_states(signals: pd.DataFrame, motion: pd.DataFrame) -> tuple[list[Array], bool]:
    """q, q̇, q̈ (N, 6) that go with `target_moment`, and whether they are its exact targets.

    The measured motion stands in where targets were not recorded.
    """
    exact = all(f"{name}_0" in signals for name in TARGETS)
    source, names = (signals, TARGETS) if exact else (motion, MEASURED)
    return [channel(source, name) for name in names], exact


def comparable(rows: Array, signals: pd.DataFrame, exact: bool, order: int, cutoff: float) -> Array:
    """Rows (N, M) of torques and regressors, NaN where a frame was interpolated.

    Unless the states are exact, all are low-passed alike [Hz]: measured accelerations already are.
    """
    if not exact:
        rate, segment = 1 / period(signals), signals["segment"].to_numpy()
        rows = by_segment(lambda x: zero_phase_lowpass(x, rate, order, cutoff), rows, segment)
    return np.where(signals["interpolated"].to_numpy()[:, None], np.nan, rows)
