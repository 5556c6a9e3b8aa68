"""The cut-off of the currents' low-pass sets all that depends on how slow it makes them."""

import numpy as np
import pytest

from tests.made_up_torques import MODEL
from ur5lib.force.external_torque import JointState, joint_states
from ur5lib.force.wrench_estimate import used_rows

PERIOD = 0.002  # s


@pytest.mark.parametrize(("cutoff", "reach"), [(2.0, 0.25), (5.0, 0.1)])
def test_a_reversal_blurs_friction_as_far_as_the_low_pass_reaches(
    cutoff: float, reach: float
) -> None:
    time = np.arange(-2, 2, PERIOD)
    slow = np.abs(time) < 0.05  # too short for a stop
    qd = np.where(slow, 0.0, np.sign(time))[:, None]
    states = joint_states(qd, np.zeros(len(time), int), PERIOD, cutoff)[:, 0]
    blurred = time[states == JointState.REVERSING]
    assert np.ptp(blurred) == pytest.approx(2 * (0.05 + reach), abs=0.01)


@pytest.mark.parametrize(("cutoff", "step"), [(2.0, 0.032), (8.0, 0.008), (1000.0, PERIOD)])
def test_samples_are_thinned_as_far_as_the_low_pass_allows(cutoff: float, step: float) -> None:
    rows = used_rows(np.zeros(100, int), PERIOD, cutoff)
    assert np.diff(rows) * PERIOD == pytest.approx(step)


def test_a_residual_model_knows_the_cut_off_of_its_torques() -> None:
    assert MODEL.cutoff == 2.0
