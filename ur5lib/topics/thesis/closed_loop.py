"""The joints in closed loop, with published gains and with estimated ones."""

from collections.abc import Mapping

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.carried import configured_payload
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import by_segment
from ur5lib.topics.thesis import gains as closed_loop
from ur5lib.topics.thesis.gains import Tracking
from ur5lib.topics.thesis.records import ClosedLoop, GainSummary, JointGains

Gains = tuple[Array, Array]


def closed_loops(signals: Signals, robot: Robot) -> tuple[ClosedLoop, GainSummary]:
    """Return the simulated motion of the joints in closed loop, with published and with estimated
    gains, and a summary of the estimated gains; both empty if targets were not recorded.

    robot: under the recording's gravity.
    """
    tracking = tracking_of(signals)
    if tracking is None:
        return ClosedLoop(time=signals.time, segment=signals.segment), GainSummary()
    joints, published = closed_loop.estimate_gains(tracking), published_gains(robot)
    sets = published | {"estimated": best(joints)}
    return simulated(signals, robot, tracking, sets), gain_summary(tracking, joints, published)


def tracking_of(signals: Signals) -> Tracking | None:
    """Return targets and measured motion; None if one of them was not recorded."""
    recorded = {
        name: getattr(signals, name)
        for name in ("target_q", "target_qd", "target_qdd", "actual_q", "actual_qd")
    }
    if any(values is None for values in recorded.values()):
        return None
    return Tracking(**recorded, segment=signals.segment, period=signals.period)


def published_gains(robot: Robot) -> dict[str, Gains]:
    """Return gains K0 [1/s²] and K1 [1/s] by the model they were published for, (6,) each."""
    return {
        name: (np.array(gains.position), np.array(gains.velocity))
        for name, gains in robot.closed_loop_gains.items()
    }


def gain_summary(
    tracking: Tracking, joints: list[JointGains], published: Mapping[str, Gains]
) -> GainSummary:
    """Return the estimated gains and the costs of published ones."""
    noise = np.stack([joint.noise for joint in joints])
    costs = {
        name: closed_loop.tracking_cost(tracking, *gains, noise)
        for name, gains in published.items()
    }
    return GainSummary(joints, costs)


def best(joints: list[JointGains]) -> Gains:
    """Return the gains of least cost of each joint, for a simulation; the data determine only their
    ranges.
    """
    position = np.array([joint.position.best for joint in joints])
    return position, np.array([joint.velocity.best for joint in joints])


def simulated(
    signals: Signals, robot: Robot, tracking: Tracking, sets: Mapping[str, Gains]
) -> ClosedLoop:
    """Return q̂, q̂̇ and q̂̈ for each set of gains, and each link model's torque for its own gains."""
    states = {name: simulated_states(tracking, gains) for name, gains in sets.items()}
    q, qd, qdd = ({name: own[k] for name, own in states.items()} for k in range(3))
    given = robot.carrying(configured_payload(signals))
    return ClosedLoop(
        time=signals.time,
        segment=signals.segment,
        q=q,
        qd=qd,
        qdd=qdd,
        torque={
            name: LinkModel(given, name).inverse_dynamics(*motion)
            for name, motion in states.items()
            if name in robot.models
        },
    )


def simulated_states(tracking: Tracking, gains: Gains) -> Array:
    """Return q̂, q̂̇ and q̂̈ (3, N, 6) of the closed loop, NaN where targets are unknown.

    Joint by joint, which takes less memory: the loop does not couple them.
    """
    targets = tracking.target_q, tracking.target_qd, tracking.target_qdd
    states = np.empty((3, *tracking.target_q.shape))
    for joint in range(tracking.target_q.shape[1]):
        own = [gain[joint : joint + 1] for gain in gains]

        def simulate(rows: Array, own: list[Array] = own) -> Array:
            q, qd, qdd = np.hsplit(rows, 3)
            return np.hstack(closed_loop.simulate_closed_loop(q, qd, qdd, tracking.period, *own))

        rows = np.stack([target[:, joint] for target in targets], axis=1)
        states[:, :, joint] = by_segment(simulate, rows, tracking.segment).T
    return states
