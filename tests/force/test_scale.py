"""An estimate without a newton of its own: all torques times s give s times the force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from tests.made_up_torques import MODEL, PERIOD, PRIOR, Free, free_run
from ur5lib.force.force_input import Gears
from ur5lib.force.residual_model import ResidualModel, TorqueStretch, fit_residual_model
from ur5lib.force.thresholds import alarms
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench, used_rows
from ur5lib.robots.description import Robot

SCALES = pytest.mark.parametrize("s", [0.1, 0.3, 3.0, 20.0])
SAME = 1e-6


def touched(ur5: Robot, moving: bool) -> Free:
    """A run with three pushes, of which the first is slow."""
    run = free_run(ur5, 7, moving=moving)
    force = np.zeros((len(run.time), 3))
    for start, seconds, size in ((2.0, 6.0, 20.0), (11.0, 1.5, 40.0), (17.0, 1.0, 90.0)):
        part = np.clip((run.time - start) / seconds, 0, 1)
        force += size * np.sin(np.pi * part)[:, None] ** 2 * [0.6, -0.48, 0.64]
    return run.pushed(run.wrench(force, np.array([0.0, 0.02, 0.1])))


def fitted(ur5: Robot, s: float) -> ResidualModel:
    """By a run in motion and one at rest."""
    runs = [free_run(ur5, seed, moving=moving) for seed, moving in ((1, True), (2, False))]
    stretches = [TorqueStretch(s * run.torque, run.states, PERIOD) for run in runs]
    model = fit_residual_model(stretches, MODEL.cutoff, s * MODEL.breakaway)
    return model.with_usual_rest(stretches).of_few_paths(3)


def estimated(ur5: Robot, moving: bool, s: float) -> WrenchEstimate:
    """What is estimated of the run, with all torques and the typical force times s."""
    run = touched(ur5, moving)
    turning = np.sign(run.qd)
    gears = Gears(s * np.full_like(run.qd, 20.0), 0.1 * turning, s * 2.0 * turning)
    own = run.input(torque=s * run.torque, gears=gears, doubt=s * np.full_like(run.qd, 0.2))
    rows = used_rows(own.segment, own.period, MODEL.cutoff)
    prior = replace(PRIOR, force=s * PRIOR.force)
    place = run.rotation[rows] @ np.array([0.0, 0.0, 0.1])
    return estimate_wrench(own, run.jacobian[rows], fitted(ur5, s), prior, place)


@SCALES
@pytest.mark.parametrize("moving", [True, False])
def test_an_arm_of_s_times_the_torque_feels_s_times_the_force(
    ur5: Robot, moving: bool, s: float
) -> None:
    usual, own = (estimated(ur5, moving, factor) for factor in (1.0, s))
    assert alarms(usual.log_odds, 0.0) == alarms(own.log_odds, 0.0) != []
    # beyond even odds of a billion, a probability has no further digit
    np.testing.assert_allclose(expit(own.log_odds), expit(usual.log_odds), atol=1e-9)
    for name in ("wrench", "std", "background", "least_squares", "least_squares_std"):
        one, other = getattr(usual, name), getattr(own, name) / s
        np.testing.assert_allclose(other, one, rtol=SAME, atol=SAME * np.abs(one).max())
