"""The maps of the thesis's UR5 and of a UR10e, judged on recordings they were not fitted on."""

from itertools import combinations

import numpy as np
import pytest

from tests.real_arms import Fitted, RealRecording, RealStudy
from ur5lib.dynamics.link_model import load_regressor
from ur5lib.identification.currents import band, friction_current, parameters, predict
from ur5lib.identification.payload import estimate_payload, judge
from ur5lib.identification.samples import CurrentSamples, Smooth, smoothed_moving
from ur5lib.identification.validation import baseline_current, score
from ur5lib.records.friction import CurrentFit
from ur5lib.records.prediction import LoadEstimate, Scores
from ur5lib.robots.description import joint_sizes, load_robot, robot_path
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

UR10E_FITTED = ["ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec"]
UR10E_LEFT_OUT = "ur-20_02_12-40sec_12harm"
UR10E_LOADED = [
    "ur-20_01_31-load",
    "ur-20_02_19_14harm50secLoad",
    "ur-20_02_19_15harm50secLoad",
]
UR10E_SHOWN = [*UR10E_FITTED, "ur-20_01_17-p3", "ur-20_01_17-p4"]
WEIGHED = 2.805  # kg; what the authors of these logs state in estimate_drive_gains.m


def scores(fit: CurrentFit, record: CurrentSamples, smooth: Smooth) -> Scores:
    return score(record, predict(fit, record), smooth, band(fit, record, smooth))


def by_least_squares(fitted: Fitted, record: CurrentSamples, smooth: Smooth) -> Array:
    """RMSE (6,) [A] of plain least squares on the recordings of a fit."""
    plain = baseline_current(record, fitted.friction.least_squares)
    return score(record, plain, smooth, np.zeros_like(plain)).rmse_lowpassed


@pytest.fixture(scope="module")
def ur5_fitted(real_ur5: RealStudy) -> Fitted:
    return real_ur5.fitted(real_ur5.names("fit"))


@pytest.fixture(scope="module")
def ur5_fit(ur5_fitted: Fitted) -> CurrentFit:
    return ur5_fitted.whole


def test_what_misses_on_joint_2_is_the_standstill(real_ur5: RealStudy, ur5_fit: CurrentFit) -> None:
    """Its first three seconds at rest, where friction holds 11 Nm; in motion little is missed."""
    record = real_ur5.recording("Movement_No9_Singularity_Free_NoDist").record
    error = real_ur5.smooth(record.current - predict(ur5_fit, record), record)[:, 1]
    moving = smoothed_moving(record, real_ur5.smooth)[:, 1]
    assert np.sqrt(np.nanmean(error[moving] ** 2)) < 0.08
    assert np.nansum(error[~moving] ** 2) > 0.9 * np.nansum(error**2)


def test_friction_of_the_ur5(ur5_fit: CurrentFit) -> None:
    """Joint 2 carries most, so load shows."""
    rows = {(row.joint, row.name): row for row in parameters(ur5_fit)}
    assert rows[2, "torque_constant"].determined
    assert rows[2, "torque_constant"].value == pytest.approx(10.8, abs=0.2)


def test_motors_of_a_cb_arm_have_the_constants_of_the_e_series(ur5_fit: CurrentFit) -> None:
    """Of that size, on all joints but the first; none has that of the thesis's table."""
    rows = [row for row in parameters(ur5_fit) if row.name == "torque_constant"]
    for row, size, table in zip(
        rows, ["cb3"] * 3 + ["cb1"] * 3, [*load_robot(robot_path("ur5")).joints], strict=True
    ):
        low, high = row.interval
        assert row.joint == 1 or low < _after_gear(size) < high
        assert high < _after_gear(table)


def _after_gear(size: str) -> float:
    """Torque constant [Nm/A] of a size of joints."""
    motor = joint_sizes()[size]
    return motor["torque_constant"] * motor["gear_ratio"]


# A UR3 whose currents hardly show inertia


@pytest.mark.parametrize("names", [("id1", "id2", "circle"), ("circle",)])
def test_neither_constants_nor_friction_of_the_ur3_contradict_its_maker(
    real_ur3: RealStudy, names: tuple[str, ...]
) -> None:
    """Nothing tells the constant of joint 1, which falls back to the known one."""
    fitted = real_ur3.fitted(names)
    fit, known = fitted.whole, fitted.friction.known_constants
    rows = [row for row in parameters(fit) if row.name == "torque_constant"]
    for row, value, width in zip(rows, known.value, known.std_error, strict=True):
        half = NORMAL95 * width
        assert row.interval[0] - half < value < row.interval[1] + half
    robot = fitted.recordings[0].robot
    largest = [robot.motor(joint).torque_max for joint in range(1, 7)]
    for one in fitted.recordings:
        friction = known.value * friction_current(fit, one.record)
        assert (np.abs(friction) < 0.4 * np.array(largest)).all()
    assert fit.joints[0].contradicted is not None
    assert not rows[0].determined


@pytest.mark.parametrize("name", ["id1", "id2", "circle"])
def test_currents_of_the_ur3_show_links_but_no_rotor(real_ur3: RealStudy, name: str) -> None:
    """On joint 1, beside friction: the links' inertia by the maker's constant, and less than none
    of the rotor's, for which the torque of the arm's model is therefore wrong.
    """
    own = real_ur3.recording(name)
    known = own.robot.maker_torque_constants()[0]
    (rotor, *_) = own.robot.models[own.robot.fullest_model()].rotor_inertias
    qd, qdd = own.record.qd[:, 0], own.motion.qdd[:, 0]
    links = own.record.torque[:, 0] - rotor * qdd
    terms = np.column_stack([links, qdd, np.ones_like(qd), np.tanh(qd / 0.05), qd])
    per_torque, per_acceleration, *_ = np.linalg.lstsq(terms, own.record.current[:, 0])[0]
    assert 1 / per_torque == pytest.approx(known, rel=0.3)
    assert rotor > 0.5
    assert -0.4 < per_acceleration / per_torque < 0.0


# The UR10e


@pytest.fixture(scope="module")
def ur10e_fitted(real_ur10e: RealStudy) -> Fitted:
    """Two of the recordings to fit on; at rest others show more of the controller's constants."""
    return real_ur10e.fitted(UR10E_FITTED, UR10E_SHOWN)


def test_the_ur10e_is_predicted_better_than_by_least_squares(
    real_ur10e: RealStudy, ur10e_fitted: Fitted
) -> None:
    record, smooth = real_ur10e.recording(UR10E_LEFT_OUT).record, real_ur10e.smooth
    ours = scores(ur10e_fitted.whole, record, smooth)
    its = by_least_squares(ur10e_fitted, record, smooth)
    assert ours.rmse_lowpassed[:3].mean() <= 0.85 * its[:3].mean()
    assert (ours.rmse_lowpassed[:3] <= its[:3]).all()
    assert (ours.r2[:3] >= 0.99).all()


def test_one_recording_suffices_for_the_currents_of_the_ur10e(
    real_ur10e: RealStudy, ur10e_fitted: Fitted
) -> None:
    """By the manufacturer's torque constants: that recording shows none of the controller's."""
    alone, smooth = real_ur10e.fitted(UR10E_FITTED[:1]), real_ur10e.smooth
    for name in (UR10E_LEFT_OUT, UR10E_FITTED[1]):
        record, other = real_ur10e.recording(name).record, ur10e_fitted.friction.fit_for(name)
        ours, its = (
            np.linalg.norm(scores(fit, record, smooth).rmse_lowpassed)
            for fit in (alone.whole, other)
        )
        assert ours <= 1.4 * its


def load_of(one: RealRecording, fit: CurrentFit, smooth: Smooth) -> LoadEstimate:
    """What a recording's flange carries; the runs to fit on differ by no more than their errors."""
    states = one.motion.q, one.motion.qd, one.motion.qdd
    columns = load_regressor(one.robot, one.robot.fullest_model(), *states)
    return judge(estimate_payload(fit, one.record, columns, smooth), growth=1.0)


@pytest.fixture(scope="module")
def ur10e_loads(real_ur10e: RealStudy, ur10e_fitted: Fitted) -> dict[str, LoadEstimate]:
    return {
        name: load_of(real_ur10e.recording(name), ur10e_fitted.whole, real_ur10e.smooth)
        for name in (UR10E_LEFT_OUT, *UR10E_LOADED)
    }


def test_the_load_of_the_ur10e_is_what_it_weighs(ur10e_loads: dict[str, LoadEstimate]) -> None:
    load = ur10e_loads["ur-20_02_19_14harm50secLoad"]
    assert load.certain
    assert load.interval[0] < WEIGHED < load.interval[1]
    assert load.std_error < 0.1


def test_an_unloaded_ur10e_carries_nothing(ur10e_loads: dict[str, LoadEstimate]) -> None:
    load = ur10e_loads[UR10E_LEFT_OUT]
    assert not load.certain
    assert load.interval[0] < 0 < load.interval[1]
    assert load.std_error < 0.05


def test_runs_of_one_load_agree_on_its_mass(ur10e_loads: dict[str, LoadEstimate]) -> None:
    """Within what two intervals may differ by; the load is the same in all three."""
    loads = [ur10e_loads[name] for name in UR10E_LOADED]
    assert all(load.certain for load in loads)
    for one, other in combinations(loads, 2):
        apart = abs(one.mass - other.mass)
        assert apart < 1.96 * np.hypot(one.std_error, other.std_error)
        assert apart < 0.1 * WEIGHED
