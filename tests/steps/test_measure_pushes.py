"""Trial pushes on an arm's recordings: which are tried, and what the stated ones rest on."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.made_records import motion_of, signals_of, stretch
from tests.made_up_torques import MODEL, PRIOR, free_run
from tests.steps.made_recording import known_of
from ur5lib.errors import InputError
from ur5lib.force.force_input import ForceInput
from ur5lib.force.problem import Problem
from ur5lib.force.push_directions import at_rest, push_directions
from ur5lib.force.residual_model import Residuals
from ur5lib.force.smallest_pushes import Needed
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.friction import Friction
from ur5lib.records.prediction import Prediction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian
from ur5lib.steps.estimate_forces import estimate_forces
from ur5lib.steps.measure_pushes import DetectedPushes, Inputs, measure_pushes


@pytest.fixture(scope="module")
def known(ur5: Robot) -> dict[str, Any]:
    """What the step is given of two recordings without contact, of which one was fitted to."""
    made: dict[str, Inputs] = {}
    for seed, name in enumerate(("seen", "new")):
        run = free_run(ur5, seed, seconds=60, period=0.016)
        one = known_of(
            ur5,
            signals_of(run.time, run.q),
            motion_of(run.time, run.q, run.qd),
            Kinematics.of(run.time, run.rotation, 0 * run.q[:, :3], run.jacobian),
            currents=Currents(
                **stretch(run.time), load_doubt=0 * run.q, external_torque=run.torque
            ),
            residuals=Residuals(MODEL),
            friction=Friction(from_=["seen"]),
        )
        known = one.but(forces=one.run(estimate_forces), prediction=Prediction(name == "seen"))
        made[name] = Inputs(**vars(known))
    return made


def measured(
    known: dict[str, Inputs],
    names: Sequence[str],
    ur5: Robot,
    paths: int,
    tried: int = 300,
    posture: list[float] | None = None,
) -> DetectedPushes:
    return measure_pushes(
        {name: known[name] for name in names},
        friction=Friction(paths=paths, from_=["seen"]),
        residuals=Residuals(MODEL),
        threshold={"Fmap": 0.0},
        arm=ur5,
        contact_force_n=15.0,
        trial_pushes=tried,
        pushed_posture=posture,
    )


@pytest.mark.parametrize(
    ("names", "paths", "basis", "reason"),
    [
        (["seen", "new"], 2, "unseen", ""),
        pytest.param(["seen"], 2, "fit", "fitted", marks=pytest.mark.thorough),
        (["seen"], 1, "fit", "one_path"),
        pytest.param(["seen", "new"], 1, "unseen", "one_path", marks=pytest.mark.thorough),
        (["new"], 0, "unseen", "uncalibrated"),  # by the friction of other arms
    ],
)
def test_what_the_trials_rest_on(
    known: dict[str, Any], ur5: Robot, names: list[str], paths: int, basis: str, reason: str
) -> None:
    rows = measured(known, names, ur5, paths, 90).pushes
    assert {row.basis for row in rows} == {basis}
    assert {row.reason for row in rows} - {"undetermined"} == {reason}
    assert all((row.value is None) == (row.reason in ("one_path", "undetermined")) for row in rows)


def test_of_fewer_pushes_less_is_known(known: dict[str, Any], ur5: Robot) -> None:
    """Intervals are wider, and of fewer than ten along an axis nothing is stated."""
    many, few = (
        {(row.motion, row.axis): row for row in measured(known, ["seen", "new"], ur5, 2, n).pushes}
        for n in (900, 90)
    )
    assert few.keys() == many.keys()
    assert 90 <= sum(row.trials for row in few.values()) < 130
    assert 900 <= sum(row.trials for row in many.values()) < 1000
    assert all(row.reason == "undetermined" for row in few.values() if row.trials < 10)
    both = [key for key in few if few[key].std_error and many[key].std_error]
    shares = [few[key].std_error / few[key].value for key in both]
    assert len(both) > 1
    assert np.mean(shares) > 1.5 * np.mean([many[key].std_error / many[key].value for key in both])


def test_the_push_at_a_posture_of_one_s_own_is_that_of_a_resting_arm(ur5: Robot) -> None:
    """In units of what stiction keeps of a push: (dᵀ J S⁻¹ Jᵀ d)^-½."""
    posture = [10.0, -80.0, 70.0, -60.0, -90.0, 30.0]
    needed = {"at rest": Needed(3.0, 0.1)}
    own = [*push_directions([], needed, 100.0, 1000.0, at_rest(ur5, posture, MODEL))]
    assert {row.posture_deg for row in own} == {"10.0 -80.0 70.0 -60.0 -90.0 30.0"}
    assert {(row.motion, row.recording, row.time_s) for row in own} == {("at rest", "", None)}
    linear = geometric_jacobian(ur5, np.radians([posture]))[0, :3]
    kept = (MODEL.stiction * MODEL.breakaway) ** 2
    for row in own:
        angle, axis = np.radians(row.angle_deg), 1 if row.plane == "horizontal" else 2
        direction = np.cos(angle) * np.eye(3)[0] + np.sin(angle) * np.eye(3)[axis]
        unit = ((linear.T @ direction) ** 2 / kept).sum() ** -0.5
        assert (row.unit, row.value) == (pytest.approx(unit), pytest.approx(3 * unit))


def test_a_posture_of_one_s_own_has_the_arm_s_joints(known: dict[str, Any], ur5: Robot) -> None:
    with pytest.raises(InputError, match="5 angles; ur5 has 6 joints"):
        measured(known, ["seen", "new"], ur5, 2, 90, posture=[0.0] * 5)


def test_pushes_tried_together_are_found_as_each_alone(ur5: Robot) -> None:
    """Also on both sides of a gap, of which one is without pose."""
    run = free_run(ur5, 0, seconds=20, period=0.016)
    segment = (run.time > 10).astype(np.int64)
    one = ForceInput(run.q, run.qd, run.torque, run.states, segment, 0.016)
    problem = Problem(one, MODEL)
    jacobian = np.where((problem.rows < 300)[:, None, None], np.nan, run.jacobian[problem.rows])
    pushes = np.random.default_rng(0).normal(0, 3, (3, *run.torque.shape)).cumsum(axis=1) / 30
    together = problem.contact_log_odds(pushes, jacobian, PRIOR)
    for own, push in zip(together, pushes, strict=True):
        [alone] = problem.contact_log_odds(push[None], jacobian, PRIOR)
        np.testing.assert_array_equal(own, alone)
        assert np.isfinite(own).any()
        assert np.isnan(own).any()


def test_a_recording_with_a_load_is_not_pushed(known: dict[str, Any], ur5: Robot) -> None:
    load = SimpleNamespace(is_loaded=True, fitted=False)
    loaded = {
        "new": Inputs(**vars(known["new"]) | {"prediction": load}),
        "seen": known["seen"],
    }
    assert {row.basis for row in measured(loaded, ["seen", "new"], ur5, 2, 90).pushes} == {"fit"}
    assert measured(loaded, ["new"], ur5, 2) == ([], [], [])


def test_pushes_by_direction_and_force_are_those_of_the_same_trials(
    known: dict[str, Any], ur5: Robot
) -> None:
    """A direction needs as many units as every other; the larger a push, the more are found."""
    found = measured(known, ["seen", "new"], ur5, 2)
    motions = {row.motion for row in found.curve}
    assert {row.motion for row in found.directions} <= motions
    for motion in motions:
        share = [row.share for row in found.curve if row.motion == motion]
        assert sorted(share) == share
        assert 0 <= share[0] < 0.5 < share[-1] <= 1
        known_units = [row for row in found.directions if row.motion == motion and row.value]
        units = [row.value / row.unit for row in known_units if row.value and row.unit]
        assert units == pytest.approx([units[0]] * len(units)) if units else not known_units
    assert any(row.value for row in found.directions)
    one_path = measured(known, ["seen", "new"], ur5, 1, 90)
    assert one_path.pushes
    assert not one_path.directions
    assert not one_path.curve
