"""Checks of the arm's mounting and its motors by the gravity that the currents balance.

What another mounting would explain far better is a contradiction. So is a torque constant far from
the maker's: of a right recording's joints that bear something, the current per torque of gravity is
that constant but for the gears' losses.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ur5lib.channels import Effort
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.currents import (
    MAX_CONSTANT_RATIO,
    MAX_SHARE_UNEXPLAINED,
    MIN_GRAVITY_TORQUE,
    MIN_STANDARD_ERRORS,
    held_gravity,
    moving_joints,
)
from ur5lib.checks.readings import in_order, readings
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import STANDARD_GRAVITY

# A difference of log-likelihoods. In right recordings of four arms, it is at most 31.
MIN_LEAD_OF_ARM = 40.0
MIN_SLOPE = 1e-3  # slope of a current that gravity does not show, relative to the maker's
STICTION_SHARE = 0.1  # share of a motor's largest torque that friction may carry at rest
# Another mounting with this share of the largest gain is not excluded.
MIN_SHARE_OF_LARGEST_GAIN = 0.5
MOUNTINGS = [  # gravity in the base frame, of arms on floors, ceilings and walls
    tuple(sign * STANDARD_GRAVITY if axis == own else 0.0 for own in range(3))
    for axis in range(3)
    for sign in (-1, 1)
]

Pair = tuple[int, int]  # of joints, from 0
Gravity = tuple[float, ...]  # [m/s²], base frame


class Cause(NamedTuple):
    """An explanation of the efforts that is better than the declared one, and by how much, as its
    check counts it. means, arm: as they would be under it.
    """

    finding: Finding
    gain: float
    means: BlockMeans
    arm: Robot


def likeliest(causes: Iterable[Cause]) -> Iterator[Finding]:
    """Yield the finding of the likeliest cause, if there is one."""
    for cause in sorted(causes, key=lambda own: -own.gain)[:1]:
        yield cause.finding


def of_measured(means: BlockMeans) -> BlockMeans:
    """Return the means with the measured effort as the only one."""
    return means.with_efforts(means.effort)


def gains_of_arms(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> dict[str, float]:
    """Return how much likelier others arms are, of as many joints."""
    order = in_order(arm)
    (declared,) = readings(means, [arm], [order])
    return {one.arm: one.score - declared.score for one in readings(means, others, [order])}


def foreign_mountings(means: BlockMeans, arm: Robot, brakes: bool, drives: bool) -> Iterator[Cause]:
    """Find the mountings under which gravity explains the currents far better, if there are any.

    Gravity from the other side looks like currents of the opposite sign; friction distinguishes the
    two. arm: with what it carries; brakes, drives: whether friction does so on a joint.
    """
    gains = gains_of_mountings(means, arm)
    least = max(MIN_LEAD_OF_ARM, MIN_SHARE_OF_LARGEST_GAIN * max(gains.values(), default=0.0))
    likely = [mounting for mounting, gain in gains.items() if gain > least]
    turned = [one for one in likely if np.dot(arm.gravity, one) < 0]
    if drives:
        likely = [one for one in likely if one not in turned]
    if likely:
        finding = _other_mounting(likely, bool(turned) and not brakes, means.measured)
        yield Cause(finding, gains[likely[0]], means, arm.mounted(likely[0]))


def _other_mounting(likely: Sequence[Gravity], by_sign: bool, measured: Effort) -> Finding:
    """Return the stop sign of mountings that fit; by_sign: the opposite sign would, too."""
    causes = " or ".join(map(mounting_as_cause, likely))
    if not by_sign:
        detail = (
            f"the {measured.quantity}s contradict the mounting: gravity explains them far better "
            f"with {causes}; correct `gravity`"
        )
        return contradiction("other mounting", "mounting", detail)
    detail = (
        f"gravity in {measured.channel} comes from the other side than declared: give the mounting "
        f"that fits, {causes}, or, if its sign is reversed, `{measured.channel}: opposite` under "
        "`units`"
    )
    return contradiction("other mounting or sign", "mounting", detail)


def mounting_as_cause(gravity: Gravity) -> str:
    """Return the line of a study that gives a mounting."""
    return f"`gravity: [{as_written(gravity, 'g')}]`"


def robots_as_cause(names: Iterable[str]) -> list[str]:
    """Return the lines of a study that name arms."""
    return [f"`robot: {name}`" for name in names]


def gains_of_mountings(means: BlockMeans, arm: Robot) -> dict[Gravity, float]:
    """Return how much likelier other mountings are that the torque constants confirm."""
    shown = {gravity: torque_constants(means, arm.mounted(gravity)) for gravity in MOUNTINGS}
    confirmed = [one for one, its in shown.items() if its.ratio and not its.foreign()]
    declared, *likelihoods = (
        readings(of_measured(means), [one], [in_order(arm)])[0].score
        for one in (arm, *map(arm.mounted, confirmed))
    )
    gains = {one: own - declared for one, own in zip(confirmed, likelihoods, strict=True)}
    return dict(sorted(gains.items(), key=lambda gain: -gain[1]))


@dataclass(frozen=True)
class Constants:
    """Torque constants by gravity, as multiples of the maker's, by joint from 0.

    low, high: with all that their errors allow; known: the maker's [Nm/A].
    """

    ratio: Mapping[int, float]
    low: Mapping[int, float]
    high: Mapping[int, float]
    known: Sequence[float]

    def foreign(self) -> dict[int, float]:
        """Return the ratios of the joints with foreign constants."""
        low, high = 1 / MAX_CONSTANT_RATIO, MAX_CONSTANT_RATIO
        joints = (j for j in self.ratio if self.high[j] < low or self.low[j] > high)
        return {joint: self.ratio[joint] for joint in joints}

    def away(self, joint: int) -> float:
        """Return how far a constant is from the maker's, as a logarithm."""
        return abs(math.log(self.ratio[joint]))


def torque_constants(means: BlockMeans, arm: Robot, name: str = "") -> Constants:
    """Return the torque constants by gravity of the joints that bear something.

    At rest, friction may carry a part of gravity; name: of the channel with the efforts, by default
    the measured one.
    """
    efforts = means.currents[name] if name else means.effort
    gravity, moves = means.gravity(arm), moving_joints(means)
    makers, ratios = np.array(arm.maker_torque_constants()), dict[int, list[float]]()
    for joint, size in enumerate(np.sqrt((gravity**2).mean(axis=0))):
        held = held_gravity(means, gravity, efforts, joint)
        shown = size > MIN_GRAVITY_TORQUE and held.unexplained < MAX_SHARE_UNEXPLAINED
        if shown and np.isfinite(makers[joint]):
            sticking = 0.0 if moves[joint] else STICTION_SHARE * arm.torque_limits()[joint] / size
            slope = held.slope * makers[joint]
            error = MIN_STANDARD_ERRORS * held.error * makers[joint] + sticking
            slopes = slope, slope + error, slope - error
            ratios[joint] = [1 / max(one, MIN_SLOPE) for one in slopes]
    ratio, low, high = ({joint: three[k] for joint, three in ratios.items()} for k in range(3))
    return Constants(ratio, low, high, makers.tolist())


def foreign_constants(
    means: BlockMeans, arm: Robot, others: Sequence[Robot], fitted: bool
) -> Iterator[Finding]:
    """Find torque constants that are not those of the arm's motors.

    Small ones may be a load, which the fit finds in recordings that are not fitted.
    """
    by_gravity = torque_constants(means, arm)
    off = {joint: ratio for joint, ratio in by_gravity.foreign().items() if fitted or ratio > 1}
    if off:
        joint = max(off, key=by_gravity.away)
        yield foreign_constant(
            joint, off[joint], by_gravity.known[joint], arm, fitting_arms(means, arm, others)
        )


def foreign_constant(
    joint: int, ratio: float, known: float, arm: Robot, fitting: Sequence[str] = ()
) -> Finding:
    """Return the stop sign of a joint's torque constant.

    joint: from 0; ratio: to the maker's [Nm/A]; fitting: arms that would fit.
    """
    cause = f"; {' or '.join(robots_as_cause(fitting))} would fit" if fitting else ""
    detail = (
        f"gravity's torque on joint {joint + 1} is {number(ratio * known, '.3g')} Nm per A of "
        f"actual_current, but the motors of {arm.name} have {number(known, '.3g')} Nm/A{cause}; "
        "correct `robot`, `payload`, or columns and units"
    )
    code = "foreign constant of known cause" if fitting else "foreign constant"
    return contradiction(code, "constants", detail, [joint + 1])


def fitting_arms(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> list[str]:
    """Return the other arms that the currents do not exclude: by gravity and torque constants."""
    gains = gains_of_arms(of_measured(means), arm, others)
    likely = [one for one in others if gains[one.name] > -MIN_LEAD_OF_ARM]
    alike = (one.name for one in likely if not torque_constants(means, one).foreign())
    return [name for name in alike if name != arm.name]
