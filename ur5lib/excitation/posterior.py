"""What an arm's recordings have told: the problem of its parameters, and the information so far."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.problem import Maps, Noise, Problem, build_problem, nominal_maps
from ur5lib.identification.currents import CurrentFit, Parameter
from ur5lib.identification.population import Population
from ur5lib.identification.samples import STEP as INDEPENDENT
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

KEPT = ("torque_constant", "offset", "coulomb", "viscous", "load")  # of a fit's coefficients
ROUNDS = 4  # iterations, after which predicted standard errors are within 3 % of the study's


class Recorded(NamedTuple):
    """Independent states of a recording: link model with its payload and mounting, regressor Y
    (N, n, 11 n), velocities (N, n) [rad/s].
    """

    model: LinkModel
    Y: Array
    qd: Array

    @classmethod
    def along(cls, robot: Robot, time: Array, *motion: Array) -> Self:
        """Return the states of a recording every INDEPENDENT, without unknown ones.

        robot: mounted, with its payload; time: (N,) [s]; motion: q, q̇, q̈, (N, n) each.
        """
        model = LinkModel(robot, robot.fullest_model())
        every = max(1, round(INDEPENDENT / float(np.median(np.diff(time)))))
        states = np.stack(motion)[:, ::every]
        q, qd, qdd = states[:, np.isfinite(states).all(axis=(0, 2))]
        return cls(model, model.regressor(q, qd, qdd), qd)


@dataclass(frozen=True)
class Earlier:
    """What is known of an arm from a study's recordings, and from other arms.

    fit, parameters: of the currents; noise: (n,) [Nm], of the target torques; fitted: to how many
    recordings, 0 where the fit is what other arms have.
    """

    fit: CurrentFit
    parameters: Sequence[Parameter]
    noise: Array | None
    fitted: int
    recordings: Sequence[Recorded]
    population: Population | None

    def maps(self, arm: Robot) -> Maps:
        """Return the maps from torques and motion to currents, with noise; else nominal ones."""
        nominal = nominal_maps(arm)
        torque = nominal.noise.torque if self.noise is None else self.noise
        if not self.fitted:
            return Maps(nominal.coefficients, Noise(torque, nominal.noise.current))
        bands = np.array([joint.band_moving for joint in self.fit.joints]) / NORMAL95
        current = np.where(np.isfinite(bands), bands, nominal.noise.current)
        terms = [
            dict(zip(joint.names(), joint.estimate.coefficients.tolist(), strict=True))
            for joint in self.fit.joints
        ]  # zero for a term that the fit does not have
        kept = [[own.get(name, 0.0) for name in KEPT] for own in terms]
        return Maps(np.array(kept), Noise(torque, current))

    def observed(self) -> Array:
        """Return the standard errors (n, 5) of KEPT, NaN for a missing term."""
        errors = {(row.joint, row.name): row.std_error for row in self.parameters}
        joints = range(1, len(self.fit.joints) + 1)
        return np.array([[errors.get((k, name), np.nan) for name in KEPT] for k in joints])


def problem_after(arm: Robot, known: Earlier, has_payload: bool) -> tuple[Problem, Array]:
    """Return the problem of an arm that a study identified, and the information (P, P) so far.

    arm: as identified; has_payload: whether a load is estimated. The noise of the currents is
    scaled to the study's standard errors, which include correlated residuals and differences
    between recordings.
    """
    model = LinkModel(arm, arm.fullest_model())
    problem = build_problem(arm, model, known.maps(arm), has_payload, known.population)
    if known.fitted:
        problem = _as_observed(problem, known.recordings, known.observed())
    return problem, _information(problem, known.recordings)


def _as_observed(problem: Problem, recordings: Sequence[Recorded], observed: Array) -> Problem:
    """Return the problem with the noise of currents scaled to the observed standard errors (n, 5).

    One factor for each joint: the median over its five parameters, at least 1.
    """
    noise, factor = problem.noise, np.ones(problem.joints)
    for _ in range(ROUNDS):
        errors = problem.standard_errors(_information(problem, recordings))
        predicted = errors[problem.of_currents].reshape(-1, 5)
        factor = np.maximum(factor * np.nanmedian(observed / predicted, axis=1), 1)
        problem = replace(problem, noise=replace(noise, current=noise.current * factor))
    return problem


def _information(problem: Problem, recordings: Sequence[Recorded]) -> Array:
    """Return the information (P, P) of the prior and of recordings."""
    information = problem.prior.copy()
    for model, Y, qd in recordings:
        information += problem.of_model(model.parameters).information(Y, qd, INDEPENDENT)
    return information
