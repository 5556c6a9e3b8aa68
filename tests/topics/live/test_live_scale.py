"""A live estimate without a newton of its own: all torques times s give s times the force."""

from typing import Any

import numpy as np
import pytest

from tests.topics.live.made_arm import arm_file, push, samples
from ur5lib.topics.live.live_file import learned
from ur5lib.topics.live.live_recording import Followed, follow

SAME = 1e-6


def followed(s: float) -> Followed:
    """A run with a push by the live estimator, whose noise a free run teaches."""
    arm: dict[str, Any] = arm_file()
    for name in ("rotor_inertia", "torque_constant", "offset", "breakaway"):
        arm[name] = [s * value for value in arm[name]]
    for link in arm["links"]:
        link["mass"] *= s
        link["inertia"] = (s * np.array(link["inertia"])).tolist()
    rubs = arm["friction"]
    for name, values in rubs["terms"].items():
        rubs["terms"][name] = [(1.0 if name == "load" else s) * value for value in values]
    for part in rubs["presliding"]:
        part["held"] = [s * value for value in part["held"]]
    arm["contacts"]["typical"] *= s
    arm["contacts"]["sizes"] = [s * size for size in arm["contacts"]["sizes"]]
    known = learned([(arm, samples(20.0, True))], 5, 1.0)
    return follow(arm | known, samples(8.0, True, push(6.0, 7.0, 20.0, -25.0, 15.0)))


@pytest.mark.parametrize("s", [0.1, 0.3, 3.0, 20.0])
def test_an_arm_of_s_times_the_torque_feels_s_times_the_force_live(s: float) -> None:
    usual, own = followed(1.0), followed(s)
    assert usual.alarms() == own.alarms() != []
    np.testing.assert_allclose(own.evidence, usual.evidence, rtol=SAME, atol=SAME)
    for name in ("wrench", "std", "torque"):
        one, other = getattr(usual, name), getattr(own, name) / s
        np.testing.assert_allclose(other, one, rtol=SAME, atol=SAME * np.abs(one).max())
