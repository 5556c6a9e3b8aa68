"""The objective for optimising a trajectory, with its exact gradient, and a trajectory's worth.

The question for which a recording is designed decides the criterion on its information.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lab.excitation.trajectory import DISTANCE_REACH, Path, States, WorkCell, resting_series
from ur5lib.excitation.problem import (
    PREDICTED_ACCELERATION,
    PREDICTED_SPEED,
    DesignProblem,
    information_of,
    random_states,
)
from ur5lib.identification.samples import INDEPENDENT_STEP
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.profiles import fourier_terms

Criterion = Callable[[Array], tuple[float, Array]]
"""From the information M (P, P) to a value, the larger the better, and its gradient (P, P)."""

CONDITION_WEIGHT = 30.0  # of log condition numbers relative to log det
MIN_EIGENVALUE_SHARE = 1e-12  # of the largest eigenvalue; smaller ones are rounding errors
MAX_SERIES_FREQUENCY = 0.6  # Hz; faster harmonics excite elastic joints
MIN_HARMONICS = 4
MAX_HARMONICS = 30
STATE_STEP = 0.05  # s; between the states at which the optimisation evaluates a path
USED_LIMIT_SHARE = 0.97  # of each limit, that the optimisation may use
# A standard error that keeps more than this share counts as not lowered by a recording.
MIN_KEPT_ERROR_SHARE = 0.9


def d_optimality(estimated: Mask) -> Criterion:
    """Return the criterion log det of the information on the estimated parameters, with the others
    unknown, too.

    D_s-optimality: log det M - log det M_oo, the log det of the Schur complement, with o the other
    parameters. estimated: which parameters (P,).
    """
    other_parameters = np.ix_(~estimated, ~estimated)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        gradient = np.asarray(np.linalg.inv(information), np.float64)
        gradient[other_parameters] -= np.linalg.inv(information[other_parameters])
        value = (
            np.linalg.slogdet(information)[1] - np.linalg.slogdet(information[other_parameters])[1]
        )
        return float(value), gradient

    return value_and_gradient


def i_optimality(rows: Array) -> Criterion:
    """Return the criterion -P/2 log v, with v the mean variance of the predictions rows · θ.

    rows: (N, P).
    """
    weight, half = rows.T @ rows / len(rows), rows.shape[1] / 2

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        # v = tr(W M⁻¹), dv/dM = -M⁻¹ W M⁻¹
        covariance = np.linalg.inv(information)
        mean = float(np.sum(weight * covariance))
        return -half * float(np.log(mean)), half / mean * covariance @ weight @ covariance

    return value_and_gradient


def conditioning(scale: Array) -> Criterion:
    """Return the criterion -log of the condition number of the information on parameters in units
    of a scale (P,).

    Parameters with scale zero are left out. The criterion is zero if the condition number is too
    large for double precision.
    """
    scaled = np.ix_(scale > 0, scale > 0)
    weight = np.outer(scale, scale)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        values, vectors = np.linalg.eigh((weight * information)[scaled])
        gradient = np.zeros_like(information)
        if values[0] < MIN_EIGENVALUE_SHARE * values[-1]:
            return 0.0, gradient
        # ∂ log(λ_min / λ_max) / ∂M = v vᵀ / λ of both
        lowest_slope, highest_slope = (
            np.outer(vectors[:, k], vectors[:, k]) / values[k] for k in (0, -1)
        )
        gradient[scaled] = lowest_slope - highest_slope
        return float(np.log(values[0] / values[-1])), weight * gradient

    return value_and_gradient


def _model_criterion(problem: DesignProblem, _: WorkCell) -> Criterion:
    """Return the criterion of D-optimality plus two condition numbers, to which D-optimality is not
    very sensitive.

    One is of the base parameters in SI units, as in the literature, the other of all parameters in
    units of their prior standard deviations.
    """
    of_base = np.where(np.arange(len(problem.theta)) < problem.count, 1.0, 0.0)
    of_all = np.sqrt(np.diag(np.linalg.inv(problem.prior)))
    informed = d_optimality(np.full(len(problem.theta), True))
    conditioned = conditioning(of_base), conditioning(of_all)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        value, gradient = informed(information)
        for part in conditioned:
            added, slope = part(information)
            value, gradient = value + CONDITION_WEIGHT * added, gradient + CONDITION_WEIGHT * slope
        return value, gradient

    return value_and_gradient


def _undetermined_criterion(problem: DesignProblem, _: WorkCell) -> Criterion:
    """Return the criterion of I-optimality for all parameters, in units of their prior standard
    errors.

    The mean square of these ratios counts, in which the largest ones dominate.
    """
    return i_optimality(problem.to_physical() / problem.standard_errors(problem.prior)[:, None])


def _d_optimality_of(problem: DesignProblem, place: slice) -> Criterion:
    """Return the criterion of D-optimality for the parameters θ[place]."""
    estimated = np.zeros(len(problem.theta), dtype=bool)
    estimated[place] = True
    return d_optimality(estimated)


def _force_bands(problem: DesignProblem, cell: WorkCell) -> Criterion:
    """Return the criterion of I-optimality for the currents that are predicted at random states.

    External forces are estimated from the difference between measured and predicted currents.
    """
    q, qd, qdd = random_states(cell.robot, PREDICTED_SPEED, PREDICTED_ACCELERATION)
    rows = problem.rows(problem.theta, cell.model.regressor(q, qd, qdd), qd)
    return i_optimality(rows[:, problem.joints :].reshape(-1, len(problem.theta)))


QUESTIONS: dict[str, Callable[[DesignProblem, WorkCell], Criterion]] = {
    "model": _model_criterion,
    "undetermined": _undetermined_criterion,
    "friction": lambda problem, _: _d_optimality_of(problem, problem.of_currents),
    "payload": lambda problem, _: _d_optimality_of(problem, problem.of_payload),
    "force-bands": _force_bands,
}


@dataclass(frozen=True)
class Task:
    """What is to be designed: a motion in a cell that determines the parameters of a problem.

    criterion: of the information, to be maximised; earlier: the information (P, P) of earlier
    recordings and the prior; seconds: duration of the motion.
    """

    cell: WorkCell
    problem: DesignProblem
    criterion: Criterion
    earlier: Array
    seconds: float

    @property
    def harmonics(self) -> int:
        """Return the number of harmonics of the Fourier series, with frequencies up to
        MAX_SERIES_FREQUENCY.
        """
        return int(np.clip(self.seconds * MAX_SERIES_FREQUENCY, MIN_HARMONICS, MAX_HARMONICS))

    def regressor(self, path: Path) -> tuple[Array, Array]:
        """Return the regressor Y (N, n, 11 n) and q̇ (N, n) along a path, every STATE_STEP
        seconds.
        """
        q, qd, qdd, _ = path.sampled(1 / STATE_STEP)[1]
        return self.cell.model.regressor(q, qd, qdd), qd

    def information(self, path: Path) -> Array:
        """Return the information (P, P) of earlier recordings and of a recording along a path."""
        return self.earlier + self.problem.information(*self.regressor(path), STATE_STEP)


class Objective:
    """The function of a path to be minimised: a penalty for broken limits minus the criterion, with
    its gradient.

    The variables x of a path are its posture (n,) and the coefficients (K, n) of series that begin
    and end at rest (`resting_series`).
    """

    def __init__(self, task: Task) -> None:
        self._task, self._joints = task, len(task.cell.middle)
        time = np.arange(0, task.seconds, STATE_STEP)
        self._basis = resting_series(task.seconds, task.harmonics)
        terms = fourier_terms(task.seconds, task.harmonics, time)
        self._terms = [term @ self._basis for term in terms]  # (N, K) each

    def path(self, x: Array) -> Path:
        """Return the path with the variables x."""
        posture, weights = self._parts(x)
        return Path(posture, self._basis @ weights, self._task.seconds)

    def variables(self, path: Path) -> Array:
        """Return the variables x of a path that rests at both ends."""
        weights = np.linalg.lstsq(self._basis, path.coefficients, rcond=None)[0]
        return np.concatenate([path.posture, weights.ravel()])

    def states(self, x: Array) -> States:
        """Return the states along the path of x at which limits are checked, one every STATE_STEP
        seconds.
        """
        posture, weights = self._parts(x)
        q, qd, qdd, jerk = (term @ weights for term in self._terms)
        return States(q + posture, qd, qdd, jerk)

    def _parts(self, x: Array) -> tuple[Array, Array]:
        """Return the posture (n,) and the coefficients (K, n) of x."""
        return x[: self._joints], x[self._joints :].reshape(-1, self._joints)

    def __call__(self, x: Array, weight: float) -> tuple[float, Array]:
        """Return the criterion less the weighted penalty, and its gradient, both negated."""
        task, states = self._task, self.states(x)
        Y, pull_back = task.cell.model.differentiable_regressor(*states[:3])
        value, of_Y, of_qd = self._informed(Y, states.qd)
        penalty, of_states, of_torque = self._penalties(states, task.problem.torque(Y))
        of_Y -= weight * task.problem.pull_back_torque(of_torque)
        slopes = [-weight * part for part in of_states]
        for slope, part in zip(slopes, pull_back(of_Y), strict=False):
            slope += part
        slopes[1] += of_qd
        of_weights = sum(term.T @ slope for term, slope in zip(self._terms, slopes, strict=True))
        gradient = np.concatenate([slopes[0].sum(axis=0), np.ravel(of_weights)])
        return weight * penalty - value, -gradient

    def _informed(self, Y: Array, qd: Array) -> tuple[float, Array, Array]:
        """Return the criterion of the information by Y and q̇, and its derivatives by these."""
        task, problem = self._task, self._task.problem
        J = problem.rows(problem.theta, Y, qd)
        value, of_information = task.criterion(task.earlier + information_of(J, STATE_STEP))
        return value, *problem.pull_back(
            Y, qd, 2 * STATE_STEP / INDEPENDENT_STEP * J @ of_information
        )

    def _penalties(self, states: States, torque: Array) -> tuple[float, list[Array], Array]:
        """Return the sum of squared excesses over the limits, and its derivatives by states and
        torque.
        """
        cell, total, slopes = self._task.cell, 0.0, []
        parts = [*cell.limited(states), torque]
        for part, limit in zip(parts, cell.limits.of_joints(), strict=True):
            over = np.maximum(np.abs(part) / (USED_LIMIT_SHARE * limit) - 1, 0)  # (N, n)
            total += float(np.sum(over**2))
            slopes.append(2 * over * np.sign(part) / (USED_LIMIT_SHARE * limit))
        for value, slope in (self._nearness(states.q), self._singularity(states.q)):
            total += value
            slopes[0] += slope
        return total, slopes[:4], slopes[4]

    def _nearness(self, q: Array) -> tuple[float, Array]:
        """Return the penalty for parts that are too close, and its derivative by q (N, n)."""
        min_distance = self._task.cell.limits.clearance / USED_LIMIT_SHARE
        clearances = self._task.cell.capsules.near(q, gradient_below=min_distance)
        missing = np.maximum(min_distance - clearances.distance, 0) / DISTANCE_REACH
        slope = np.zeros_like(q)
        np.add.at(
            slope, clearances.sample, -2 / DISTANCE_REACH * missing[:, None] * clearances.gradient
        )
        return float(missing @ missing), slope

    def _singularity(self, q: Array) -> tuple[float, Array]:
        """Return the penalty for singular values that are too small, and its derivative by q (N,
        n).
        """
        min_value = self._task.cell.limits.singular_value / USED_LIMIT_SHARE
        slope, missing = np.zeros_like(q), np.zeros(len(q))
        low = self._task.cell.singular_value(q) < min_value
        if low.any():
            value, pull_back = self._task.cell.differentiable_singular_value(q[low])
            missing[low] = np.maximum(1 - value / min_value, 0)
            (slope[low],) = pull_back(-2 / min_value * missing[low])
        return float(missing @ missing), slope


@dataclass(frozen=True)
class Worth:
    """What a recording would add to the prior and to earlier recordings.

    log_det: log det of the information M (P, P) after the recording; gain: increase by the
    recording; regressor_condition: condition number of the base parameters' regressor in SI units
    (Gautier 1992); condition: condition number of J, with columns in units of the prior standard
    deviation, infinite without target torques, which separate masses from gains; prior, before,
    after: standard errors (P,) of `DesignProblem.names` in physical units, by the prior alone,
    before the recording, and after it.
    """

    log_det: float
    gain: float
    regressor_condition: float
    condition: float
    prior: Array
    before: Array
    after: Array

    def least_determined(self) -> Labels:
        """Return the order of the parameters as indices (P,), the least determined first.

        They are sorted by before / prior, the ratio of standard errors, then by after / prior.
        """
        return np.lexsort([-self.after / self.prior, -np.round(self.before / self.prior, 9)])

    def hardly_lowered(self) -> Mask:
        """Return which parameters (P,) keep most of their standard error after the recording."""
        return np.asarray(self.after > MIN_KEPT_ERROR_SHARE * self.before)

    @classmethod
    def along(cls, task: Task, path: Path) -> Self:
        """Return the worth of recording a path, for a task."""
        return cls.of_states(task, *task.regressor(path))

    @classmethod
    def of_states(cls, task: Task, Y: Array, qd: Array) -> Self:
        """Return the worth of recording states every STATE_STEP seconds; Y, qd: as of
        `Task.regressor`.
        """
        problem = task.problem
        W = Y[..., problem.base.columns].reshape(-1, problem.count)
        J = problem.rows(problem.theta, Y, qd).reshape(-1, len(problem.theta))
        width = np.sqrt(np.diag(np.linalg.inv(problem.prior)))
        states_torques = np.isfinite(problem.noise.torque).all()
        information = task.earlier + problem.information(Y, qd, STATE_STEP)
        log_det, earlier = (np.linalg.slogdet(matrix)[1] for matrix in (information, task.earlier))
        return cls(
            log_det=float(log_det),
            gain=float(log_det - earlier),
            regressor_condition=float(np.linalg.cond(W)),
            condition=float(np.linalg.cond(J * width)) if states_torques else np.inf,
            prior=problem.standard_errors(problem.prior),
            before=problem.standard_errors(task.earlier),
            after=problem.standard_errors(information),
        )
