"""The gains of measured torques, of made-up arms whose links, rotors and sides are known: a torque
in Nm has a gain of 1, or the description is wrong.
"""

import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from tests.identification.test_measured_torques import SMOOTH, drawn_run
from tests.made_records import motion_of, signals_of, torques_of
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import Remark
from ur5lib.identification.current_regression import beyond_range
from ur5lib.identification.current_samples import FitSettings, prior_of
from ur5lib.identification.measured_torques import fit_arm
from ur5lib.identification.samples import joint_samples
from ur5lib.identification.selection import shows_gain
from ur5lib.judging.may_be_used import friction_rows
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.carried import Carried
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.friction import Friction, Parameter
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Contradictions, Finding, Quality
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.friction import INERTIA
from ur5lib.robots.statics import gravity_torque
from ur5lib.steps.fit_friction import fit_friction, with_causes
from ur5lib.steps.identify_model import with_fitted
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth

ROTORS = np.array([6.0, 6.0, 3.0, 0.8, 0.8, 0.8])  # kg m²
GEAR = 100.0
NAMES = [f"run {seed}" for seed in range(6)]
PREMISES = Premises(Carried(None, "none", None), Contradictions())


@pytest.fixture(scope="module", autouse=True)
def no_left_out_paths() -> Iterator[None]:
    """Fits without each path take most of the time, and tell no gain."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ur5lib.steps.fit_friction.fit_without_each_path", lambda *_: [])
        yield


@pytest.fixture(scope="module")
def arm() -> Robot:
    """A UR10e whose torques are measured, and whose rotors nobody described."""
    known = load_robot(robot_path("ur10e"))
    rigid = known.models[known.chosen_model].model_copy(update={"rotor_inertias": ()})
    motors = {f"any {name}": own for name, own in known.motors.items()}
    joints = tuple(f"any {name}" for name in known.joints)  # friction is not known to be a UR's
    links = {"models": {"maker": rigid}, "chosen_model": "maker", "effort": "torque"}
    return known.model_copy(update={"joints": joints, "motors": motors} | links)


def fitted(
    arm: Robot,
    gains: Array | float = 1.0,
    rotors: Array | float = 0.0,
    described: Robot | None = None,
) -> Friction:
    """From torques that are those of the true links and of rotors, over gains (6,).

    described: the arm as the fit knows it, if not as it is.
    """
    runs = [drawn_run(arm, seed) for seed in range(len(NAMES))]
    arm = described or arm
    recordings = {}
    for name, run in zip(NAMES, runs, strict=True):
        own, time = run.samples, run.samples.period * np.arange(len(run.qdd))
        pose = own.q.copy(), own.qd.copy(), run.qdd.copy()
        measured = (own.current + rotors * run.qdd) / gains
        rigid = run.regressor(*pose) @ LinkModel(arm, arm.chosen_model).parameters
        recordings[name] = AlignedRecording(
            name=name,
            signals=signals_of(time, pose[0], actual_torque=measured),
            motion=motion_of(time, *pose),
            torques=torques_of(time, {}, {arm.chosen_model: rigid}),
            premises=PREMISES,
            quality=Quality(),
        )
    return fit_friction(
        arm, recordings, {}, dict.fromkeys(NAMES, ""), FitSettings(Butterworth(4, 2.0))
    )


@pytest.fixture(scope="module")
def right(arm: Robot) -> Friction:
    """From torques in Nm of the sides of the joints, without rotors."""
    return fitted(arm)


@pytest.fixture(scope="module")
def turned(arm: Robot) -> Friction:
    """From torques of which those of joint 2 have the opposite sign."""
    return fitted(arm, gains=np.array([1, -1, 1, 1, 1, 1.0]))


def rows(friction: Friction, name: str) -> list[Parameter]:
    return [row for row in friction.parameters if row.name == name]


def stop_sign(friction: Friction) -> Remark:
    assert friction.stopped is not None
    assert not friction.fit.joints  # so that no force is stated
    return friction.stopped


def test_rotors_that_are_not_described_are_fitted(arm: Robot) -> None:
    """What they take is neither the torque's gain nor friction."""
    friction = fitted(arm, rotors=ROTORS)
    for row, rotor in zip(rows(friction, "rotor"), ROTORS, strict=True):
        assert row.interval[0] < rotor < row.interval[1]
        assert abs(row.value - rotor) < 0.2 * rotor
    for row in rows(friction, "torque_constant"):
        assert abs(row.value - 1) < 0.05 or not row.determined
    for row in rows(friction, "coulomb"):
        assert row.interval[0] < 8 < row.interval[1]


def test_rotors_that_sensors_do_not_feel_are_not_fitted(right: Friction) -> None:
    """They would cost accuracy: paths that are left out are predicted no better with them."""
    assert not rows(right, "rotor")
    for row in rows(right, "torque_constant"):
        assert abs(row.value - 1) < 0.05 or not row.determined


def test_a_rotor_without_inertia_is_not_determined(arm: Robot) -> None:
    """As where the links of a description have too much of it."""
    assert not any(row.determined for row in rows(fitted(arm, rotors=-1.0), "rotor"))


def test_rotors_that_are_described_are_not_fitted_again(arm: Robot) -> None:
    model = arm.models["maker"].model_copy(update={"rotor_inertias": (0.0,) * 6})
    friction = fitted(arm.with_model("maker", model))
    assert rows(friction, "torque_constant")
    assert not rows(friction, "rotor")


def test_a_gain_that_is_known_as_well_before_is_not_determined(right: Friction) -> None:
    """As that of joint 6, which bears nothing, while joint 2 bears all."""
    _, second, *_, last = rows(right, "torque_constant")
    assert (second.determined, last.determined) == (True, False)


def test_inertia_tells_no_gain(arm: Robot) -> None:
    """Joint 1 bears no gravity: the inertia of a description is known less well than its masses."""
    first, *_ = rows(fitted(arm, gains=np.array([1.08, 1, 1, 1, 1, 1])), "torque_constant")
    assert (first.value, first.determined) == (pytest.approx(1, abs=1e-3), False)


@pytest.mark.parametrize(
    ("joint", "gain", "shown"), [(1, 1.04, True), (1, 1.0, False), (0, 1.08, False)]
)
def test_parts_left_out_show_a_gain_by_gravity(
    arm: Robot, joint: int, gain: float, shown: bool
) -> None:
    """Also of one path, which tells none within 5 %; joint 1 bears no gravity."""
    run, gains = drawn_run(arm, 0), np.where(np.arange(6) == joint, gain, 1.0)
    own, prior = run.samples, prior_of(arm, [])
    rigid = run.regressor(own.q, own.qd, run.qdd) @ LinkModel(arm, arm.chosen_model).parameters
    inertial = rigid - gravity_torque(arm, arm.chosen_model, own.q)
    record = replace(own, torque=rigid, inertial=inertial, current=own.current / gains)
    samples = joint_samples([record], SMOOTH, (*prior.terms, INERTIA))[joint]
    assert shows_gain(samples, prior, joint) == shown


def test_a_gain_is_contradicted_by_the_errors_of_its_inverse(right: Friction) -> None:
    """Of 5 ± 2.5, torques surely have less of the links'; of 1.2 ± 0.6, nothing is sure."""
    for gain, beyond in ((5.0, True), (1.2, False)):
        first, *others = right.fit.joints
        inverse = np.where(np.arange(len(first.estimate.coefficients)) == 0, 1 / gain, 0.0)
        error = np.full(len(inverse), gain / 2)
        own = replace(first.estimate, coefficients=inverse, std_error=error)
        fit = replace(right.fit, joints=(replace(first, estimate=own), *others), units=30)
        assert beyond_range(fit)[0] == beyond


def test_friction_without_a_sure_sign_is_not_determined(right: Friction) -> None:
    """There is no load-dependent friction in these torques."""
    assert not any(row.determined for row in rows(right, "load") if row.interval[0] < 0)
    assert all(row.determined for row in rows(right, "viscous"))


@pytest.mark.parametrize("gear", [GEAR, 2.0, 0.5])
def test_torques_of_another_side_are_a_stop_sign(arm: Robot, gear: float) -> None:
    sign = stop_sign(fitted(arm, gains=gear))
    assert sign.code == "contradicting gains"
    assert {"2", "3"} <= {*re.findall(r"Nm/Nm on joint (\d)", sign.text)}
    assert all(name in sign.sentence() for name in ("gear_ratio", "rotors", "links"))


def test_an_opposite_sign_is_named_with_its_remedy(arm: Robot, turned: Friction) -> None:
    """Of one joint, which a column may have, the known gain stands in."""
    sign = stop_sign(fitted(arm, gains=np.array([1, -1, -1, 1, 1, 1.0])))
    assert re.findall(r"Nm/Nm on joint (\d)", sign.text) == ["2", "3"]
    assert "units" in sign.sentence()
    (remark,) = turned.fit.joints[1].remarks
    assert "rotor" not in remark.text
    assert "units" in remark.text


def test_the_cause_that_the_checks_found_is_named(arm: Robot, turned: Friction) -> None:
    spring = Finding(
        "robot",
        Found.LINKS_IN_DOUBT,
        "note",
        1,
        "so",
        cause=CauseCode.MISSING_SPRING,
        joints=(2, 3),
    )
    (remark,) = with_causes(turned.fit, {2: spring, 3: spring}, arm).joints[1].remarks
    assert "`balanced_joints: [2]`" in remark.text
    assert "column" not in remark.text
    assert with_causes(turned.fit, {3: spring}, arm) == turned.fit


def test_gains_of_right_torques_are_no_stop_sign(arm: Robot) -> None:
    assert fitted(arm, gains=np.array([1.03, 0.98, 1.02, 1, 0.97, 1])).stopped is None


@pytest.mark.parametrize(
    ("told", "stops"),
    [({}, True), ({"effort": "joint_torque"}, False), ({"weight": 40.0}, False)],
)
def test_links_found_from_torques_need_the_side_of_these(
    arm: Robot, told: dict[str, object], stops: bool
) -> None:
    """Their scale is that of the torques, whichever it is."""
    friction = fitted(arm.model_copy(update={"links": "fitted", "weight": None} | told))
    assert (friction.stopped is not None) == stops
    if stops:
        assert "`effort: " in stop_sign(friction).sentence()


def test_all_torques_times_a_number_leave_the_gains_of_unknown_links_unmoved(arm: Robot) -> None:
    """Links from the same torques are larger by it, so that no gain may be used, however narrow its
    interval; nor is friction known but in the unit of these torques.
    """
    told = arm.model_copy(update={"effort": "joint_torque"})
    fits = {scale: with_links_of_torques(told, scale) for scale in (1.0, 1.1)}
    gains, totals = (
        {scale: np.array([row.value for row in own]) for scale, own in each.items()}
        for each in (
            {scale: rows(own, "torque_constant") for scale, (_, own) in fits.items()},
            {scale: own.totals for scale, (_, own) in fits.items()},
        )
    )
    np.testing.assert_allclose(gains[1.1], gains[1.0], rtol=1e-4)
    np.testing.assert_allclose(totals[1.1], 1.1 * totals[1.0], rtol=1e-2)
    for found, friction in fits.values():
        assert any(row.determined for row in rows(friction, "torque_constant"))
        table = friction_rows(friction, found)
        named = [row for row in table if row.parameter == "gain"]
        assert [(row.use, row.reason) for row in named] == [("no", "unknown_links")] * 6
        assert {row.use for row in table if row.parameter == "total_0.5"} == {"yes"}


def with_links_of_torques(arm: Robot, scale: float) -> tuple[Robot, Friction]:
    """An arm of which the fit knows the axes alone, and its fit, from torques times a number."""
    runs = [drawn_run(arm, seed) for seed in range(len(NAMES))]
    larger = [
        replace(run, samples=replace(run.samples, current=scale * run.samples.current))
        for run in runs
    ]
    found = with_fitted(arm, fit_arm(arm, larger, SMOOTH))
    return found, fitted(arm, gains=1 / scale, described=found)
