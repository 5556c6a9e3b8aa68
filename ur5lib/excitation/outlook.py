"""Standard errors and intervals of an arm after its recordings, and after another one.

At random states, a predicted current has the errors that differ between recordings, those that
differ between days, and those of the parameters. A force at the flange has the covariance (J Σ⁻¹
Jᵀ)⁻¹, with Σ that of the torques. A load's mass is estimated along a further WEIGHING_DURATION of
motion, together with the parameters.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple, Self

import numpy as np
from scipy.linalg import block_diag

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.problem import (
    CORRELATION_TIME,
    LOAD_WIDTH,
    PREDICTED_ACCELERATION,
    PREDICTED_SPEED,
    DesignProblem,
    Maps,
    MeasurementNoise,
    build_problem,
    nominal_maps,
    random_states,
)
from ur5lib.identification.currents import SEASON, friction_std
from ur5lib.identification.samples import INDEPENDENT_STEP
from ur5lib.records.friction import CurrentFit, Parameter
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import BASE_TERMS
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

KEPT_COEFFICIENTS = ("torque_constant", "offset", *BASE_TERMS)  # a fit keeps these coefficients
SCALING_ROUNDS = 4  # after these, predicted standard errors are within 3 % of the study's
# Speed and acceleration of recordings that may come next.
FAST_MOTION = (1.5, 3.0)  # rad/s, rad/s²
SLOW_MOTION = (0.2, 0.4)
WEIGHING_DURATION = 20.0  # s; a load is found along this long a motion
MIN_LEVER = 1e-6  # m; a smaller lever counts as zero


class RecordedStates(NamedTuple):
    """States of a recording, far enough apart to be independent.

    model: link model with the recording's payload and mounting; Y: its regressor (N, n, 11 n); qd:
    velocities (N, n) [rad/s].
    """

    model: LinkModel
    Y: Array
    qd: Array

    @classmethod
    def along(cls, robot: Robot, time: Array, *motion: Array) -> Self:
        """Return the states of a recording every INDEPENDENT_STEP, without unknown ones.

        robot: mounted, with its payload; time: (N,) [s]; motion: q, q̇, q̈, (N, n) each.
        """
        model = LinkModel(robot, robot.fullest_model())
        stride = max(1, round(INDEPENDENT_STEP / float(np.median(np.diff(time)))))
        states = np.stack(motion)[:, ::stride]
        q, qd, qdd = states[:, np.isfinite(states).all(axis=(0, 2))]
        return cls(model, model.regressor(q, qd, qdd), qd)


@dataclass(frozen=True)
class Earlier:
    """What a study's recordings and other arms have shown of an arm.

    fit: of torques to motor currents; parameters: its torque constants and friction; noise: (n,)
    [Nm], of the controller's target torques, None if unknown; fitted: number of recordings that
    were fitted to, 0 if the fit is that of other arms; recordings: states of the arm's recordings.
    """

    fit: CurrentFit
    parameters: Sequence[Parameter]
    noise: Array | None
    fitted: int
    recordings: Sequence[RecordedStates]

    def maps(self, arm: Robot) -> Maps:
        """Return the maps from torques and motion to currents, with noise; nominal if unfitted."""
        nominal = nominal_maps(arm)
        torque = nominal.noise.torque if self.noise is None else self.noise
        if not self.fitted:
            return Maps(nominal.coefficients, MeasurementNoise(torque, nominal.noise.current))
        bands = np.array([joint.band_moving for joint in self.fit.joints]) / NORMAL95
        current = np.where(np.isfinite(bands), bands, nominal.noise.current)
        terms = [
            dict(zip(joint.names(), joint.estimate.coefficients.tolist(), strict=True))
            for joint in self.fit.joints
        ]  # zero for a term that the fit does not have
        rows = [
            [coefficients.get(name, 0.0) for name in KEPT_COEFFICIENTS] for coefficients in terms
        ]
        return Maps(np.array(rows), MeasurementNoise(torque, current))

    def observed(self) -> Array:
        """Return the standard errors (n, 5) of each joint's KEPT_COEFFICIENTS (torque constant,
        offset, friction), NaN for a term that the fit lacks.
        """
        errors = {(row.joint, row.name): row.std_error for row in self.parameters}
        joints = range(1, len(self.fit.joints) + 1)
        return np.array(
            [[errors.get((k, name), np.nan) for name in KEPT_COEFFICIENTS] for k in joints]
        )


def problem_after(arm: Robot, earlier: Earlier, has_payload: bool) -> tuple[DesignProblem, Array]:
    """Return the problem of an arm that a study identified, and the information (P, P) so far.

    arm: as identified; has_payload: whether a load is estimated. The noise of the currents is
    scaled to reach the study's standard errors, which include correlated residuals and differences
    between recordings.
    """
    model = LinkModel(arm, arm.fullest_model())
    problem = build_problem(arm, model, earlier.maps(arm), has_payload, typical=True)
    if earlier.fitted:
        problem = _as_observed(problem, earlier.recordings, earlier.observed())
    return problem, _information(problem, earlier.recordings)


def _as_observed(
    problem: DesignProblem, recordings: Sequence[RecordedStates], observed: Array
) -> DesignProblem:
    """Return the problem with the noise of currents scaled to the observed standard errors (n, 5).

    One factor for each joint: the median over its five parameters, at least 1.
    """
    noise, factor = problem.noise, np.ones(problem.joints)
    for _ in range(SCALING_ROUNDS):
        errors = problem.standard_errors(_information(problem, recordings))
        predicted = errors[problem.of_currents].reshape(-1, 5)
        factor = np.maximum(factor * np.nanmedian(observed / predicted, axis=1), 1)
        problem = replace(problem, noise=replace(noise, current=noise.current * factor))
    return problem


def _information(problem: DesignProblem, recordings: Sequence[RecordedStates]) -> Array:
    """Return the information (P, P) of the prior and of recordings."""
    information = problem.prior.copy()
    for model, Y, qd in recordings:
        information += problem.of_model(model.parameters).information(Y, qd, INDEPENDENT_STEP)
    return information


@dataclass(frozen=True)
class Bands:
    """Half-widths of the 95 % intervals of a force in contact [N], a current [A] and a load's mass
    [kg].

    after: name of a recording that may come next, "now" without any.
    """

    after: str
    force: float
    current: float
    mass: float


def feels_forces(arm: Robot) -> bool:
    """Return whether forces at the flange load an arm's joints in all directions."""
    linear = flange_kinematics(arm, random_states(arm, *FAST_MOTION)[0])[2][:, :3]
    return bool(np.linalg.matrix_rank(linear, tol=MIN_LEVER).max() == 3)


class Outlook:
    """The bands of an arm after further recordings; requires `feels_forces`."""

    def __init__(self, arm: Robot, earlier: Earlier) -> None:
        """Evaluate the arm at random states; information (P, P): of the prior and recordings."""
        problem, self.information = problem_after(arm, earlier, has_payload=False)
        q, qd, qdd = random_states(arm, PREDICTED_SPEED, PREDICTED_ACCELERATION)
        Y = LinkModel(arm, arm.fullest_model()).regressor(q, qd, qdd)
        self.problem, self._arm, self._known = problem, arm, earlier
        self._rows = problem.rows(problem.theta, Y, qd)[:, problem.joints :]  # over the noise
        self._friction = problem.friction_current(Y, qd)
        self._with_load = problem.rows_with_load(Y, qd)
        self._jacobian = flange_kinematics(arm, q)[2][:, :3]

    def bands(self, information: Array, after: str = "now") -> Bands:
        """Return the bands for an information (P, P) on the parameters; after: name of the
        recording that contributes to it, "now" without any.
        """
        residual_variance = self._within() ** 2 + (friction_std(SEASON) * self._friction) ** 2
        rows = self._rows * self.problem.noise.current[:, None]
        doubt = rows @ np.linalg.inv(information) @ rows.mT  # (N, n, n) [A²]
        # cov i = ∂i/∂θ M⁻¹ ∂i/∂θᵀ + what recordings and days differ in
        current = doubt + residual_variance[..., None] * np.eye(self.problem.joints)
        constant = 1 / self.problem.theta[self.problem.of_currents][::5]
        # (J Σ⁻¹ Jᵀ)⁻¹, Σ = diag(k) cov i diag(k)
        torque = np.linalg.inv(current * np.outer(constant, constant))
        force = np.linalg.inv(self._jacobian @ torque @ self._jacobian.mT)
        variances = (
            np.median(np.trace(force, axis1=1, axis2=2)) / 3,
            np.trace(current, axis1=1, axis2=2).mean() / self.problem.joints,
            self._mass(information, residual_variance),
        )
        return Bands(after, *(NORMAL95 * float(np.sqrt(variance)) for variance in variances))

    def ranked(self, candidates: Iterable[tuple[str, Array]]) -> list[Bands]:
        """Return the present bands, then those after each candidate recording, with the smallest
        band of the force first.

        candidates: names, and the information (P, P) that they add.
        """
        rows = [self.bands(self.information + gain, name) for name, gain in candidates]
        return [self.bands(self.information), *sorted(rows, key=attrgetter("force"))]

    def candidates(self, seconds: float) -> Iterator[tuple[str, Array]]:
        """Yield possible recordings by name, and the information (P, P) that each adds."""
        load = self._arm.known_load()
        loaded = [(f"all joints with {load.mass:g} kg", load, FAST_MOTION)] if load else []
        for name, load, motion in (
            ("all joints", None, FAST_MOTION),
            ("all joints slowly", None, SLOW_MOTION),
            *loaded,
        ):
            model = LinkModel(self._arm.carrying(load), self._arm.fullest_model())
            q, qd, qdd = random_states(self._arm, *motion)
            problem = self.problem.of_model(model.parameters)
            Y = model.regressor(q, qd, qdd)
            yield f"{seconds:g} s, {name}", problem.information(Y, qd, seconds / len(q))

    def _within(self) -> Array:
        """Return the standard deviations (n,) [A] of predicted currents on a recording, from the
        bands of the fit; nominal ones where it has none.
        """
        errors = np.array([joint.band_moving for joint in self._known.fit.joints]) / NORMAL95
        return np.where(np.isfinite(errors), errors, self.problem.noise.current)

    def _mass(self, information: Array, residual_variance: Array) -> float:
        """Return the variance [kg²] of a load's mass that is estimated from WEIGHING_DURATION
        seconds of the random states.

        residual_variance: variance (N, n) [A²] of currents, independent every CORRELATION_TIME.
        """
        count = len(information)
        load = np.diag(LOAD_WIDTH**-2.0)
        relative = self.problem.noise.current / np.sqrt(residual_variance)  # (N, n)
        J = (self._with_load * relative[..., None]).reshape(-1, count + 10)
        seconds = WEIGHING_DURATION / CORRELATION_TIME / len(relative)
        # information on θ and p together; its inverse has the variances of p
        joint_information = block_diag(information, load) + J.T @ J * seconds
        return float(np.linalg.inv(joint_information)[count, count])
