"""The controller's torques as samples of fits: residuals from rigid links, and regressor rows."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, zero_phase_lowpass
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import BLOCK_DURATION, by_segment, unbroken

# Rows of the controller's torques, which have no noise to average, are this far apart.
ROW_STEP = 0.032  # s

Block = tuple[Array, Array]  # regressors (N, n, P) and torques (N, n) [Nm]
RotorSamples = tuple[Array, Array, Array]  # residual [Nm], q̇ and q̈, (N, n) each
OfMotion = Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class CommandedRun:
    """A recording with the controller's torques, and the dynamics of the rigid links under its
    gravity.

    bare, loaded: functions of q, q̇ and q̈ that return torques (N, n) [Nm], without and with the
    payload that the controller was given, which `target_moment` contains; regressor: returns Y (N,
    n, P) of these, without payload.
    """

    signals: Signals
    motion: Motion
    bare: OfMotion
    loaded: OfMotion
    regressor: OfMotion


def rotor_samples(run: CommandedRun, design: Butterworth) -> RotorSamples | None:
    """Return the controller's torque less that of rigid links, q̇ and q̈, (N, n) each, NaN where
    interpolated.

    design: low-pass. None if `target_moment` was not recorded.
    """
    if run.signals.target_moment is None:
        return None
    states, exact = torque_states(run.signals, run.motion)
    residual = run.signals.target_moment - run.loaded(*states)
    samples = comparable(np.hstack([residual, *states[1:]]), run.signals, exact, design)
    residual, qd, qdd = np.hsplit(samples, 3)
    return residual, qd, qdd


def torque_blocks(run: CommandedRun, design: Butterworth) -> Iterator[Block]:
    """Yield regressors and the controller's torques [Nm] of the arm without payload, in blocks of
    BLOCK_DURATION.

    design: low-pass. Nothing if `target_moment` was not recorded.
    """
    signals = run.signals
    if signals.target_moment is None:
        return
    states, exact = torque_states(signals, run.motion)
    load = run.loaded(*states) - run.bare(*states)
    regressor = run.regressor(*states)
    joints, parameters = regressor.shape[1:]
    rows = np.hstack([regressor.reshape(len(regressor), -1), signals.target_moment - load])
    rows = comparable(rows, signals, exact, design)
    every = max(1, round(ROW_STEP / signals.period))
    for part in unbroken(signals.segment, (signals.time // BLOCK_DURATION).astype(np.int64)):
        chosen = rows[part][::every]
        yield chosen[:, :-joints].reshape(-1, joints, parameters), chosen[:, -joints:]


def torque_states(signals: Signals, motion: Motion) -> tuple[tuple[Array, Array, Array], bool]:
    """Return (q, q̇, q̈) (N, n) to which `target_moment` belongs, and whether they are its exact
    targets.

    Where targets were not recorded, they are the measured motion of the motors: the controller
    models rotors and rigid links, but no vibration between them.
    """
    q, qd, qdd = signals.target_q, signals.target_qd, signals.target_qdd
    if q is None or qd is None or qdd is None:
        motor_qdd = by_segment(differentiate, motion.motor_qd, motion.segment, signals.period)
        return (motion.q, motion.motor_qd, motor_qdd), False
    return (q, qd, qdd), True


def comparable(rows: Array, signals: Signals, exact: bool, design: Butterworth) -> Array:
    """Return rows (N, M) of torques and regressors, NaN where a frame was interpolated.

    Unless the states are exact (`torque_states`), all are low-passed alike: measured accelerations
    already are.
    """
    if not exact:
        rate = 1 / signals.period
        rows = by_segment(zero_phase_lowpass, rows, signals.segment, rate, *design)
    return np.where(signals.interpolated[:, None], np.nan, rows)
