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
    MAX_NAMED_RATIO,
    MAX_SHARE_UNEXPLAINED,
    MIN_GRAVITY_TORQUE,
    MIN_STANDARD_ERRORS,
    held_gravity,
    moving_joints,
    unheld,
)
from ur5lib.checks.readings import in_order, readings
from ur5lib.records.codes import CauseCode
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
    """A change of what is declared that explains the efforts better, with its finding.

    gain: by how much better, in the measure of the check that found it; means, arm: block means and
    arm after the change.
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
    """Return the means with the measured effort as the only one, without its target."""
    return means.with_efforts(means.effort)


def gains_of_arms(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> dict[str, float]:
    """Return, by name, by how much the log-likelihood of the efforts is larger with the gravity of
    each of `others` than with that of `arm`; all have the same number of joints.
    """
    order = in_order(arm)
    (declared,) = readings(means, [arm], [order])
    return {one.arm: one.score - declared.score for one in readings(means, others, [order])}


def foreign_mountings(means: BlockMeans, arm: Robot, brakes: bool, drives: bool) -> Iterator[Cause]:
    """Yield one cause that names the mountings under which gravity explains the currents far better
    than under the declared one, if there are any.

    Gravity from the opposite side looks like currents of the opposite sign; friction distinguishes
    the two. arm: with what it carries; brakes: whether friction brakes the motion of a joint, as it
    should; drives: whether it would drive that of a joint, which shows a wrong sign.
    """
    gains = gains_of_mountings(means, arm)
    least = max(MIN_LEAD_OF_ARM, MIN_SHARE_OF_LARGEST_GAIN * max(gains.values(), default=0.0))
    likely = [mounting for mounting, gain in gains.items() if gain > least]
    turned = [one for one in likely if np.dot(arm.gravity, one) < 0]
    if drives:
        likely = [one for one in likely if one not in turned]
    if likely:
        finding = other_mounting(likely, bool(turned) and not brakes, means.measured)
        yield Cause(finding, gains[likely[0]], means, arm.mounted(likely[0]))


def other_mounting(likely: Sequence[Gravity], by_sign: bool, measured: Effort) -> Finding:
    """Return the stop sign that names the mountings that fit; by_sign: whether currents of the
    opposite sign would explain gravity as well.
    """
    causes = " or ".join(map(mounting_as_cause, likely))
    if not by_sign:
        detail = (
            f"the {measured.quantity}s contradict the mounting: gravity explains them far better "
            f"with {causes}; correct `gravity`"
        )
        return contradiction(CauseCode.OTHER_MOUNTING, "mounting", detail)
    detail = (
        f"gravity in {measured.channel} comes from the other side than declared: give the mounting "
        f"that fits, {causes}, or, if its sign is reversed, `{measured.channel}: opposite` under "
        "`units`"
    )
    return contradiction(CauseCode.OTHER_MOUNTING_OR_SIGN, "mounting", detail)


def mounting_as_cause(gravity: Gravity) -> str:
    """Return the line of a study that gives a mounting."""
    return f"`gravity: [{as_written(gravity, 'g')}]`"


def robots_as_cause(names: Iterable[str]) -> list[str]:
    """Return the lines of a study that name arms."""
    return [f"`robot: {name}`" for name in names]


def gains_of_mountings(means: BlockMeans, arm: Robot) -> dict[Gravity, float]:
    """Return by how much the log-likelihood is larger under each other mounting than under the
    declared one, the largest first. Mountings under which a torque constant is far from the maker's
    are left out.
    """
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
    """Torque constants that the balance with gravity shows, in multiples of the maker's, by joint
    from 0.

    low, high: their bounds by all errors; known: the maker's constants [Nm/A] of all joints.
    """

    ratio: Mapping[int, float]
    low: Mapping[int, float]
    high: Mapping[int, float]
    known: Sequence[float]

    def foreign(self) -> dict[int, float]:
        """Return the ratios of the joints where both bounds are beyond MAX_CONSTANT_RATIO or its
        inverse.
        """
        low, high = 1 / MAX_CONSTANT_RATIO, MAX_CONSTANT_RATIO
        joints = (j for j in self.ratio if self.high[j] < low or self.low[j] > high)
        return {joint: self.ratio[joint] for joint in joints}

    def away(self, joint: int) -> float:
        """Return the size of the logarithm of a joint's ratio to the maker's constant."""
        return abs(math.log(self.ratio[joint]))


def torque_constants(means: BlockMeans, arm: Robot, name: str = "") -> Constants:
    """Return the torque constants of the joints that bear gravity, by the currents that balance it.

    The bounds of a joint at rest are wider: friction may carry a part of gravity. name: the channel
    of the efforts, empty for the measured one.
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

    fitted: whether the recording has the role `fit`; in others, constants below the maker's are no
    finding: they may be a load, which a run estimates.
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
        unheld("actual_current", joint)
        if ratio > MAX_NAMED_RATIO
        else f"gravity's torque on joint {joint + 1} is {number(ratio * known, '.3g')} Nm per A of "
        f"actual_current, but the motors of {arm.name} have {number(known, '.3g')} Nm/A{cause}; "
        "correct `robot`, `payload`, or columns and units"
    )
    one, other = CauseCode.FOREIGN_CONSTANT_OF_KNOWN_CAUSE, CauseCode.FOREIGN_CONSTANT
    return contradiction(one if fitting else other, "constants", detail, [joint + 1])


def fitting_arms(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> list[str]:
    """Return the names of the other arms that the currents exclude neither by likelihood nor by
    torque constants.
    """
    gains = gains_of_arms(of_measured(means), arm, others)
    likely = [one for one in others if gains[one.name] > -MIN_LEAD_OF_ARM]
    alike = (one.name for one in likely if not torque_constants(means, one).foreign())
    return [name for name in alike if name != arm.name]
