"""The thesis's torque constants and offsets (Equations 6.5, 6.6), rebuilt from a recording."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ur5lib.records.dynamics import Torques
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import BLOCK_DURATION
from ur5lib.topics.thesis.current_based import (
    TorqueLine,
    current_on_torque,
    friction_torque,
    torque_on_current,
)

LINES = {"torque_on_current": torque_on_current, "current_on_torque": current_on_torque}


@dataclass(frozen=True)
class PublishedConstants:
    """published_constants.json: the lines of Equation 6.5 in both directions of regression; empty
    where currents or targets were not recorded.

    mean_torque: (6,) [Nm]; correlation: (6,), of torques with currents, with and without friction.
    """

    lines: dict[str, TorqueLine] = field(default_factory=dict)
    mean_torque: Array = field(default_factory=lambda: np.zeros(0))
    correlation: Array = field(default_factory=lambda: np.zeros(0))
    correlation_without_friction: Array = field(default_factory=lambda: np.zeros(0))


class CurrentTorque(NamedTuple):
    """What Figures 6.1 and 6.2 plot: received samples (N, 6) of a recording.

    current: measured [A]; rigid, total: torque at the targets without and with the printed friction
    (6.2) to (6.4) [Nm], NaN for a joint that never moves; block: (N,) labels of BLOCK_DURATION
    seconds.
    """

    current: Array
    rigid: Array
    total: Array
    block: Labels


def current_torque(robot: Robot, signals: Signals, torques: Torques) -> CurrentTorque | None:
    """Return a recording's measured currents and modelled torques, as Figures 6.1 and 6.2 of the
    thesis plot them.

    None for an arm without published friction, and where currents or targets were not recorded.
    """
    rigid, friction = torques.target.get(robot.chosen_model), robot.friction
    if friction is None or rigid is None or signals.actual_current is None:
        return None
    assert signals.target_qd is not None  # `rigid` needs targets
    received = ~signals.interpolated & np.isfinite(signals.actual_current).all(axis=1)
    qd = signals.target_qd[received]
    moves = (np.abs(qd) > friction.dead_zone).any(axis=0)
    rigid = np.where(moves, rigid[received], np.nan)
    running = np.floor(signals.time[received] / BLOCK_DURATION)
    return CurrentTorque(
        current=signals.actual_current[received],
        rigid=rigid,
        total=rigid + friction_torque(qd, friction),
        block=np.unique(running, return_inverse=True)[1],
    )


def published_constants(samples: CurrentTorque | None) -> PublishedConstants:
    """Return the lines of Equation 6.5 in both directions of regression; empty without samples."""
    if samples is None:
        return PublishedConstants()
    current, total, block = samples.current, samples.total, samples.block
    return PublishedConstants(
        lines={name: line(current, total, block) for name, line in LINES.items()},
        mean_torque=total.mean(axis=0),
        correlation=_correlation(current, total),
        correlation_without_friction=_correlation(current, samples.rigid),
    )


def _correlation(x: Array, y: Array) -> Array:
    """Return the correlation (6,) of the columns of (N, 6) with those of (N, 6)."""
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    with np.errstate(invalid="ignore"):
        return (x * y).sum(axis=0) / np.sqrt((x**2).sum(axis=0) * (y**2).sum(axis=0))
