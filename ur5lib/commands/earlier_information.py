"""Information about an arm in the recordings of a study, for the design of the next one."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.problem import (
    INDEPENDENT,
    Maps,
    Noise,
    Problem,
    build_problem,
    nominal_maps,
)
from ur5lib.finished import FinishedStudy
from ur5lib.identification.currents import CurrentFit, JointFit
from ur5lib.pipeline.records.motion import Motion
from ur5lib.robots.description import Robot
from ur5lib.tables import as_record
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

KEPT = ("torque_constant", "offset", "coulomb", "viscous", "load")  # of a fit's coefficients
ROUNDS = 4  # iterations, after which predicted standard errors are within 3 % of the study's


class Recorded(NamedTuple):
    """Independent states of a recording: link model with its payload and mounting, regressor Y
    (N, 6, 66), velocities (N, 6) [rad/s].
    """

    model: LinkModel
    Y: Array
    qd: Array


def problem_after(
    arm: Robot, model: LinkModel, study: FinishedStudy, has_payload: bool
) -> tuple[Problem, Array]:
    """Return the problem of an arm that a study identified, and the information (P, P) so far.

    arm: as identified; has_payload: whether a load is estimated. The noise of the currents is
    scaled to the study's standard errors, which include correlated residuals and differences
    between recordings. Raises InputError where a file is missing.
    """
    friction, base = (study.fitted(arm.name, name) for name in ("friction", "identification"))
    problem = build_problem(arm, model, _maps(arm, friction, base), has_payload)
    recordings = [*_recorded(arm, study, sorted({*friction["from"], *base["from"]}))]
    if friction["from"]:
        problem = _as_observed(problem, recordings, _observed(friction))
    return problem, _information(problem, recordings)


def _maps(arm: Robot, friction: Any, base: Any) -> Maps:
    """Return the fitted maps from torque and motion to currents, with noise; else nominal ones."""
    nominal = nominal_maps(arm)
    torque = np.array(base.get("noise") or nominal.noise.torque)
    if not friction["from"]:
        return Maps(nominal.coefficients, Noise(torque, nominal.noise.current))
    fit = as_record(CurrentFit, friction["fit"])
    bands = np.array([joint.band_moving for joint in fit.joints]) / NORMAL95
    current = np.where(np.isfinite(bands), bands, nominal.noise.current)
    return Maps(np.array([_kept(joint) for joint in fit.joints]), Noise(torque, current))


def _kept(joint: JointFit) -> list[float]:
    """Return a joint's coefficients of KEPT; zero for a term that the fit does not have."""
    fitted = dict(zip(joint.names(), joint.estimate.coefficients.tolist(), strict=True))
    return [fitted.get(name, 0.0) for name in KEPT]


def _observed(friction: Any) -> Array:
    """Return a study's standard errors (6, 5) of KEPT, NaN for a missing term."""
    errors = {(row["joint"], row["name"]): row["std_error"] for row in friction["parameters"]}
    return np.array([[errors.get((k, name), np.nan) for name in KEPT] for k in range(1, 7)])


def _recorded(arm: Robot, study: FinishedStudy, names: Sequence[str]) -> Iterator[Recorded]:
    """Yield the states of recordings."""
    for name in names:
        robot = arm.carrying(study.payload(name))
        robot = robot.mounted(study.recording(name).known_gravity())
        model = LinkModel(robot, robot.fullest_model())
        motion = study.record(Motion, name)
        every = max(1, round(INDEPENDENT / float(np.median(np.diff(motion.time)))))
        states = np.stack([motion.q, motion.qd, motion.qdd])[:, ::every]
        q, qd, qdd = states[:, np.isfinite(states).all(axis=(0, 2))]
        yield Recorded(model, model.regressor(q, qd, qdd), qd)


def _as_observed(problem: Problem, recordings: Sequence[Recorded], observed: Array) -> Problem:
    """Return the problem with the noise of currents scaled to the observed standard errors (6, 5).

    One factor for each joint: the median over its five parameters, at least 1.
    """
    noise, factor = problem.noise, np.ones(6)
    for _ in range(ROUNDS):
        errors = problem.standard_errors(_information(problem, recordings))
        predicted = errors[problem.of_currents].reshape(6, 5)
        factor = np.maximum(factor * np.nanmedian(observed / predicted, axis=1), 1)
        problem = replace(problem, noise=replace(noise, current=noise.current * factor))
    return problem


def _information(problem: Problem, recordings: Sequence[Recorded]) -> Array:
    """Return the information (P, P) of the prior and of recordings."""
    information = problem.prior.copy()
    for model, Y, qd in recordings:
        information += problem.of_model(model.parameters).information(Y, qd, INDEPENDENT)
    return information
