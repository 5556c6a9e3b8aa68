"""Samples of a recording for the fit of its motor currents, and the prior of torque constants."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ur5lib.channels import CURRENT
from ur5lib.identification.prior import (
    Prior,
    Typical,
    makers_covariance,
    standstill_ratio,
    torque_constant_prior,
    typical_friction,
)
from ur5lib.identification.samples import CurrentSamples, Shafts
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import coupled_motors, shaft_matrix
from ur5lib.robots.friction import BASE_TERMS, FITTED_TERMS
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment, without_ends

# Relative standard deviations: of the maker's constants, and among joints with motors of one size.
MAKERS = 0.3, 0.1
OF_URS = 0.0, 0.1  # as MAKERS, of a UR's motors
OF_TORQUES = 0.0, 0.05  # as MAKERS, of gains of measured torques, which should be 1
CONTROLLERS = 0.1  # the controller's ratio has this relative error


class FitSettings(NamedTuple):
    """What a study chooses of the fit of currents: their low-pass, and terms and prior of friction,
    as `further` and `of_other_arms` of `prior_of`.
    """

    lowpass: Butterworth
    terms: list[str] | None = None
    prior: bool = True


def current_record(
    recording: AlignedRecording, arm: Robot, before: Sequence[Motion] = ()
) -> CurrentSamples | None:
    """Return measured motion and efforts, with the torque of the fullest link model and the
    payload; None if no efforts were recorded.

    before: the motions of earlier recordings, oldest first, each starting where the previous one
    ended: they show on which side friction acts at the start.
    """
    model, motion = arm.fullest_model(), recording.motion
    torque = recording.torques.measured[model] + recording.torques.payload_torque
    samples = measured_samples(recording.name, recording.signals, motion, arm, torque, before)
    return samples and with_inertial(samples, arm)


def with_inertial(samples: CurrentSamples, arm: Robot) -> CurrentSamples:
    """Return samples with the torque less gravity's, which gains of measured torques need."""
    if arm.measured == CURRENT:
        return samples
    gravity = gravity_torque(arm, arm.fullest_model(), samples.q)
    return replace(samples, inertial=samples.torque - gravity)


def measured_samples(
    name: str,
    signals: Signals,
    motion: Motion,
    arm: Robot,
    torque: Array,
    before: Sequence[Motion] = (),
) -> CurrentSamples | None:
    """Return measured motion and efforts, with a given torque (N, n) [Nm] of the rigid bodies; None
    if no efforts were recorded.

    before: as of `current_record`.
    """
    if signals.effort is None:
        return None
    bare = motion_samples(name, motion, arm, torque, before)
    return replace(bare, current=signals.effort, temperature=signals.joint_temperatures)


def motion_samples(
    name: str,
    motion: Motion,
    arm: Robot,
    torque: Array,
    before: Sequence[Motion] = (),
    kind: type[CurrentSamples] = CurrentSamples,
) -> CurrentSamples:
    """Return a motion without measured efforts, which are zero; arguments: as of
    `measured_samples`.
    """
    return kind(
        name=name,
        period=motion.period if len(motion.time) > 1 else 1.0,
        segment=motion.segment,
        q=motion.q,
        qd=motion.motor_qd,
        torque=torque,
        current=np.zeros_like(torque),
        shafts=shafts_of(arm, motion, before),
        balanced=[joint - 1 for joint in arm.balanced_joints],
        qdd=None if arm.knows_rotors() else motion.qdd,
        before=before,
    )


def shafts_of(arm: Robot, motion: Motion, before: Sequence[Motion] = ()) -> Shafts | None:
    """Return, for each joint, the motion of the coupled motor that turns with it; None for an arm
    without coupled motors.

    It is the joint's own motor if that is coupled, otherwise the one that turns most with it.
    """
    if not arm.drives.coupling:
        return None
    shafts = shaft_matrix(arm)
    shares = np.abs(shafts) * coupled_motors(shafts)[:, None]  # of motors, with each joint
    own = np.diag(shares) > 0
    motors = np.where(own, np.arange(len(own)), shares.argmax(axis=0))
    states = [v @ shafts.T for v in (motion.q, motion.motor_qd, motion.qdd)]
    turns = shares.any(axis=0)
    earlier = [known for one in before if (known := shafts_of(arm, one))]
    q, qd, qdd = (np.where(turns, values[:, motors], np.nan) for values in states)
    return Shafts(q, qd, qdd, earlier)


@dataclass(frozen=True)
class ZeroPhaseLowpass:
    """A zero-phase low-pass of a recording's samples within its segments; cutoff: [Hz]."""

    order: int
    cutoff: float

    def __call__(self, values: Array, record: CurrentSamples) -> Array:
        """Return values (N, M), low-passed, NaN at the ends of segments, where it extrapolates."""
        settings = 1 / record.period, self.order, self.cutoff
        smoothed = by_segment(zero_phase_lowpass, values, record.segment, *settings)
        return without_ends(smoothed, record.segment, record.period, self.cutoff)


def controllers_ratio(signals: Signals, motion: Motion, odd: Sequence[int] = ()) -> Array:
    """Return the controller's own torque constants (n,) [Nm/A], NaN where undetermined.

    odd: joints, from 1, with a `target_current` that does not belong to their motors.
    """
    if signals.target_moment is None or signals.target_current is None:
        return np.full(motion.q.shape[1], np.nan)
    ratio = standstill_ratio(signals.target_moment, signals.target_current, motion.motor_qd)
    ratio[[joint - 1 for joint in odd]] = np.nan
    return ratio


def prior_of(
    robot: Robot,
    ratios: Sequence[Array],
    further: Sequence[str] | None = None,
    of_other_arms: bool = True,
) -> Prior:
    """Return the prior of an arm's current fit; friction is unknown, except of a UR's motors.

    further: terms of friction beyond BASE_TERMS, None for those that the recordings show;
    of_other_arms: whether a UR's friction is expected to be as theirs.

    Torque constants come from the manufacturer, and from the controller's ratios (n,) [Nm/A] of
    recordings. Raises RefusalError if they do not suffice.
    """
    joints = range(1, len(robot.joints) + 1)
    columns = [
        [own[joint - 1] for own in ratios if np.isfinite(own[joint - 1])] for joint in joints
    ]
    controller = np.array([np.median(column) if column else np.nan for column in columns])
    torque_max, known = np.array(robot.torque_limits()), np.array(robot.maker_torque_constants())
    typical, spreads = dict[str, Typical](), MAKERS if robot.measured == CURRENT else OF_TORQUES
    if robot.has_ur_motors():
        typical, spreads = typical_friction(torque_max) if of_other_arms else {}, OF_URS
        family = np.array(robot.family_torque_constants())
        known = np.where(np.isfinite(family), family, known)
    covariance = makers_covariance(known, controller, robot.joints, *spreads)
    constants = torque_constant_prior(known, covariance, controller, CONTROLLERS)
    terms = FITTED_TERMS if further is None else tuple(dict.fromkeys((*BASE_TERMS, *further)))
    found = Prior(constants, torque_max, (*terms, *arm_terms(robot)), typical=typical)
    tried = found.tried if further is None else ()
    return replace(found, tried=tried, measured=robot.measured)


def arm_terms(robot: Robot) -> list[str]:
    """Return the terms of friction that an arm has in addition to the usual ones."""
    described = {
        "balance": robot.balanced_joints,
        "rotor": not robot.knows_rotors(),
        "coupled": robot.drives.coupling,
    }
    return [name for name, part in described.items() if part]
