"""Links, rotors, gears and counterbalances of an arm from its measured torques alone.

Of an arm whose description has placeholders for its links, torques show them together with the
friction of its joints. Which terms its gears have, and on which joint a counterbalance acts, paths
say that no fit has seen: a counterbalance pulls as a mass would that no link has, so that it shows
only where bodies of the arm's shape and weight cannot explain gravity.
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
from ur5lib.identification.current_samples import Smoother
from ur5lib.identification.torque_rows import MeasuredRun, TorqueRows, torque_rows
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import shaft_matrix
from ur5lib.robots.inertia import link_tail, shift_inertia
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.timeseries.arrays import Array, Mask

BASE_TERMS = ("coulomb", "viscous")  # those that need no link model
GEAR_TERMS = ("velocity_root", "velocity_square")  # which gears have, or not
SHORTER_PRESLIDING = (3e-5, 1e-5)  # rad, of gears that are stiffer, or encoders finer, than a UR's
FOLDS = 5
# What a term takes at least off the squared error on unseen paths, of all joints or, of a balance,
# of the one on which it acts; and by how many standard errors over the folds.
MIN_SHARE_BY_GEARS, MIN_SHARE_BY_BALANCE = 0.02, 0.05
MIN_DEVIATIONS = 2.0
# Squared error with bodies over that with any numbers: of a joint whose counterbalance is found, at
# most; of others of a right arm, at most (a UR3 whose currents lack its rotors has 3.4).
MAX_ERROR_OF_BALANCED, MAX_ERROR_OF_BODIES = 1.5, 10.0
# A centre of mass lies between its link's joints, or beside them by a share of the arm's length.
CENTER_MARGIN_SHARE = 0.12


class FittedArm(NamedTuple):
    """What measured torques show of an arm.

    parameters: π (P,) of links and rotors as bodies; estimate: without that constraint; terms: of
    its gears; presliding: [rad], over which their friction reverses; balanced: joints from 1 with a
    counterbalance; mae: of the torques (n,) [Nm], with and without that constraint.
    """

    parameters: Array
    estimate: InertialEstimate
    mae: dict[str, Array]
    terms: list[str]
    presliding: float
    balanced: list[int]


def fit_arm(robot: Robot, runs: Sequence[MeasuredRun], smooth: Smoother) -> FittedArm:
    """Return the links, rotors and terms that torques show; terms that are described are kept.

    Raises RefusalError where there are too few rows, or no bodies explain the torques, as of the
    opposite sign.
    """
    known = [*BASE_TERMS, *(["coupled"] if robot.drives.coupling else [])]
    fit = fit_of_presliding(robot, runs, known, smooth)
    gears: list[str] = [*robot.friction_terms] or fit.gear_terms(known)
    balanced = [*robot.balanced_joints] or fit.balanced_joints([*known, *gears])
    places = fit.rows.places([*known, *gears], balanced)
    fit.expect_bodies(places)
    estimate = fit.estimate(places)
    as_bodies = with_bodies(estimate.parameters, estimate.spread, fit.size, fit.bounds)
    values = {"without constraint": estimate.parameters, "consistent": as_bodies}
    blocks = [(regressor[..., places], torque) for regressor, torque in fit.rows.units]
    mae = {name: torque_error(blocks, value) for name, value in values.items()}
    links = of_links(estimate, fit.size)
    presliding = fit.rows.presliding
    return FittedArm(as_bodies[: fit.size], links, mae, gears, presliding, balanced)


def fit_of_presliding(
    robot: Robot, runs: Sequence[MeasuredRun], known: Sequence[str], smooth: Smoother
) -> "ArmFit":
    """Return the fit with the distance over which friction reverses: that of the recordings, or a
    shorter one by which errors on unseen units are less.
    """
    terms, shafts = [*known, *GEAR_TERMS], shaft_matrix(robot)
    best = ArmFit(robot, torque_rows(runs, terms, smooth, shafts), known)
    errors = best.unseen_errors(best.rows.places(known), None).sum(axis=1)
    for distance in () if robot.presliding else SHORTER_PRESLIDING:
        rows = torque_rows([run.over(distance) for run in runs], terms, smooth, shafts)
        trial = ArmFit(robot, rows, known, best.noise)
        of_trial = trial.unseen_errors(rows.places(known), None).sum(axis=1)
        if is_less(of_trial, errors, MIN_SHARE_BY_GEARS):
            best, errors = trial, of_trial
    return best


class ArmFit:
    """Fits of an arm's torques with some of their columns, and their errors on unseen units.

    rows: of its recordings; bounds: of its links; noise: (n,) [Nm], with the terms `known`.
    """

    def __init__(
        self,
        robot: Robot,
        rows: TorqueRows,
        known: Collection[str],
        noise: Array | None = None,
    ) -> None:
        """Stack the rows; known: terms of friction that are not on trial; noise: (n,) [Nm], by
        which errors are weighed, None: that of their own fit.
        """
        self.rows, self.bounds = rows, link_bounds(robot)
        self.stack, self.size = stack(rows.units), PARAMETERS_PER_JOINT * rows.joints
        self.mean, self.width = arm_prior(robot, rows)
        self.noise = self.estimate(rows.places(known)).noise if noise is None else noise

    def estimate(self, places: Sequence[int]) -> InertialEstimate:
        """Return the estimate with some columns, without constraints."""
        return identify(self.stack_of(places), self.mean[places], self.width[places])

    def stack_of(self, places: Sequence[int], units: Mask | slice = slice(None)) -> Stack:
        """Return the rows of some units with some columns."""
        factors = self.stack.factors[units][..., [*places, -1]]
        return Stack(factors, self.stack.samples[units])

    def unseen_errors(self, places: Sequence[int], bounds: LinkBounds | None) -> Array:
        """Return Σ e² / σ² of each left-out fold of units and each joint, (FOLDS, n).

        bounds: of bodies, None where links need not be any.
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

    def gear_terms(self, known: Sequence[str]) -> list[str]:
        """Return the terms of friction that gears have, by their errors on unseen units."""
        chosen: list[str] = []
        errors = self.unseen_errors(self.rows.places(known), None)
        for term in GEAR_TERMS:
            trial = self.unseen_errors(self.rows.places([*known, *chosen, term]), None)
            if is_less(trial.sum(axis=1), errors.sum(axis=1), MIN_SHARE_BY_GEARS):
                chosen, errors = [*chosen, term], trial
        return chosen

    def balanced_joints(self, terms: Sequence[str]) -> list[int]:
        """Return the joints, from 1, whose gravity only a counterbalance explains.

        Without the constraint that links are bodies, it would explain nothing more: it pulls as the
        first moment of a link does.
        """
        chosen, share = list[int](), MIN_SHARE_BY_BALANCE
        free = self.unseen_errors(self.rows.places(terms), None)
        errors = self.unseen_errors(self.rows.places(terms), self.bounds)
        while True:
            trials = {
                joint: self.unseen_errors(self.rows.places(terms, [*chosen, joint]), self.bounds)
                for joint in range(1, self.rows.joints + 1)
                if joint not in chosen and is_less(free[:, joint - 1], errors[:, joint - 1], share)
            }
            best = min(trials, key=lambda joint: float(trials[joint].sum()), default=None)
            if best is None or ratio(trials[best], free)[best - 1] > MAX_ERROR_OF_BALANCED:
                return chosen
            if not is_less(trials[best][:, best - 1], errors[:, best - 1], share):
                return chosen
            chosen, errors = [*chosen, best], trials[best]

    def expect_bodies(self, places: Sequence[int]) -> None:
        """Raise RefusalError where bodies leave far more of joints than any numbers would."""
        any_numbers, bodies = (self.unseen_errors(places, own) for own in (None, self.bounds))
        far = 1 + np.flatnonzero(ratio(bodies, any_numbers) > MAX_ERROR_OF_BODIES)
        if len(far):
            raise RefusalError("foreign bodies", joints=[str(joint) for joint in far])


def ratio(errors: Array, others: Array) -> Array:
    """Return how many times squared errors (F, n) of folds and joints are as large as others."""
    times: Array = errors.sum(axis=0) / others.sum(axis=0)
    return times


def is_less(trial: Array, errors: Array, share: float) -> bool:
    """Return whether squared errors on left-out folds (F,) are surely less, and by some share.

    A paired t-test of their logarithms over the folds.
    """
    gain = np.log(errors / trial)
    deviation = gain.std(ddof=1) / np.sqrt(len(gain))
    return bool(gain.mean() > max(share, MIN_DEVIATIONS * deviation))


def with_bodies(value: Array, spread: Array, size: int, bounds: LinkBounds) -> Array:
    """Return coefficients (C,) whose first `size`, the links', are those of bodies.

    value, S = spread: estimate and its covariance S Sᵀ. The nearest in its metric: the rest follows
    the links by what they share.
    """
    root = marginal_root(spread, size)
    parameters = nearest_bodies(value[:size], root, bounds)
    # the smallest u of (π - π̂) = S_π u moves the rest by S u
    move = np.linalg.lstsq(spread[:size], parameters - value[:size], rcond=None)[0]
    moved: Array = value + spread @ move
    return np.append(parameters, moved[size:])


def marginal_root(spread: Array, size: int) -> Array:
    """Return R (size, size) with R Rᵀ the covariance of the first coefficients of S Sᵀ."""
    triangle = np.asarray(np.linalg.qr(spread[:size].T, mode="r"), dtype=np.float64)
    return triangle.T


def of_links(estimate: InertialEstimate, size: int) -> InertialEstimate:
    """Return the part of an estimate that are the inertial parameters of links and rotors."""
    return replace(
        estimate,
        parameters=estimate.parameters[:size],
        scatter=estimate.scatter[:, :size],
        spread=marginal_root(estimate.spread, size),
        rounding=estimate.rounding[:size],
        width=estimate.width[:size],
    )


def arm_prior(robot: Robot, rows: TorqueRows) -> tuple[Array, Array]:
    """Return mean and standard deviation (P,) of all columns' coefficients before the data.

    Half the arm's weight in equal links, m ± m each, with their centres midway; moments ± m L / 4,
    inertias ± m L² and rotors m L² ± m L² of an arm of length L; all else 0 ± the largest torque.
    """
    tails = [link_tail(pose)[1] for pose in robot.link_poses()]
    length, largest = float(np.linalg.norm(tails, axis=1).sum()), rows.largest_torque()
    # where the weight is not described, that which the largest torque holds at full length
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
    """Return where links' centres of mass may lie, and their weight, as far as it is described."""
    tails = np.array([link_tail(pose)[1] for pose in robot.link_poses()])
    margin = CENTER_MARGIN_SHARE * np.linalg.norm(tails, axis=1).sum()
    low, high = np.minimum(tails, 0) - margin, np.maximum(tails, 0) + margin
    return LinkBounds(robot.weight, low, high)
