"""A recording and what the study declares of it, as the checks of both take it."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from ur5lib.channels import TORQUE
from ur5lib.checks.block_means import BlockMeans, block_means
from ur5lib.checks.by_motion import MotionChecks
from ur5lib.checks.contacts import FeltContact, felt_contact, felt_contacts
from ur5lib.checks.currents import Answers, answers, is_driven, moving_joints
from ur5lib.checks.delays import Delays, delays_by_motion
from ur5lib.checks.doubts import doubted_links, doubts_by_joint
from ur5lib.checks.targets import odd_targets
from ur5lib.errors import InputError
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.timeseries.segments import period

MIN_BLOCKS = 30  # blocks of a recording that can contradict an arm
# Where a hand leads an arm, so many joints move at least. A strong push turns one.
MIN_JOINTS_LED_BY_HAND = 3


@dataclass(frozen=True)
class Checked:
    """A recording and its declared arm, payloads and role.

    robot: a repaired table; arm: under the recording's gravity; configured: the payload that the
    controller was given; declared: the one that the study gives; fitted: whether the recording has
    the role `fit`; cutoff: of the currents' low-pass [Hz]; touched: whether it has `contact`.
    """

    robot: pd.DataFrame
    arm: Robot
    configured: Payload | None
    declared: Payload | None
    fitted: bool
    cutoff: float
    touched: bool = False

    @cached_property
    def step(self) -> float:
        """Return the time between its frames [s]."""
        return period(self.robot["time"].to_numpy())

    @cached_property
    def means(self) -> BlockMeans:
        """Return the means of its blocks."""
        return block_means(self.robot, self.step)

    @cached_property
    def loaded(self) -> Robot:
        """Return the arm with the declared payload."""
        return self.arm.carrying(self.declared)

    @cached_property
    def payloads(self) -> list[Payload | None]:
        """Return the payloads that the controller's torque may contain, each once."""
        same = self.configured == self.declared
        return [self.declared] if same else [self.configured, self.declared]

    @cached_property
    def others(self) -> list[Robot]:
        """Return all described arms of as many joints, mounted alike and with the same payload."""
        return arms_alike(self.arm, self.declared)

    @cached_property
    def driven(self) -> bool:
        """Return whether the arm is moved by its motors."""
        return is_driven(self.robot)

    @cached_property
    def answers(self) -> Answers | None:
        """Return the log-likelihoods of the currents by the joints' motions.

        None if blocks or moving joints are too few, and of measured torques: one from beyond the
        gear shows no friction, by which motions explain a current.
        """
        if not self.shows_currents() or self.arm.measured == TORQUE:
            return None
        if moving_joints(self.means).sum() < (1 if self.driven else MIN_JOINTS_LED_BY_HAND):
            return None
        return answers(self.robot, self.means, self.loaded, self.step, self.cutoff)

    @cached_property
    def delays(self) -> Delays | None:
        """Return the log-likelihoods of delays of currents, or of motors' torques; None where
        neither shows friction.
        """
        if self.answers is not None:
            return self.answers.delays
        return self._delays_by_motion() if self.arm.effort == "motor_torque" else None

    @cached_property
    def sensed_delays(self) -> Delays | None:
        """Return the log-likelihoods of delays of torques that sensors beyond the gears measure;
        None of other efforts.
        """
        if self.delays is not None or self.arm.measured != TORQUE:
            return None
        return self._delays_by_motion()

    def _delays_by_motion(self) -> Delays | None:
        """Return the log-likelihoods of the efforts' delays; None if blocks of efforts are too few,
        or no joint moves under its motor.
        """
        if not self.shows_currents() or not self.driven or not moving_joints(self.means).any():
            return None
        return delays_by_motion(self.robot, self.loaded, self.step, self.cutoff)

    @cached_property
    def motion(self) -> MotionChecks | None:
        """Return the checks of the efforts by the whole motion; None if blocks of efforts are too
        few, no joint moves, or a motor has no torque constant.
        """
        constants = self.arm.maker_torque_constants()
        if not self.shows_currents() or not np.isfinite(constants).all():
            return None
        if not moving_joints(self.means).any():
            return None
        return MotionChecks(self.means, self.loaded, self.tells_signs_by_friction())

    @cached_property
    def doubted_links(self) -> list[Finding]:
        """Return notes on described links that the efforts contradict; none unless the recording
        has the role `fit`, since contacts may be a part of the efforts of others.
        """
        return [*doubted_links(self.motion)] if self.fitted and self.motion is not None else []

    @cached_property
    def odd_targets(self) -> dict[int, Finding]:
        """Return warnings of current targets that are not those of the motors, by joint from 0."""
        comparable = self.driven and self.answers is not None
        return odd_targets(self.means, self.loaded) if comparable else {}

    @cached_property
    def contact(self) -> FeltContact | None:
        """Return the strongest contact that the currents show; None if there is none, or the arm's
        gravity is not described.
        """
        known = self.shows_currents() and self.arm.tells_gravity()
        return felt_contact(self.means, self.loaded) if known else None

    @cached_property
    def felt(self) -> list[tuple[float, float]]:
        """Return from and to [s] of the contacts that the currents of a `fit` recording show; none
        where the described links of the joint may be the cause.
        """
        if not self.fitted or self.contact is None:
            return []
        doubted = self.contact.joint in doubts_by_joint(self.doubted_links)
        return [] if doubted else felt_contacts(self.means, self.loaded)

    def shows_currents(self) -> bool:
        """Return whether the recording has enough blocks of currents, or of measured torques."""
        return len(self.means.q) >= MIN_BLOCKS and self.means.has_efforts()

    def tells_signs_by_friction(self) -> bool:
        """Return whether friction shows the signs of the efforts: motors move the arm, and the
        efforts are measured on their side of the gears.
        """
        return self.driven and self.arm.effort in ("current", "motor_torque")

    def tells_by_gravity(self) -> bool:
        """Return whether gravity in the currents identifies arm, joints and motors.

        A push against an arm at rest looks like gravity, so that such a recording counts only with
        the role `fit` and without a contact.
        """
        if not self.means.has_efforts() or not self.arm.tells_gravity():
            return False
        return bool(moving_joints(self.means).any()) or (self.fitted and self.contact is None)


def arms_alike(arm: Robot, payload: Payload | None) -> list[Robot]:
    """Return all described arms with as many joints as an arm, mounted alike and carrying a
    payload; those without described gravity are left out.
    """
    arms = filter(Robot.tells_gravity, described_arms().values())
    alike = [other for other in arms if len(other.joints) == len(arm.joints)]
    return [other.mounted(arm.gravity).carrying(payload) for other in alike]


def described_arms() -> dict[str, Robot]:
    """Return all described arms by name, without the user's own with an error: studies that use
    these report it.
    """
    arms = {}
    for name in robot_names():
        with suppress(InputError):
            arms[name] = described(name)
    return arms


def described(name: str) -> Robot:
    """Return an arm as it is described now."""
    return load_robot(robot_path(name))
