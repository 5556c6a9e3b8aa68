"""Means of a robot table's channels over short blocks, for checks of the arm's statics."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import pandas as pd

from ur5lib.channels import EFFORT_CHANNELS, Effort
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels, Mask

BLOCK_LENGTH = 0.1  # s; a block has this length
DECORRELATION_TIME = 0.4  # s; errors this far apart count as independent
# More of a block's frames may not be lost. In some recordings, half are.
MAX_SHARE_FILLED = 0.6
FULL_FRICTION_SPEED = 0.02  # rad/s; faster joints have their full friction
MIN_RUBBING = 20  # blocks in motion that show a joint's slopes
# Two joints move alike if their velocities correlate by at least this.
MIN_CORRELATION_OF_ALIKE = 0.99
SMALLEST_SIZE = 1e-300  # keeps divisors above zero
# Relative to the regressor's square. It keeps first moments small that nothing determines.
FIRST_MOMENT_PRIOR = 1e-4
ALL = slice(None)


@dataclass(frozen=True)
class BlockMeans:
    """Means of a recording's channels over M blocks.

    q, qd, qdd: (M, 6) [rad, rad/s, rad/s²]; torque: `target_moment` (M, 6) [Nm], None if it was not
    recorded; currents: efforts (M, 6) by channel, as far as recorded: `target_current` and
    `actual_current` [A], or `actual_torque` [Nm]; offset: whether each effort may have a constant
    offset, so that only its changes are evidence; independent: number of independent errors per
    block; time: when the blocks start (M,) [s], and segment: their labels (M,); both None for
    postures and for a part of the blocks.
    """

    q: Array
    qd: Array
    qdd: Array
    torque: Array | None
    currents: dict[str, Array]
    offset: bool = False
    independent: float = BLOCK_LENGTH / DECORRELATION_TIME
    time: Array | None = None
    segment: Labels | None = None

    def part(self, rows: Labels | slice = ALL, columns: Sequence[int] | slice = ALL) -> Self:
        """Return the means of some blocks (rows), with the joints in another order (columns).

        They have no `torque`, `time` and `segment`.
        """
        q, qd, qdd = (values[rows][:, columns] for values in (self.q, self.qd, self.qdd))
        currents = {name: values[rows][:, columns] for name, values in self.currents.items()}
        return type(self)(q, qd, qdd, None, currents, self.offset, self.independent)

    @property
    def measured(self) -> Effort:
        """Return which effort was measured."""
        return Effort.measured_in({f"{name}_0" for name in self.currents})

    @property
    def effort(self) -> Array:
        """Return the measured efforts (M, n), currents [A] or torques [Nm]."""
        return self.currents[self.measured.channel]

    def has_efforts(self) -> bool:
        """Return whether efforts were measured."""
        return self.measured.channel in self.currents

    def with_efforts(self, efforts: Array) -> Self:
        """Return the means with these measured efforts (M, n), and no targets of them."""
        return replace(self, currents={self.measured.channel: efforts})

    def gravity(self, arm: Robot) -> Array:
        """Return the torque (M, 6) [Nm] that balances the gravity of an arm, payload included."""
        return gravity_torque(arm, arm.chosen_model, self.q)

    def beside_inertia(self, torque: Array) -> Array:
        """Return what a least-squares fit of the accelerations leaves of torques (M, 6)."""
        return torque - self.qdd @ np.linalg.lstsq(self.qdd, torque, rcond=None)[0]

    def log_likelihood(self, variance: Array) -> Array:
        """Return the log-likelihoods of errors with these mean squares, of which only `independent`
        per block count.
        """
        return -len(self.q) * self.independent / 2 * np.log(variance)

    def friction(self, joint: int) -> Array:
        """Return columns (M, 2) of dry and viscous friction of a joint, from 0, for coefficients to
        be fitted.
        """
        qd = self.qd[:, joint]
        return np.column_stack([np.tanh(qd / FULL_FRICTION_SPEED), qd])

    def rubbing(self, joint: int) -> Mask:
        """Return in which blocks (M,) a joint, from 0, moves; all blocks if it moves in few.

        At rest, its friction may have any part of its size, so that one long pause would change a
        fitted slope.
        """
        moves = np.abs(self.qd[:, joint]) > FULL_FRICTION_SPEED
        return moves if moves.sum() >= MIN_RUBBING else np.ones_like(moves)

    def move_alike(self, joints: Sequence[int]) -> bool:
        """Return whether the motions of two joints, from 0, are proportional."""
        one, other = self.qd[:, [*joints]].T
        least = MIN_CORRELATION_OF_ALIKE * np.linalg.norm(one) * np.linalg.norm(other)
        return bool(abs(one @ other) > least > 0)

    def without_gravity(self, joint: int, accelerations: Array) -> Array:
        """Return the regression columns (M, n) of a joint's effort other than gravity: friction,
        the accelerations and, if `offset`, a constant.
        """
        offset = np.ones((len(self.q), int(self.offset)))
        return np.column_stack([self.friction(joint), accelerations, offset])


def block_means(
    robot: pd.DataFrame, period: float, currents: Sequence[str] = EFFORT_CHANNELS
) -> BlockMeans:
    """Return the means over blocks within one segment, of which at most MAX_SHARE_FILLED is
    interpolated.

    robot: repaired, on a uniform grid with this period [s]; currents: channels of efforts.
    """
    names = ("actual_q", "actual_qd", "target_moment", *currents)
    channels = {name: channel(robot, name) for name in names if f"{name}_0" in robot}
    channels.setdefault("actual_qd", np.gradient(channels["actual_q"], period, axis=0))
    rows = _blocks(robot, [*channels.values()], round(BLOCK_LENGTH / period))
    means = {name: values[rows].mean(axis=1) for name, values in channels.items()}
    first, last = (channels["actual_qd"][rows[:, end]] for end in (0, -1))
    return BlockMeans(
        q=means.pop("actual_q"),
        qd=means.pop("actual_qd"),
        qdd=(last - first) / (period * (rows.shape[1] - 1)),
        torque=means.pop("target_moment", None),
        currents=means,
        time=robot["time"].to_numpy(float)[rows[:, 0]],
        segment=robot["segment"].to_numpy()[rows[:, 0]],
    )


def size(values: Array) -> float:
    """Return the root of the sum of squares, above zero."""
    return float(np.linalg.norm(values)) + SMALLEST_SIZE


def combination(columns: Array, values: Array, weights: Sequence[float]) -> tuple[float, float]:
    """Return a weighted sum of the first least-squares coefficients, and its standard error.

    columns: (M, n) over blocks; values: (M,); weights: one for each of the first coefficients.
    """
    inverse = np.linalg.pinv(columns)
    solution, weight = inverse @ values, np.asarray(weights)
    noise = np.std(values - columns @ solution) * np.sqrt(DECORRELATION_TIME / BLOCK_LENGTH)
    first = inverse[: len(weight)]
    return float(weight @ solution[: len(weight)]), float(noise * np.linalg.norm(weight @ first))


def fitted_load(columns: Array, torque: Array) -> tuple[float, float]:
    """Return the mass [kg] of a load by least squares, and the norm of the torque that it leaves.

    columns: (n, 4), as `statics.load_torque` returns them; torque: (n,); both divided by the same
    scale.
    """
    prior = FIRST_MOMENT_PRIOR * len(columns) * np.diag([0.0, 1.0, 1.0, 1.0])
    load = np.linalg.solve(columns.T @ columns + prior, columns.T @ torque)
    return float(load[0]), size(torque - columns @ load)


def _blocks(robot: pd.DataFrame, channels: list[Array], length: int) -> Labels:
    """Return the row numbers (M, length) of the blocks that are finite, within one segment and
    mostly received; length: in rows, at least 3.
    """
    length = max(3, length)
    rows = np.arange(len(robot) // length * length).reshape(-1, length)
    segment, filled = (robot[name].to_numpy()[rows] for name in ("segment", "interpolated"))
    finite = np.all([np.isfinite(values).all(axis=1) for values in channels], axis=0)
    complete = finite[rows].all(axis=1)
    unsplit, received = np.ptp(segment, axis=1) == 0, filled.mean(axis=1) <= MAX_SHARE_FILLED
    return rows[complete & unsplit & received]
