"""Which external torques a contact force is estimated from."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_records import motion_of, stretch
from tests.made_up_torques import MODEL
from ur5lib.force.problem import fmap_problem, unusual_friction
from ur5lib.force.residual_model import Residuals
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion

RESIDUALS = Residuals(tau_ext=MODEL)


@pytest.mark.parametrize("known", [0, 1])
def test_no_force_is_stated_where_no_torque_is_known(known: int) -> None:
    """As of a recording that is shorter than its low-pass; before, it had no force, for certain."""
    time, torque = 0.008 * np.arange(50), np.full((50, 6), np.nan)
    torque[20 : 20 + known] = 0.1
    currents = Currents(**stretch(time), external_torque=torque)
    motion = motion_of(time, 0 * torque, 0 * torque)
    assert (fmap_problem(motion, currents, RESIDUALS) is not None) == bool(known)


def moving(shown: float, seconds: float = 8.0) -> tuple[Motion, Currents]:
    """All joints turn to and fro; the currents show a share of the usual friction, and noise."""
    time = 0.008 * np.arange(round(seconds / 0.008))
    qd = np.outer(np.sin(time), np.full(6, 0.5))
    friction = MODEL.breakaway * np.sign(qd)
    noise = 0.05 * np.random.default_rng(1).normal(size=qd.shape)
    currents = Currents(
        **stretch(time),
        external_torque=(1 - shown) * friction + noise,
        friction_torque=friction,
        gear_torque=0 * qd,
        load_loss=0 * qd,
    )
    return motion_of(time, 0.5 * (1 - np.cos(time))[:, None] * np.ones(6), qd), currents


@pytest.mark.parametrize(
    ("shown", "usual", "told"), [(0.55, True, True), (0.9, True, False), (0.55, False, False)]
)
def test_no_force_is_stated_where_a_hand_leads_the_arm_and_nothing_was_fitted(
    shown: float, usual: bool, told: bool
) -> None:
    """Before, it was zero for certain, whatever the hand did."""
    residuals = Residuals(tau_ext=replace(MODEL, usual=usual))
    share = unusual_friction(*moving(shown), residuals)
    assert share == (pytest.approx(shown, abs=0.02) if told else None)
    assert (fmap_problem(*moving(shown), residuals) is None) == told


def test_an_arm_at_rest_shows_no_friction() -> None:
    motion, currents = moving(0.1, seconds=1.0)
    assert unusual_friction(motion, currents, Residuals(tau_ext=replace(MODEL, usual=True))) is None
