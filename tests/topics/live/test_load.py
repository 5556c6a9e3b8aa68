"""The load of a recording, declared or found: the live estimator carries either."""

import numpy as np
import pytest

from tests.made_records import signals_of
from tests.rubbing_arm import friction, robot
from tests.steps.made_recording import premises
from tests.topics.live.made_arm import arm_file, samples
from ur5lib.records.carried import Carried
from ur5lib.records.prediction import JudgedLoad, Prediction
from ur5lib.robots.description import Payload
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.topics.live.estimate_live import Inputs, estimate_live
from ur5lib.topics.live.live_file import LiveFit
from ur5lib.topics.live.rows import LiveForces

LOAD = Payload(mass=3.0, center_of_mass=(0.02, -0.05, 0.1))
TOOL = Payload(mass=1.0, center_of_mass=(0.0, 0.01, 0.05), inertia=(0.1, 0.1, 0.1, 0, 0, 0))


def found(taken: bool = True) -> Prediction:
    center = np.array(LOAD.center_of_mass)
    judged = JudgedLoad(LOAD.mass, 0.1, (2.8, 3.2), True, 0.0, LOAD.mass, taken, center, 0 * center)
    return Prediction(False, load=judged)


def stated(declared: Payload | None, prediction: Prediction) -> LiveForces:
    """Of a motion without contact and without any load."""
    run = samples(5.0, moving=True)
    known = {name: arm_file()[name] for name in ("speed", "noise", "threshold", "constants")}
    return estimate_live(
        Inputs(
            name="one",
            gravity=[*robot().gravity],
            signals=signals_of(run.time, run.q, actual_qd=run.qd, actual_current=run.current),
            premises=premises(load=Carried(declared, "study", None)),
            prediction=prediction,
        ),
        friction(robot()),
        LiveFit(known),
        robot(),
        None,
    )


@pytest.mark.parametrize("tool", [None, TOOL])
def test_a_load_that_is_found_counts_as_one_that_is_declared(tool: Payload | None) -> None:
    own = stated(tool, found())
    declared = stated(LOAD.joined(tool), Prediction(False))
    np.testing.assert_allclose(own.wrench, declared.wrench, atol=1e-9)
    none = stated(tool, found(taken=False))
    assert own.wrench is not None
    assert none.wrench is not None
    weight = (own.wrench - none.wrench)[-1, :3]
    # an arm that does not carry the load which is expected is pushed against its weight
    upward = -np.array(robot().gravity)
    assert weight @ upward > 0.5 * LOAD.mass * upward @ upward
    np.testing.assert_allclose(none.wrench, stated(tool, Prediction(False)).wrench)


@pytest.mark.parametrize("tool", [None, TOOL])
def test_both_loads_are_one_body_on_the_last_link(tool: Payload | None) -> None:
    arm, carried = robot(), found().with_load(tool)
    bodies = rigid_bodies(arm.carrying(carried), "C")
    each = rigid_bodies(arm.carrying(tool).carrying(LOAD), "C")
    np.testing.assert_allclose(bodies.mass, each.mass)
    np.testing.assert_allclose(bodies.center_of_mass, each.center_of_mass)
    np.testing.assert_allclose(bodies.inertia, each.inertia, atol=1e-12)
