"""Checks of order and sign of efforts, and of the arm, by the whole motion.

What would explain the efforts better is a contradiction where one of two explanations says so, that
of the declared links or, where nobody knows them, that of any links, and the other is not against.
The limits are set on the right logs of `benchmarks/false_stops.py`. How far a right log is from a
limit on its other side is what it can show.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ur5lib.channels import CURRENT, TARGET_CURRENT
from ur5lib.checks.arm import (
    MOUNTINGS,
    Cause,
    Gravity,
    Pair,
    foreign_constant,
    other_mounting,
    robots_as_cause,
    torque_constants,
)
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.currents import exchanged_efforts, moving_joints, rubbing_joints
from ur5lib.checks.readings import exchanged_order, in_order
from ur5lib.checks.whole_motion import Explained, Lead, Misfit, WholeMotion, lead
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number, numbered
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

MIN_ERRORS = 2.5  # a lead of fewer standard errors over stretches may be chance
# By any links, what is declared may lead a change by this much without being against it.
MAX_LEAD_AGAINST = 0.1
# In right logs, exchanged efforts never lead beyond chance, exchanged joints by 0.27 at most by
# the declared links, by 0.36 by any. Where friction is of no described form, they lead by 0.72 and
# 0.34 in short logs.
MIN_LEAD_OF_EFFORTS = 0.15
CLEAR_LEAD_OF_JOINTS = 0.8  # from this lead on by the declared links, any links need not agree
MIN_LEAD_OF_JOINTS, MIN_LEAD_OF_JOINTS_BY_ANY_LINKS = 0.35, 0.5
# This is by declared links where two joints move alike, but for a UR's, which are certain: any
# links would explain either order of the joints. A right log of a KUKA LWR leads by 1.2, simulated
# ones by 0.6.
MIN_LEAD_OF_ALIKE = 2.5
# A turned joint leads by at most 0.31 in right logs by the declared links. By any, the mean over
# all joints is at most 0.05.
MIN_LEAD_OF_SIGN, MIN_LEAD_OF_SIGN_BY_ANY_LINKS = 0.5, 0.15
# By any links, another mounting leads by at most 0.07 in right logs of twelve arms, and by 0.44 to
# 4.2 where gravity is declared from the side.
MIN_LEAD_OF_MOUNTING = 0.35
# Friction drives the motion beyond this many standard errors; in right logs, there are at most 0.6.
MIN_ERRORS_OF_FRICTION = 3.0
# Leads with what the arm carries, in right logs at most 0.26, and with any load.
MIN_LEAD_OF_ARM, MIN_LEAD_OF_LOADED_ARM = 0.3, 0.1
# By more, any links lead the declared ones only where a joint's description is in doubt. In right
# logs of arms that are described with all that they have, they lead by at most 0.6 beyond chance.
MAX_LEAD_OF_ANY_LINKS = 0.8
# Ratios to the maker's constant, the best one and the lowest by its errors. In right logs, they
# are at most RIGHT_RATIO and 1.00.
MIN_RATIO_OF_WEAK, MIN_LOW_OF_WEAK, RIGHT_RATIO = 1.18, 1.06, 1.05
# Such a current lacks this [A] beyond those of right logs; 0.15 A that vary once per turn look like
# more in 7 of 432 logs of a UR3e.
MIN_LACKING_CURRENT = 0.17
# Ratio to the maker's constant, over the median of the other joints'. Where it is surely above
# one by gravity (MIN_LOW_OF_WEAK), no right log has such a ratio.
MIN_RATIO_TO_OTHERS = 1.3
# Lead and mass [kg] of a load that no target shows. Right logs of UR's lead by at most 0.8, those
# with 3 kg by 2.4.
MIN_LEAD_OF_LOAD, MIN_LOAD, MIN_ERRORS_OF_LOAD = 1.0, 1.0, 5.0
MIN_MOVING_JOINTS = 3  # so many moving joints distinguish arms
MIN_BLOCKS = (
    90  # a log of so many blocks shows arms, or joints exchanged in all channels, in ten stretches
)


class Limits(NamedTuple):
    """The leads from which on an explanation counts as likelier: with the declared links, and with
    any links.
    """

    by_links: float
    by_any_links: float


OF_EFFORTS = Limits(MIN_LEAD_OF_EFFORTS, MIN_LEAD_OF_EFFORTS)
OF_JOINTS = Limits(MIN_LEAD_OF_JOINTS, MIN_LEAD_OF_JOINTS_BY_ANY_LINKS)
OF_ALIKE = Limits(MIN_LEAD_OF_ALIKE, np.inf)


class MotionChecks:
    """Checks of an arm's efforts by its whole motion: which arm, order of joints, signs and load
    explain them best. The arm is one with what it carries.
    """

    def __init__(self, means: BlockMeans, arm: Robot, rubs: bool) -> None:
        """Take the means over blocks; rubs: whether friction brakes what the efforts drive."""
        self.means, self.arm, self.rubs = means, arm, rubs
        self.motion = WholeMotion(means, arm)
        self.moving = np.flatnonzero(moving_joints(means)).tolist()

    def is_long(self) -> bool:
        """Return whether the log is long enough for any links, by which alone it is explained where
        no gravity is described. Their many parameters explain a short one with any sign.
        """
        return self.arm.tells_gravity() or len(self.means.q) >= MIN_BLOCKS

    @cached_property
    def declared(self) -> Explained:
        """Return how well the declared links, and any links, explain the efforts as recorded."""
        return self.motion.explained()

    @cached_property
    def exchanged_efforts(self) -> dict[Pair, Explained]:
        """Return, by pair of moving joints, how well the efforts are explained with those of the
        two exchanged.
        """
        torque, pairs = self.motion.torque, combinations(self.moving, 2)
        return {pair: self.motion.explained(torque[:, self._order(pair)]) for pair in pairs}

    @cached_property
    def exchanged_joints(self) -> dict[Pair, Explained]:
        """Return, by pair of moving joints, how well the efforts are explained with all channels of
        the two exchanged.
        """
        return {
            pair: WholeMotion(self.means.part(columns=self._order(pair)), self.arm).explained()
            for pair in combinations(self.moving, 2)
        }

    @cached_property
    def turned(self) -> dict[int, Explained]:
        """Return, by moving joint, how well the efforts are explained with the opposite sign on
        that joint.
        """
        torque = self.motion.torque
        return {j: self.motion.explained(torque * self._signs([j])) for j in self.moving}

    @cached_property
    def friction(self) -> dict[int, float]:
        """Return the friction of moving joints, from 0, at their usual speed, in standard errors:
        the larger of the values fitted with the declared links and with any links. It is negative
        where friction would drive the motion.
        """
        if not self.rubs or not self.is_long():
            return {}
        rubbing, errors = rubbing_joints(self.arm), self.motion.friction_in_errors()
        return {joint: float(errors[joint]) for joint in self.moving if rubbing[joint]}

    def braked(self) -> set[int]:
        """Return the joints, from 0, where friction brakes the motion, as it should."""
        return {j for j, own in self.friction.items() if own > MIN_ERRORS_OF_FRICTION}

    def driven_by_friction(self) -> list[int]:
        """Return the joints, from 0, where friction would drive the motion."""
        return [j for j, own in self.friction.items() if own < -MIN_ERRORS_OF_FRICTION]

    def gain(self, other: Explained) -> float:
        """Return by how much `other` misses less than the declared explanation, as the mean over
        all joints of logarithms of mean squares.
        """
        return lead(other.by_known, self.declared.by_known, self.motion.joints).size

    def gain_of_arm(self, arm: Robot) -> float:
        """Return the `gain` of another arm, or of this one with another mounting."""
        return self.gain(WholeMotion(self.means, arm).explained())

    def gain_of_opposite(self) -> float:
        """Return the `gain` of the opposite sign on all efforts."""
        return self.gain(self.motion.explained(-self.motion.torque))

    def exchanges_of_joints(self) -> Iterator[Cause]:
        """Yield a cause for each pair of joints that explain the efforts better with all channels
        exchanged.
        """
        if len(self.means.q) < MIN_BLOCKS:
            return
        for pair, other in self.exchanged_joints.items():
            if are_exchanged(other, self.declared, pair):
                means = self.means.part(columns=self._order(pair))
                detail = (
                    f"joints {pair[0] + 1} and {pair[1] + 1} are exchanged: their motion explains "
                    "the currents or torques far better with all their columns swapped; correct "
                    "the columns"
                )
                joints = [pair[0] + 1, pair[1] + 1]
                finding = contradiction(CauseCode.EXCHANGED_JOINTS, "order", detail, joints)
                yield Cause(finding, self.gain(other), means, self.arm)

    def exchanges_of_efforts(self) -> Iterator[Cause]:
        """Yield a cause for each pair of joints where the motion of each explains the other's
        efforts better.
        """
        if not self.is_long():
            return
        for pair, other in self.exchanged_efforts.items():
            if have_exchanged_efforts(other, self.declared, pair):
                efforts = self.means.effort[:, self._order(pair)]
                means = self.means.with_efforts(efforts)
                finding = exchanged_efforts(pair, self.means.measured)
                yield Cause(finding, self.gain(other), means, self.arm)

    def turned_by_links(self) -> Iterator[Cause]:
        """Yield one cause with the joints where the declared links explain efforts of the opposite
        sign better.

        If the links are unknown, it has the one joint with which any links then explain the efforts
        of all joints best. Joints where friction brakes the motion have the right sign and are left
        out.
        """
        if not self.is_long():
            return
        braked = self.braked()
        others = {j: own for j, own in self.turned.items() if j not in braked}
        joints = [j for j, other in others.items() if is_turned(other, self.declared, j)]
        if not self.arm.tells_gravity():
            joints = [j for j in joints if j == max(joints, key=self._gain_of_sign)]
        if joints:
            signs = self._signs(joints)
            other = self.motion.explained(self.motion.torque * signs)
            means = self.means.with_efforts(self.means.effort * signs)
            yield Cause(self._as_turned(joints, by_links=True), self.gain(other), means, self.arm)

    def turned_by_friction(self) -> Iterator[Finding]:
        """Find joints where friction, by the sign of the efforts, drives the motion instead of
        braking it.
        """
        if joints := self.driven_by_friction():
            yield self._as_turned(joints, by_links=False)

    def weak_currents(self) -> Iterator[Finding]:
        """Find the current of a UR's motor that is too small for the gravity that it balances.

        It is no finding where any links explain the joint far better: then, its description is in
        doubt.
        """
        if not self.arm.has_ur_motors() or not self.arm.tells_gravity():
            return
        shown = torque_constants(self.means, self.arm)
        held = np.sqrt((self.means.gravity(self.arm) ** 2).mean(axis=0)) / shown.known  # A
        weak = [
            joint
            for joint in shown.ratio.keys() & {*self.moving}
            if shown.ratio[joint] > MIN_RATIO_OF_WEAK
            and shown.low[joint] > MIN_LOW_OF_WEAK
            and (1 / RIGHT_RATIO - 1 / shown.ratio[joint]) * held[joint] > MIN_LACKING_CURRENT
        ]
        declared = self.declared.by_links
        for joint in sorted(weak, key=lambda own: -shown.ratio[own])[:1]:
            ahead = declared and lead(self.declared.by_any_links, declared, [joint])
            if ahead and ahead.size < MAX_LEAD_OF_ANY_LINKS:
                yield foreign_constant(joint, shown.ratio[joint], shown.known[joint], self.arm)

    def scaled_current(self) -> Iterator[Finding]:
        """Warn of a current of a UR's motor that is too small compared with those of other joints
        that bear gravity. It is no stop sign, since any links would explain it, too.
        """
        if not self.arm.has_ur_motors() or not self.arm.tells_gravity():
            return
        shown = torque_constants(self.means, self.arm)
        for joint, ratio in shown.ratio.items():
            others = [own for other, own in shown.ratio.items() if other != joint]
            if not others or shown.low[joint] < MIN_LOW_OF_WEAK:
                continue
            beside = ratio / float(np.median(others))
            if beside > MIN_RATIO_TO_OTHERS:
                detail = (
                    f"the current of joint {joint + 1} is {number(1 / beside, '.2f')} times what "
                    "gravity takes there, beside the currents of the other joints; check its unit "
                    "and column"
                )
                code, own = Found.SCALED_CURRENT, (joint + 1,)
                cause = CauseCode.SCALED_CURRENT
                yield Finding("robot", code, "warning", 1, detail, cause=cause, joints=own)

    def undeclared_load(self) -> Iterator[Finding]:
        """Warn of a load that the currents of a UR show, if no target currents were recorded."""
        if not self.arm.has_ur_motors() or TARGET_CURRENT in self.means.currents:
            return
        mass, error, ahead = self.motion.load()
        least = max(MIN_LOAD, MIN_ERRORS_OF_LOAD * error)
        if mass > least and _leads(ahead, MIN_LEAD_OF_LOAD):
            carried = f"{number(mass, '.1f')} ± {number(error, '.1g')} kg"
            detail = (
                f"by the currents, the arm carries {carried} more than the study declares; declare "
                "it as `payload`, or fit to recordings without a load"
            )
            code, cause = Found.UNDECLARED_LOAD, CauseCode.UNDECLARED_LOAD
            yield Finding("robot", code, "warning", 1, detail, cause=cause)

    def other_arms(self, others: Sequence[Robot]) -> Iterator[Cause]:
        """Yield one cause with the other arm that explains the efforts best, also if both carried
        any load, and the arms that explain them almost as well. others: with the load that this arm
        carries.
        """
        ahead = {arm.name: own for arm in others if (own := self._lead_of_arm(arm)) is not None}
        tells = len(self.moving) >= MIN_MOVING_JOINTS and len(self.means.q) >= MIN_BLOCKS
        if ahead and tells:
            first, *names = sorted(ahead, key=lambda name: -ahead[name])
            alike = [name for name in names if ahead[first] - ahead[name] < MAX_LEAD_AGAINST]
            causes = " or ".join(robots_as_cause((first, *alike)))
            detail = (
                f"the currents are not those of {self.arm.name}: the motion of {causes} explains "
                "them far better; correct `robot`, or columns and units"
            )
            finding = contradiction(CauseCode.OTHER_ARMS_CURRENTS, "robot", detail)
            (best,) = (arm for arm in others if arm.name == first)
            yield Cause(finding, ahead[first], self.means, best)

    def other_mountings(self) -> Iterator[Cause]:
        """Yield one cause with the mounting under which any links explain the efforts best, and
        those that do so almost as well.
        """
        if len(self.means.q) < MIN_BLOCKS:
            return
        ahead = {gravity: self._lead_of_mounting(gravity) for gravity in MOUNTINGS}
        likely = sorted(ahead, key=lambda gravity: -ahead[gravity].size)
        first = ahead[likely[0]]
        if _leads(first, MIN_LEAD_OF_MOUNTING):
            alike = [own for own in likely if first.size - ahead[own].size < MAX_LEAD_AGAINST]
            finding = other_mounting(alike, False, self.means.measured)
            yield Cause(finding, first.size, self.means, self.arm.mounted(likely[0]))

    def _lead_of_mounting(self, gravity: Gravity) -> Lead:
        other = WholeMotion(self.means, self.arm.mounted(gravity)).explained()
        return lead(other.by_any_links, self.declared.by_any_links, self.motion.joints)

    def _lead_of_arm(self, arm: Robot) -> float | None:
        """Return by how much another arm explains the efforts better; None if it does not do so
        both with the declared load and with any load.
        """
        other = WholeMotion(self.motion.means, arm)
        its = other.in_units_of(self.arm, other.explained().by_known)
        bare = lead(its, self.declared.by_known, self.moving)
        if not _leads(bare, MIN_LEAD_OF_ARM):
            return None
        loaded = other.in_units_of(self.arm, other.with_any_load())
        with_load = lead(loaded, self.with_any_load, self.moving)
        return bare.size if _leads(with_load, MIN_LEAD_OF_LOADED_ARM) else None

    @cached_property
    def with_any_load(self) -> Misfit:
        """Return the misfit of the declared links with any load on the flange."""
        return self.motion.with_any_load()

    def tells_order(self, pair: Pair) -> bool:
        """Return whether an exchange of two joints would be noticed."""
        own = self.exchanged_joints.get(pair) if len(self.means.q) >= MIN_BLOCKS else None
        return own is not None and are_exchanged(self.declared, own, pair)

    def tells_efforts(self, pair: Pair) -> bool:
        """Return whether an exchange of two joints' efforts would be noticed."""
        own = self.exchanged_efforts.get(pair)
        return own is not None and have_exchanged_efforts(self.declared, own, pair)

    def tells_sign(self, joint: int) -> bool:
        """Return whether the opposite sign of a joint's effort would be noticed, even if all
        efforts had it, which unknown links would not show.
        """
        braked = self.braked()
        if joint in braked:
            return True
        known = self.arm.tells_gravity() or bool(braked)
        own = self.turned.get(joint)
        return known and own is not None and is_turned(self.declared, own, joint)

    def _as_turned(self, joints: list[int], by_links: bool) -> Finding:
        """Return the stop sign of efforts with the opposite sign on some joints, from 0; by_links:
        whether the links show it, otherwise friction does.
        """
        if self.arm.measured == CURRENT:
            why = (
                "with its sign turned, the motion explains the currents far better"
                if by_links
                else "friction would drive its motion"
            )
            sign = f"the sign of the current of joint {joints[0] + 1} is reversed"
            detail = f"{sign}: {why}; correct the column"
            return contradiction(CauseCode.TURNED_CURRENT, "sign", detail, [joints[0] + 1])
        why = (
            "turned, links explain the torques of all joints far better"
            if by_links
            else "friction would drive their motion"
        )
        beside = "" if by_links else " (`directions` would turn their positions, too)"
        numbers = [joint + 1 for joint in joints]
        detail = (
            f"the sign of actual_torque is reversed on {numbered(numbers)}; {why}; "
            "correct the columns, or turn them in the entry by `units: {actual_torque: "
            f"{self._signs(joints).astype(int).tolist()}}}`{beside}"
        )
        return contradiction(CauseCode.TURNED_TORQUES, "sign", detail, numbers)

    def _signs(self, joints: list[int]) -> Array:
        """Return -1 for some joints, 1 for others (n,)."""
        return np.where(np.isin(np.arange(len(self.arm.joints)), joints), -1.0, 1.0)

    def _gain_of_sign(self, joint: int) -> float:
        return self.gain(self.turned[joint])

    def _order(self, pair: Pair) -> list[int]:
        """Return the columns of all joints, with those of a pair exchanged."""
        return [*exchanged_order(in_order(self.arm), *pair)]


def is_likelier(other: Explained, first: Explained, joints: Sequence[int], least: Limits) -> bool:
    """Return whether `other` explains the efforts of some joints, from 0, better than `first`: by
    the declared links, if any links do not contradict it; where the links are unknown, by any
    links.

    least: the smallest leads that count.
    """
    if other.by_links is None or first.by_links is None:
        return _leads(lead(other.by_any_links, first.by_any_links, joints), least.by_any_links)
    if not _leads(lead(other.by_links, first.by_links, joints), least.by_links):
        return False
    return lead(other.by_any_links, first.by_any_links, joints).size > -MAX_LEAD_AGAINST


def have_exchanged_efforts(other: Explained, first: Explained, pair: Pair) -> bool:
    """Return whether `other`, with the efforts of a pair of joints exchanged, is likelier than
    `first`.
    """
    limits = OF_ALIKE if are_alike(first.motion, pair) else OF_EFFORTS
    return is_likelier(other, first, pair, limits)


def are_alike(motion: WholeMotion, pair: Pair) -> bool:
    """Return whether two joints move alike, so that only the described links distinguish them, and
    the arm is no UR, of which the links are certain.
    """
    return motion.means.move_alike(pair) and not motion.arm.has_ur_motors()


def are_exchanged(other: Explained, first: Explained, pair: Pair) -> bool:
    """Return whether `other`, with all channels of a pair of joints exchanged, is likelier than
    `first`.

    It is so clearly by the declared links, or both by these and by any links. The torques of all
    joints must be likelier, too, as they depend on the postures of both.
    """
    if not _leads(lead(other.by_known, first.by_known, first.motion.joints), 0.0):
        return False
    if are_alike(first.motion, pair):
        return is_likelier(other, first, pair, OF_ALIKE)
    if other.by_links is None or first.by_links is None:
        return is_likelier(other, first, pair, OF_JOINTS)
    if is_likelier(other, first, pair, OF_JOINTS._replace(by_links=CLEAR_LEAD_OF_JOINTS)):
        return True
    by_any = lead(other.by_any_links, first.by_any_links, pair)
    return is_likelier(other, first, pair, OF_JOINTS) and _leads(by_any, MIN_LEAD_OF_JOINTS)


def is_turned(other: Explained, first: Explained, joint: int) -> bool:
    """Return whether `other`, with the opposite sign on a joint from 0, is likelier than `first`.

    Declared links are judged by the joint's own effort, any links by the efforts of all joints,
    which depend on each other. The limit is higher for a joint that moves as another one does.
    """
    joints = first.motion.joints
    alike = any(are_alike(first.motion, (joint, one)) for one in joints if one != joint)
    if other.by_links is not None:
        limits = OF_ALIKE if alike else Limits(MIN_LEAD_OF_SIGN, np.inf)
        return is_likelier(other, first, [joint], limits)
    return not alike and is_likelier(
        other, first, joints, Limits(np.inf, MIN_LEAD_OF_SIGN_BY_ANY_LINKS)
    )


def _leads(found: Lead, least: float) -> bool:
    return found.size > least and found.errors > MIN_ERRORS
