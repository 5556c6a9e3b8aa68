"""Joint torques of every link model, and the controller's as the target of identification."""

from collections.abc import Iterator

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.carried import Carried, configured_payload
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, zero_phase_lowpass
from ur5lib.timeseries.sampling import THINNED_STEP, differentiate
from ur5lib.timeseries.segments import BLOCK_DURATION, by_segment, unbroken


def joint_torques(robot: Robot, load: Carried, signals: Signals, motion: Motion) -> Torques:
    """Return the torques of all link models.

    robot: under the recording's gravity; load: what it carries.
    """
    given = {model: LinkModel(robot.carrying(load.configured), model) for model in robot.models}
    states, fullest = (motion.q, motion.qd, motion.qdd), robot.fullest_model()
    measured = {name: model.inverse_dynamics(*states) for name, model in given.items()}
    target = signals.target_q, signals.target_qd, signals.target_qdd
    known = [values for values in target if values is not None]
    # what the payload adds to the one that the controller was given
    added = np.zeros_like(motion.q)
    if load.payload != load.configured:
        true = LinkModel(robot.carrying(load.payload), fullest)
        added = true.inverse_dynamics(*states) - measured[fullest]
    return Torques(
        time=signals.time,
        segment=signals.segment,
        interpolated=signals.interpolated,
        target={
            name: model.inverse_dynamics(*known) for name, model in given.items() if len(known) == 3
        },
        measured=measured,
        payload_torque=added,
    )


def torque_states(signals: Signals, motion: Motion) -> tuple[tuple[Array, Array, Array], bool]:
    """Return q, q̇, q̈ (N, 6) that go with `target_moment`, and whether they are its exact targets.

    Where targets were not recorded, the measured motion of the motors: the controller knows rotors
    and rigid links, but no vibration between them.
    """
    q, qd, qdd = signals.target_q, signals.target_qd, signals.target_qdd
    if q is None or qd is None or qdd is None:
        motor_qdd = by_segment(differentiate, motion.motor_qd, motion.segment, signals.period)
        return (motion.q, motion.motor_qd, motor_qdd), False
    return (q, qd, qdd), True


def comparable(rows: Array, signals: Signals, exact: bool, design: Butterworth) -> Array:
    """Return rows (N, M) of torques and regressors, NaN where a frame was interpolated.

    Unless the states are exact, all are low-passed alike: measured accelerations already are.
    """
    if not exact:
        rate = 1 / signals.period
        rows = by_segment(zero_phase_lowpass, rows, signals.segment, rate, *design)
    return np.where(signals.interpolated[:, None], np.nan, rows)


def rotor_samples(
    robot: Robot, signals: Signals, motion: Motion, design: Butterworth
) -> tuple[Array, Array, Array] | None:
    """Return the torque that rigid links leave, q̇ and q̈, (N, 6) each, NaN where interpolated.

    robot: under the recording's gravity; its links carry the payload that the controller was given:
    `target_moment` contains it. None where that was not recorded.
    """
    if signals.target_moment is None:
        return None
    states, exact = torque_states(signals, motion)
    model = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    residual = signals.target_moment - model.inverse_dynamics(*states)
    samples = comparable(np.hstack([residual, *states[1:]]), signals, exact, design)
    residual, qd, qdd = np.hsplit(samples, 3)
    return residual, qd, qdd


def torque_blocks(
    robot: Robot, signals: Signals, motion: Motion, design: Butterworth
) -> Iterator[tuple[Array, Array]]:
    """Yield regressors (n, 6, 66) and the controller's torques (n, 6), a block each two seconds.

    The torques are those of the bare arm: a payload that the controller was given is taken off.
    Nothing where `target_moment` was not recorded.
    """
    if signals.target_moment is None:
        return
    states, exact = torque_states(signals, motion)
    bare = LinkModel(robot, robot.chosen_model)
    loaded = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    load = loaded.inverse_dynamics(*states) - bare.inverse_dynamics(*states)
    columns = bare.regressor(*states).reshape(len(signals.time), -1)
    rows = np.hstack([columns, signals.target_moment - load])
    rows = comparable(rows, signals, exact, design)
    every = max(1, round(THINNED_STEP / signals.period))
    for part in unbroken(signals.segment, (signals.time // BLOCK_DURATION).astype(np.int64)):
        chosen = rows[part][::every]
        yield chosen[:, :-6].reshape(-1, 6, 66), chosen[:, -6:]
