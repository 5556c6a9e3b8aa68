"""The maps of the thesis's UR5 and of a UR10e, judged on recordings they were not fitted on."""

from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.library.current_study import smooth
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.regressor import regressor
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.identification.currents import CurrentFit, band, fit_currents, parameters, predict
from ur5lib.identification.friction import FAMILY, KINDS, JointMotion, Term
from ur5lib.identification.payload import Load, estimate_payload, judge
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, smoothed_moving
from ur5lib.identification.torque_constants import standstill_ratio, torque_constant_prior
from ur5lib.identification.validation import (
    Scores,
    baseline_current,
    least_squares_coefficients,
    score,
)
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.study.model import Recording, TableRecording, ThesisRecording
from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

FITTED = [
    "Movement_No1",
    "Movement_No2",
    "Movement_No3_Acc",
    "Movement_No4_Acc",
    "Movement_No5_Acc_slow_no_disturbance",
    "Movement_No6_Acc_slow_Verify_Model",
    "Movement_No7_Acc_slow_Verify_Model_short",
]
# Coulomb, viscous friction and an offset, fitted on the same recordings: RMSE at 2 Hz [A].
PLAIN = {
    "Movement_No8_Singularity_Free_1": [0.171, 0.169, 0.102, 0.079, 0.050, 0.106],
    "Movement_No9_Singularity_Free_NoDist": [0.198, 0.450, 0.105, 0.083, 0.063, 0.106],
}
UR10E_FITTED = ["ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec"]
UR10E_LEFT_OUT = "ur-20_02_12-40sec_12harm"
UR10E_LOADED = [
    "ur-20_01_31-load",
    "ur-20_02_19_14harm50secLoad",
    "ur-20_02_19_15harm50secLoad",
]
UR10E_COLUMNS = [
    *("time", "actual_q", "actual_qd", "actual_current", "target_current", "target_moment")
]
WEIGHED = 2.805  # kg; what the authors of these logs state in estimate_drive_gains.m
WIDTHS = (0.3, 0.1, 0.1)
GEAR = 101
Joined = tuple[Record, Array, Array]  # the record, its q̈, the controller's own torque constants


def joined(recording: Recording, robot: Robot, model: str) -> Joined:
    table = read_and_repair(recording.model_dump(), robot, max_gap=0.1).robot
    step, segment = period(table), table["segment"].to_numpy()
    lowpass = partial(zero_phase_lowpass, rate=1 / step, order=4, cutoff=10.0)
    q, qd = (
        by_segment(lowpass, channel(table, name), segment) for name in ("actual_q", "actual_qd")
    )
    qdd = by_segment(partial(differentiate, period=step), qd, segment)
    states = [torch.from_numpy(state) for state in (q, qd, qdd)]
    torque = inverse_dynamics(build_arm(robot, model), *states).numpy()
    measured = channel(table, "actual_current")
    record = Record(recording.name, step, segment, q, qd, torque, measured)
    moment, current = channel(table, "target_moment"), channel(table, "target_current")
    return record, qdd, standstill_ratio(moment, current, qd)


def known(robot: Robot, recordings: dict[str, Joined]) -> Prior:
    motors = [robot.motor(joint) for joint in range(1, 7)]
    maker = np.array([GEAR * (motor.torque_constant or np.nan) for motor in motors])
    ratios = np.stack([ratio for *_, ratio in recordings.values()])
    told = [ratio[np.isfinite(ratio)] for ratio in ratios.T]
    controller = np.array([np.median(one) if len(one) else np.nan for one in told])
    inverse = torque_constant_prior(maker, controller, robot.joints, WIDTHS)
    return Prior(inverse, np.array([motor.torque_max for motor in motors]))


def scores(fit: CurrentFit, record: Record) -> Scores:
    return score(record, predict(fit, record), smooth, band(fit, smoothed_moving(record, smooth)))


@pytest.fixture(scope="module")
def of_the_ur5(ur5: Robot, thesis_data: Path) -> dict[str, Joined]:
    def read(name: str) -> Joined:
        recording = ThesisRecording(
            name=name, robot="ur5", format="thesis-csv", folder=str(thesis_data / name), role="fit"
        )
        return joined(recording, ur5, "C+rotors")

    return {name: read(name) for name in (*FITTED, *PLAIN)}


@pytest.fixture(scope="module")
def ur5_prior(ur5: Robot, of_the_ur5: dict[str, Joined]) -> Prior:
    return known(ur5, of_the_ur5)


@pytest.fixture(scope="module")
def ur5_records(of_the_ur5: dict[str, Joined]) -> list[Record]:
    return [of_the_ur5[name][0] for name in FITTED]


@pytest.fixture(scope="module")
def ur5_fit(ur5_records: list[Record], ur5_prior: Prior) -> CurrentFit:
    return fit_currents(ur5_records, smooth, ur5_prior)


@pytest.mark.parametrize("name", PLAIN)
def test_the_ur5_is_predicted_better_than_plainly(
    of_the_ur5: dict[str, Joined], ur5_fit: CurrentFit, name: str
) -> None:
    rmse = scores(ur5_fit, of_the_ur5[name][0]).rmse_lowpassed
    assert (rmse <= PLAIN[name]).all()
    assert rmse.mean() <= 0.75 * np.mean(PLAIN[name])


@pytest.mark.parametrize("name", PLAIN)
def test_and_better_than_least_squares_on_the_same_columns(
    of_the_ur5: dict[str, Joined], ur5_records: list[Record], ur5_fit: CurrentFit, name: str
) -> None:
    record = of_the_ur5[name][0]
    plain = baseline_current(record, least_squares_coefficients(ur5_records))
    its = score(record, plain, smooth, np.zeros_like(plain)).rmse_lowpassed
    assert scores(ur5_fit, record).rmse_lowpassed.mean() <= 0.75 * its.mean()


def test_what_misses_on_joint_2_is_the_standstill(
    of_the_ur5: dict[str, Joined], ur5_fit: CurrentFit
) -> None:
    """Its first three seconds at rest, where friction holds 11 Nm; in motion little is missed."""
    record = of_the_ur5["Movement_No9_Singularity_Free_NoDist"][0]
    error = smooth(record.current - predict(ur5_fit, record), record)[:, 1]
    moving = smoothed_moving(record, smooth)[:, 1]
    assert np.sqrt(np.mean(error[moving] ** 2)) < 0.08
    assert np.sum(error[~moving] ** 2) > 0.9 * np.sum(error**2)


def test_friction_of_the_ur5(ur5_fit: CurrentFit) -> None:
    """Joint 2 carries most, so load shows; joint 3 is fastest, so the shape over velocity does."""
    kinds = [{term.kind for term in joint.terms} for joint in ur5_fit.joints]
    assert "load" in kinds[1]
    assert kinds[2] & {"stribeck", "saturating", "quadratic", "cubic"}
    rows = {(row.joint, row.name): row for row in parameters(ur5_fit)}
    assert rows[2, "torque_constant"].determined
    assert rows[2, "torque_constant"].value == pytest.approx(10.8, abs=0.2)


def test_nonsense_changes_nothing_on_the_ur5(
    ur5_records: list[Record],
    ur5_prior: Prior,
    ur5_fit: CurrentFit,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def nonsense(motion: JointMotion, frequency: float) -> list[Array]:
        return [np.sin(frequency * motion.q + motion.torque)]

    monkeypatch.setitem(KINDS, "nonsense", nonsense)
    family = (*FAMILY, *(Term("nonsense", frequency) for frequency in (3, 5, 17)))
    fit = fit_currents(ur5_records, smooth, ur5_prior, family)
    assert [joint.terms for joint in fit.joints] == [joint.terms for joint in ur5_fit.joints]


# The UR10e


@pytest.fixture(scope="module")
def ur10e() -> Robot:
    return load_robot(robot_path("ur10e"))


@pytest.fixture(scope="module")
def of_the_ur10e(ur10e: Robot, ur10e_data: Path) -> dict[str, Joined]:
    def read(name: str) -> Joined:
        recording = TableRecording(
            name=name,
            robot="ur10e",
            format="table-csv",
            folder=str(ur10e_data),
            file=f"{name}.csv",
            columns=UR10E_COLUMNS,
            role="fit",
        )
        return joined(recording, ur10e, "maker+rotors")

    names = (*UR10E_FITTED, UR10E_LEFT_OUT, *UR10E_LOADED, "ur-20_01_17-p3", "ur-20_01_17-p4")
    return {name: read(name) for name in names}


@pytest.fixture(scope="module")
def ur10e_fit(ur10e: Robot, of_the_ur10e: dict[str, Joined]) -> CurrentFit:
    records = [of_the_ur10e[name][0] for name in UR10E_FITTED]
    return fit_currents(records, smooth, known(ur10e, of_the_ur10e))


def test_the_ur10e_is_predicted_better_than_by_least_squares(
    of_the_ur10e: dict[str, Joined], ur10e_fit: CurrentFit
) -> None:
    record = of_the_ur10e[UR10E_LEFT_OUT][0]
    ours = scores(ur10e_fit, record)
    plain = least_squares_coefficients([of_the_ur10e[name][0] for name in UR10E_FITTED])
    current = baseline_current(record, plain)
    its = score(record, current, smooth, np.zeros_like(current)).rmse_lowpassed
    assert ours.rmse_lowpassed[:3].mean() <= 0.85 * its[:3].mean()
    assert (ours.rmse_lowpassed[:3] <= its[:3]).all()
    assert (ours.r2[:3] >= 0.99).all()


def load_of(ur10e: Robot, fit: CurrentFit, joined: Joined) -> Load:
    """What a recording's flange carries; the runs to fit on differ by next to nothing."""
    record, qdd, _ = joined
    states = [torch.from_numpy(state) for state in (record.q, record.qd, qdd)]
    arm = build_arm(ur10e, "maker+rotors")
    columns = regressor(arm, *states).numpy()[:, :, 50:54]  # link 6: mass and first moments
    return judge(estimate_payload(fit, record, columns, smooth), spread=0.0)


@pytest.fixture(scope="module")
def ur10e_loads(
    ur10e: Robot, of_the_ur10e: dict[str, Joined], ur10e_fit: CurrentFit
) -> dict[str, Load]:
    names = (UR10E_LEFT_OUT, *UR10E_LOADED)
    return {name: load_of(ur10e, ur10e_fit, of_the_ur10e[name]) for name in names}


def test_the_load_of_the_ur10e_is_what_it_weighs(ur10e_loads: dict[str, Load]) -> None:
    load = ur10e_loads["ur-20_02_19_14harm50secLoad"]
    assert load.certain
    assert load.interval[0] < WEIGHED < load.interval[1]
    assert load.std_error < 0.1


def test_an_unloaded_ur10e_carries_nothing(ur10e_loads: dict[str, Load]) -> None:
    load = ur10e_loads[UR10E_LEFT_OUT]
    assert not load.certain
    assert load.interval[0] < 0 < load.interval[1]
    assert load.std_error < 0.05


def test_runs_of_one_load_agree_on_its_mass(ur10e_loads: dict[str, Load]) -> None:
    """Within what two intervals may differ by; the load is the same in all three."""
    loads = [ur10e_loads[name] for name in UR10E_LOADED]
    assert all(load.certain for load in loads)
    for one, other in combinations(loads, 2):
        apart = abs(one.mass - other.mass)
        assert apart < 1.96 * np.hypot(one.std_error, other.std_error)
        assert apart < 0.1 * WEIGHED
