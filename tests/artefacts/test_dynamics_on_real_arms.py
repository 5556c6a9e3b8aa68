"""The models of the real arms, against what their controllers computed."""

import numpy as np
import pytest

from tests.real_arms import RealStudy
from ur5lib.dynamics.link_model import LinkModel

TABLE_5_6 = "Movement_No5_Acc_slow_no_disturbance"


def test_rotors_explain_what_model_c_leaves(real_ur5: RealStudy) -> None:
    """Mean absolute error at the target motion below 0.05 Nm; without rotors up to 1.2 Nm."""
    one = real_ur5.recording(TABLE_5_6)
    received = ~one.signals.interpolated
    moment = one.signals.target_moment
    assert moment is not None
    error = np.abs(moment - one.torques.target["C+rotors"])[received]
    assert received.sum() > 3000
    assert (np.nanmean(error, axis=0) < 0.05).all(), error


@pytest.mark.parametrize("number", range(1, 6))
def test_gravity_of_the_ur10e_at_rest(real_ur10e: RealStudy, number: int) -> None:
    one = real_ur10e.recording(f"ur-20_01_17-p{number}")
    signals = one.signals
    assert signals.actual_qd is not None
    assert signals.target_moment is not None
    at_rest = (np.abs(signals.actual_qd).max(axis=1) < 1e-3) & ~signals.interpolated
    torque = LinkModel(one.robot, "maker").gravity_torque(signals.actual_q[at_rest])
    assert at_rest.sum() > 100
    assert np.abs(signals.target_moment[at_rest] - torque).max() < 0.13
