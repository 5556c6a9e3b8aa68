"""Links, rotors, gears and counterbalances of an arm from its measured torques alone.

Where a description has placeholders for an arm's links, they are fitted to torques together with
the friction of its joints. Left-out paths show on which joint a counterbalance acts: it pulls like
a mass that no link has, so it shows only where bodies of the arm's shape and weight cannot explain
gravity.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import (
    PARAMETERS_PER_JOINT,
    InertialEstimate,
    Stack,
    identify,
    solve,
    stack,
    torque_error,
    total_factors,
)
from ur5lib.identification.consistency import (
    LinkBounds,
    nearest_bodies,
)
from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.identification.selection import is_less
from ur5lib.identification.torque_rows import MeasuredRun, TorqueRows, torque_rows
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import numbered
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import shaft_matrix
from ur5lib.robots.friction import SPEED_TERMS
from ur5lib.robots.inertia import link_tail, shift_inertia
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.timeseries.arrays import Array, Mask

JOINT_TERMS = ("coulomb", "viscous", *SPEED_TERMS)  # terms that need no link model
FOLDS = 5
# A balance reduces its joint's squared error on unseen paths by at least this share, and by this
# many standard errors over the folds.
MIN_SHARE, MIN_DEVIATIONS = 0.05, 2.0
# Largest ratio of squared errors, links as bodies over unconstrained: of a joint with a
# counterbalance, and of others of a right arm (a UR3 with currents without its rotors has 3.4).
MAX_ERROR_OF_BALANCED, MAX_ERROR_OF_BODIES = 1.5, 10.0
# A centre of mass lies between its link's joints, or beyond them by a share of the arm's length.
CENTER_MARGIN_SHARE = 0.12


class FittedArm(NamedTuple):
    """Links, rotors and counterbalances that were fitted to measured torques.

    parameters: π (P,) of links and rotors as physical bodies; estimate: without that constraint;
    mae: of the torques (n,) [Nm], with and without that constraint; balanced: joints from 1 with a
    counterbalance.
    """

    parameters: Array
    estimate: InertialEstimate
    mae: dict[str, Array]
    balanced: list[int]


def fit_arm(robot: Robot, runs: Sequence[MeasuredRun], smooth: ZeroPhaseLowpass) -> FittedArm:
    """Return links, rotors and counterbalances fitted to measured torques; described
    counterbalances are kept.

    Raises RefusalError where there are too few rows, or no bodies explain the torques, as with a
    reversed sign.
    """
    terms = [*JOINT_TERMS, *(["coupled"] if robot.drives.coupling else [])]
    fit = ArmFit(robot, torque_rows(runs, terms, smooth, shaft_matrix(robot)), terms)
    balanced = [*robot.balanced_joints] or fit.balanced_joints(terms)
    places = fit.rows.places(terms, balanced)
    fit.expect_bodies(places)
    estimate = fit.estimate(places)
    as_bodies = with_bodies(estimate.parameters, estimate.spread, fit.size, fit.bounds)
    values = {"without constraint": estimate.parameters, "consistent": as_bodies}
    blocks = [(regressor[..., places], torque) for regressor, torque in fit.rows.units]
    mae = {name: torque_error(blocks, value) for name, value in values.items()}
    return FittedArm(as_bodies[: fit.size], of_links(estimate, fit.size), mae, balanced)


class ArmFit:
    """Fits of an arm's torques by chosen columns of its rows, and their errors on left-out units.

    rows: of its recordings; bounds: of its links; noise: (n,) [Nm] of the torques, from a fit with
    the terms `known`.
    """

    def __init__(self, robot: Robot, rows: TorqueRows, known: Collection[str]) -> None:
        """Stack the rows; known: terms of friction that need no trial."""
        self.rows, self.bounds = rows, link_bounds(robot)
        self.stack, self.size = stack(rows.units), PARAMETERS_PER_JOINT * rows.joints
        self.mean, self.width = arm_prior(robot, rows)
        self.noise = self.estimate(rows.places(known)).noise

    def estimate(self, places: Sequence[int]) -> InertialEstimate:
        """Return the estimate with the columns at `places`, without constraints."""
        return identify(self.stack_of(places), self.mean[places], self.width[places])

    def stack_of(self, places: Sequence[int], units: Mask | slice = slice(None)) -> Stack:
        """Return the rows of some units with the columns at `places`."""
        factors = self.stack.factors[units][..., [*places, -1]]
        return Stack(factors, self.stack.samples[units])

    def unseen_errors(self, places: Sequence[int], bounds: LinkBounds | None) -> Array:
        """Return the squared errors Σ e² / σ² of each left-out fold of units and each joint,
        (FOLDS, n).

        bounds: of the links as physical bodies; None if they need not be bodies.
        """
        fold, errors = np.arange(len(self.stack.samples)) % FOLDS, []
        for left_out in np.unique(fold):
            seen = total_factors(self.stack_of(places, fold != left_out))
            value, spread = solve(seen, self.noise, self.mean[places], self.width[places])
            if bounds is not None:
                value = with_bodies(value, spread, self.size, bounds)
            unseen = total_factors(self.stack_of(places, fold == left_out))
            errors.append(np.linalg.norm(unseen @ np.append(-value, 1.0), axis=1) / self.noise)
        return np.array(errors) ** 2

    def balanced_joints(self, terms: Sequence[str]) -> list[int]:
        """Return the joints, from 1, on which only a counterbalance explains gravity.

        If links need not be bodies, a counterbalance explains nothing more: it acts as a link's
        first moment does.
        """
        chosen, limits = list[int](), (MIN_SHARE, MIN_DEVIATIONS)
        free = self.unseen_errors(self.rows.places(terms), None)
        errors = self.unseen_errors(self.rows.places(terms), self.bounds)
        while True:
            trials = {
                joint: self.unseen_errors(self.rows.places(terms, [*chosen, joint]), self.bounds)
                for joint in range(1, self.rows.joints + 1)
                if joint not in chosen
                and is_less(free[:, joint - 1], errors[:, joint - 1], *limits)
            }
            best = min(trials, key=lambda joint: float(trials[joint].sum()), default=None)
            if best is None or ratio(trials[best], free)[best - 1] > MAX_ERROR_OF_BALANCED:
                return chosen
            if not is_less(trials[best][:, best - 1], errors[:, best - 1], *limits):
                return chosen
            chosen, errors = [*chosen, best], trials[best]

    def expect_bodies(self, places: Sequence[int]) -> None:
        """Raise RefusalError where bodies have far larger errors than unconstrained parameters."""
        any_numbers, bodies = (self.unseen_errors(places, own) for own in (None, self.bounds))
        far = 1 + np.flatnonzero(ratio(bodies, any_numbers) > MAX_ERROR_OF_BODIES)
        if len(far):
            text = (
                f"bodies explain the torques of {numbered(far)} far worse than any numbers would: "
                "check the signs of torques and joints (`directions`), `home_deg`, the robot and "
                "its `weight`"
            )
            raise RefusalError(CauseCode.FOREIGN_BODIES, text)


def ratio(errors: Array, others: Array) -> Array:
    """Return the ratio (n,) of squared errors to others, both (F, n) and summed over folds."""
    times: Array = errors.sum(axis=0) / others.sum(axis=0)
    return times


def with_bodies(value: Array, spread: Array, size: int, bounds: LinkBounds) -> Array:
    """Return coefficients (C,) of which the first `size`, those of links and rotors, are changed to
    those of physical bodies.

    value: (C,), estimate; spread: S of its covariance S Sᵀ. The result is nearest in the metric of
    S Sᵀ; the other coefficients follow the links by their covariance.
    """
    root = marginal_root(spread, size)
    parameters = nearest_bodies(value[:size], root, bounds)
    # the smallest u of (π - π̂) = S_π u moves the rest by S u
    move = np.linalg.lstsq(spread[:size], parameters - value[:size], rcond=None)[0]
    moved: Array = value + spread @ move
    return np.append(parameters, moved[size:])


def marginal_root(spread: Array, size: int) -> Array:
    """Return R (size, size) with R Rᵀ the covariance of the first `size` coefficients; spread: S of
    the covariance S Sᵀ of all.
    """
    triangle = np.asarray(np.linalg.qr(spread[:size].T, mode="r"), dtype=np.float64)
    return triangle.T


def of_links(estimate: InertialEstimate, size: int) -> InertialEstimate:
    """Return the part of an estimate with the inertial parameters of links and rotors."""
    return replace(
        estimate,
        parameters=estimate.parameters[:size],
        scatter=estimate.scatter[:, :size],
        spread=marginal_root(estimate.spread, size),
        rounding=estimate.rounding[:size],
        width=estimate.width[:size],
    )


def arm_prior(robot: Robot, rows: TorqueRows) -> tuple[Array, Array]:
    """Return the prior's mean and standard deviation (P,) of the coefficients of all columns.

    Half the arm's weight in equal links, m ± m each, with their centres midway; moments ± m L / 4,
    inertias ± m L² and rotors m L² ± m L² of an arm of length L; all else 0 ± the largest torque.
    """
    tails = [link_tail(pose)[1] for pose in robot.link_poses()]
    length, largest = float(np.linalg.norm(tails, axis=1).sum()), rows.largest_torque()
    # without a described weight: what the largest torque carries at full length
    weight = robot.weight or float(largest.max()) / (STANDARD_GRAVITY * length)
    mass, square = weight / (2 * rows.joints), weight / (2 * rows.joints) * length**2
    links = [_uniform_link(mass, tail, 0.01 * square) for tail in tails]
    link_width = [mass, *[mass * length / 4] * 3, *[square] * 6]
    rotors, further = np.full(rows.joints, square), len(rows.coefficients())
    friction = np.repeat(largest, further)
    mean = np.concatenate([*links, rotors, 0 * friction])
    return mean, np.concatenate([np.tile(link_width, rows.joints), rotors, friction])


def _uniform_link(mass: float, tail: Array, inertia: float) -> list[float]:
    """Return the parameters (10,) of a link with its centre midway along its tail (3,) [m].

    inertia: about any axis through the centre [kg m²].
    """
    center = tail / 2
    about = shift_inertia(inertia * np.eye(3), mass, center)
    return [mass, *(mass * center), *about[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]


def link_bounds(robot: Robot) -> LinkBounds:
    """Return bounds of the links' centres of mass, and of their total mass if the arm's weight is
    described.
    """
    tails = np.array([link_tail(pose)[1] for pose in robot.link_poses()])
    margin = CENTER_MARGIN_SHARE * np.linalg.norm(tails, axis=1).sum()
    low, high = np.minimum(tails, 0) - margin, np.maximum(tails, 0) + margin
    return LinkBounds(robot.weight, low, high)
