"""Prior of the maps from torque to current, and of the torque constants."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from ur5lib.channels import CURRENT, Effort
from ur5lib.errors import RefusalError
from ur5lib.identification.at_rest import AtRest
from ur5lib.identification.regression import Normal
from ur5lib.records.codes import CauseCode
from ur5lib.robots.friction import (
    FITTED_TERMS,
    SPEED_TERMS,
    STRIBECK,
    coefficient_names,
    term_of,
)
from ur5lib.timeseries.arrays import Array, Mask

# Usual standard deviation of a current's independent samples, relative to the largest torque's
# current: the middle of 0.001 to 0.02 in single recordings of a UR5 and a UR10e. With 0.01, a
# constant that is given 2.5 times too small was no longer contradicted by 24 s of motion.
CURRENT_NOISE_SHARE = 0.005
# The same of friction at rest: anywhere within Coulomb friction, about a twentieth of that torque.
REST_FRICTION_STD = 0.05 / np.sqrt(3)
PINNED_STD_SHARE = 1e-3  # a pinned constant keeps this share of its standard deviation
# Friction of a joint before any recording, mean and standard deviation, near those of the larger of
# 20 joints of a UR3, a UR5, a UR10 and a UR10e: relative to the motor's largest torque, load
# friction to the transmitted.
COULOMB_PRIOR = (0.045, 0.011)
VISCOUS_PRIOR = (0.06, 0.014)
LOAD_PRIOR = (0.06, 0.04)
OFFSET_STD_SHARE = 0.007  # an offset has this standard deviation, relative to the largest torque
OFFSET_NAME = "offset"
WIDE_GAIN_STD = 0.3  # prior deviation of a measured torque's gain that is left to the data
STANDSTILL_SPEED = 1e-3  # rad/s
MIN_RATIO_TORQUE = 0.1  # Nm; smaller torques have no ratio to the current


@dataclass(frozen=True)
class Typical:
    """A coefficient that all joints have before any recording: mean and standard deviation (n,), SI
    units.
    """

    mean: Array
    std: Array


def typical_friction(torque_max: Array) -> dict[str, Typical]:
    """Return, by name, typical Coulomb [Nm], viscous [Nm s/rad] and load friction, and offset [Nm],
    of motors with these largest torques (n,) [Nm].
    """
    largest, ones = torque_max, np.ones_like(torque_max)
    return {
        "coulomb": Typical(*(share * largest for share in COULOMB_PRIOR)),
        "viscous": Typical(*(share * largest for share in VISCOUS_PRIOR)),
        "load": Typical(*(share * ones for share in LOAD_PRIOR)),
        "offset": Typical(0.0 * largest, OFFSET_STD_SHARE * largest),
    }


@dataclass(frozen=True)
class Prior:
    """Prior of the maps from torque to current of n joints.

    inverse_constant: of 1/k [A/Nm]; torque_max: of the motors (n,) [Nm]; measured: the effort that
    is predicted; of torques, k is the gain [Nm/Nm]; terms: of friction, that are fitted;
    tried: those that errors on left-out samples add or remove; distances:
    [rad], over which friction at rest reverses in addition to the usual one; pinned: joints from 0
    that keep the prior's mean of 1/k, regardless of the data; typical: friction and offset by their
    names, empty where unknown; at_rest: postures of the arm, which show 1/k by gravity in addition
    to its motions, None without any.
    """

    inverse_constant: Normal
    torque_max: Array
    terms: tuple[str, ...] = FITTED_TERMS
    tried: tuple[str, ...] = (*SPEED_TERMS, STRIBECK)
    distances: tuple[float, ...] = ()
    pinned: tuple[int, ...] = ()
    typical: Mapping[str, Typical] = field(default_factory=dict)
    at_rest: AtRest | None = None
    measured: Effort = CURRENT

    def with_wide_gains(self) -> "Prior":
        """Return the prior with gains so vague that the data alone determine them."""
        wide = Normal(self.inverse_constant.mean, np.eye(len(self.torque_max)) * WIDE_GAIN_STD**-2)
        return replace(self, inverse_constant=wide)

    def with_pinned(self, joints: Mask) -> "Prior":
        """Return the prior with the constants of some joints pinned, and of no others; joints:
        (n,).
        """
        return replace(self, pinned=tuple(np.flatnonzero(joints).tolist()))

    def std(self) -> Array:
        """Return the standard deviation (n,) of each joint's 1/k [A/Nm]."""
        std = np.sqrt(np.diag(np.linalg.inv(self.inverse_constant.precision)))
        std[[*self.pinned]] *= PINNED_STD_SHARE
        return std

    def noise(self) -> Array:
        """Return the usual variance (n,) [A²] of an independent sample of the current."""
        variance: Array = (CURRENT_NOISE_SHARE * self.torque_max * self.inverse_constant.mean) ** 2
        return variance

    def noise_at_rest(self) -> Array:
        """Return the usual variance (n,) [A²] of the current in a posture at rest."""
        variance: Array = (REST_FRICTION_STD * self.torque_max * self.inverse_constant.mean) ** 2
        return variance

    def of_joint(self, joint: int) -> "Prior":
        """Return the prior of one joint, from 0; its correlation with others, and postures at rest,
        are left out.
        """
        rows = slice(joint, joint + 1)
        inverse = Normal(self.inverse_constant.mean[rows], np.diag(self.std()[rows] ** -2.0))
        typical = {
            name: Typical(coefficient.mean[rows], coefficient.std[rows])
            for name, coefficient in self.typical.items()
        }
        alone = replace(self, inverse_constant=inverse, torque_max=self.torque_max[rows])
        return replace(alone, pinned=(), typical=typical, at_rest=None)

    def over(self, terms: Sequence[str]) -> Normal:
        """Return the prior of the coefficients of all joints, joint by joint: 1/k [A/Nm], an offset
        [A], and those of the terms.

        A coefficient without a typical value is 0 ± the largest size expected of its term, an
        offset 0 ± the motor's largest torque.
        """
        inverse = self.inverse_constant.mean
        names = ["", OFFSET_NAME, *coefficient_names(terms)]  # "" of 1/k
        # (n, P)
        widths = np.array([_expected_sizes(terms, torque_max) for torque_max in self.torque_max])
        starts = len(names) * np.arange(len(inverse))
        mean, std = np.zeros(widths.size), (inverse[:, None] * widths).ravel()
        vague = np.tile([name not in ("", *self.typical) for name in names], len(inverse))
        precision = np.diag(np.where(vague, std**-2.0, 0.0))
        mean[starts] = inverse
        precision[np.ix_(starts, starts)] += self._inverse_precision()
        for name, coefficient in self.typical.items():
            # c = F / k, whatever k is: c - F (1/k) has mean zero and covariance Σ_F / k²
            places = starts + names.index(name)
            # k i = τ + τ_friction - b
            value = coefficient.mean * (-1 if name == OFFSET_NAME else 1)
            difference = np.zeros((len(starts), len(mean)))
            rows = np.arange(len(starts))
            difference[rows, places], difference[rows, starts] = 1.0, -value
            weight = (coefficient.std * inverse) ** -2.0
            precision += (difference.T * weight) @ difference
            mean[places] = value * inverse
        return Normal(mean, precision)

    def _inverse_precision(self) -> Array:
        """Return the precision (n, n) of 1/k; pinned joints do not affect the free ones."""
        if not self.pinned:
            return self.inverse_constant.precision
        free_joints = np.delete(np.arange(len(self.torque_max)), self.pinned)
        covariance = np.linalg.inv(self.inverse_constant.precision)
        precision = np.diag(self.std() ** -2.0)
        precision[np.ix_(free_joints, free_joints)] = np.linalg.inv(
            covariance[np.ix_(free_joints, free_joints)]
        )
        return precision


def _expected_sizes(terms: Sequence[str], torque_max: float) -> list[float]:
    """Return the largest sizes expected of 1/k, the offset and the friction coefficients,
    multiplied by k [Nm, ...].
    """
    by_term = [[term.expected(torque_max)] * (len(term.parts) or 1) for term in map(term_of, terms)]
    return [1.0, torque_max, *chain.from_iterable(by_term)]


def standstill_ratio(moment: Array, current: Array, qd: Array) -> Array:
    """Return the torque constants (n,) [Nm/A] that the controller uses, NaN for a joint without
    load at rest.

    moment, current: (N, n) `target_moment` [Nm] and `target_current` [A]; qd: (N, n) [rad/s]. At
    rest, the controller's current contains no friction, so the ratio is constant.
    """
    # at rest, k i = τ without friction
    standstill = (np.abs(qd) < STANDSTILL_SPEED).all(axis=1) & np.isfinite(moment * current).all(
        axis=1
    )
    constants = np.full(moment.shape[1], np.nan)
    for joint in range(len(constants)):
        loaded = (
            standstill & (np.abs(moment[:, joint]) > MIN_RATIO_TORQUE) & (current[:, joint] != 0)
        )
        if loaded.sum() > standstill.sum() / 2:
            constants[joint] = np.median(moment[loaded, joint] / current[loaded, joint])
    return constants


def torque_constant_prior(
    constants: Array, covariance: Array, controller: Array, ratio: float
) -> Normal:
    """Return the prior of 1/k [A/Nm] of all joints from the maker's and the controller's constants
    (n,) [Nm/A], NaN if unknown.

    constants: the maker's at the joint's side of the gear, with the covariance (n, n) of its
    logarithm; controller: see `standstill_ratio`; ratio: its relative standard deviation,
    independent between joints. They are combined as normal distributions of log k.
    """
    precision = np.linalg.inv(covariance)
    right = precision @ np.log(np.where(np.isfinite(constants), constants, 1.0))
    # the controller's ratio as a measurement of log k
    measured = np.isfinite(controller)
    precision += np.diag(measured / ratio**2)
    right += np.log(np.where(measured, controller, 1.0)) * measured / ratio**2
    # from log k to 1/k
    inverse = np.exp(-np.linalg.solve(precision, right))
    return Normal(inverse, precision / np.outer(inverse, inverse))


def makers_covariance(
    maker: Array, controller: Array, motors: Sequence[str], shared: float, spread: float
) -> Array:
    """Return the covariance (n, n) of the logarithms of the manufacturer's torque constants.

    maker, controller: (n,) [Nm/A], NaN if unknown; motors: their sizes; shared: relative standard
    deviation common to joints of one size; spread: that between joints of one size. Raises
    RefusalError if a size has neither value.
    """
    same = np.array([[size == other_size for other_size in motors] for size in motors])
    has_constant = np.isfinite(maker)
    if not all((has_constant | np.isfinite(controller))[row].any() for row in same):
        text = (
            "the torque constant of a motor size is unknown: neither the robot's description nor "
            "target_moment and target_current at standstill determine it"
        )
        raise RefusalError(CauseCode.UNKNOWN_CONSTANT, text)
    wide = np.where(has_constant, shared, 10.0)  # without a manufacturer's value, any constant
    covariance: Array = same * np.outer(wide, wide) + np.eye(len(motors)) * spread**2
    return covariance
