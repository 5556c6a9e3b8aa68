"""Which external torques a contact force is estimated from."""

import numpy as np
import pytest

from tests.library.made_up_torques import MODEL
from tests.made_records import motion_of, stretch
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.records.currents import Currents

RESIDUALS = Residuals(tau_ext=MODEL)


@pytest.mark.parametrize("known", [0, 1])
def test_no_force_is_stated_where_no_torque_is_known(known: int) -> None:
    """As of a recording that is shorter than its low-pass; before, it had no force, for certain."""
    time, torque = 0.008 * np.arange(50), np.full((50, 6), np.nan)
    torque[20 : 20 + known] = 0.1
    currents = Currents(**stretch(time), external_torque=torque)
    motion = motion_of(time, 0 * torque, 0 * torque)
    assert (fmap_problem(motion, currents, RESIDUALS) is not None) == bool(known)
