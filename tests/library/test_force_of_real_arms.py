"""The estimates on the thesis's recordings with a force sensor, and on pushes of a UR10e.

Nothing is fitted on what is judged. The sensor's clock is taken by its stamps alone.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.library.force_study import Fitted, Taken, fitted, take
from ur5lib.force.detection import alarm_threshold, alarms, compare
from ur5lib.force.sensed_contacts import contacts
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.metrics import correlation, coverage, mean_absolute_error, skill
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.study import TableRecording, ThesisRecording

FITTED = [
    "Movement_No1",
    "Movement_No2",
    "Movement_No3_Acc",
    "Movement_No4_Acc",
    "Movement_No5_Acc_slow_no_disturbance",
    "Movement_No6_Acc_slow_Verify_Model",
    "Movement_No7_Acc_slow_Verify_Model_short",
]
REPEATED = ["Movement_No8_Singularity_Free_1", "Movement_No9_Singularity_Free_NoDist"]
PUSHED = "Movement_No9_Singularity_Free_ForceSensor"
STANDSTILL = ["Movement_No10_Standstill_ForceSensor_All", "Movement_No10_Standstill_ForceSensor_Fx"]
UR10E_FITTED = ["ur-20_01_17-p2", "ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec"]
UR10E_PUSHED = "ur-20_01_22-push_pose_1"
UR10E_COLUMNS = [
    *("time", "actual_q", "actual_qd", "actual_current", "target_current", "target_moment")
]
CONTACT = 15.0  # N


@pytest.fixture(scope="module")
def thesis(ur5: Robot, thesis_data: Path) -> dict[str, Taken]:
    def read(name: str) -> Taken:
        recording = ThesisRecording(
            name=name, robot="ur5", format="thesis-csv", folder=str(thesis_data / name), role="fit"
        )
        return take(recording, ur5, "C+rotors")

    return {name: read(name) for name in (*FITTED, *REPEATED, PUSHED, *STANDSTILL)}


@pytest.fixture(scope="module")
def known(thesis: dict[str, Taken], ur5: Robot) -> Fitted:
    return fitted([thesis[name] for name in FITTED], ur5)


@pytest.fixture(scope="module")
def estimates(thesis: dict[str, Taken], known: Fitted) -> dict[str, WrenchEstimate]:
    return {name: known.estimate(taken) for name, taken in thesis.items()}


@pytest.fixture(scope="module")
def repeated(thesis: dict[str, Taken], known: Fitted) -> WrenchEstimate:
    contact_free = [thesis[name] for name in (*FITTED, *REPEATED)]
    return known.repeated(thesis[PUSHED], contact_free)


@pytest.fixture(scope="module")
def sensor(thesis: dict[str, Taken], ur5: Robot) -> dict[str, np.ndarray]:
    return {name: thesis[name].sensor(ur5)[0] for name in (PUSHED, *STANDSTILL)}


# The sign: the sensor reads the environment acting on the arm (DESIGN.md's convention)


def test_the_sensor_feels_its_tool_pull_downwards(thesis: dict[str, Taken], ur5: Robot) -> None:
    """As R_6 turns, the free reading follows the weight of a tool of about 0.1 kg, not its lift."""
    offset = thesis[PUSHED].sensor(ur5)[1]
    assert 0.05 < offset.mass < 0.15
    assert offset.mass > 10 * offset.mass_std
    assert 0.4 < offset.free.mean() < 0.8


def test_motors_work_against_what_the_sensor_reads(
    thesis: dict[str, Taken], known: Fitted, sensor: dict[str, np.ndarray]
) -> None:
    """k (i_modelled - i) = J^T F with F as read, not its opposite; F^u is the opposite."""
    taken = thesis[PUSHED]
    seen = (taken.jacobian.mT @ sensor[PUSHED][..., None])[..., 0]
    assert (correlation(known.torque(taken), seen)[:5] > 0.5).all()
    assert (correlation(known.torque(taken), seen)[:4] > 0.8).all()
    assert taken.controller is not None
    assert (correlation(taken.controller, sensor[PUSHED])[:3] < -0.3).all()


def test_saying_nothing_scores_as_the_bias_free_sensor_has_it(
    sensor: dict[str, np.ndarray],
) -> None:
    """2.90, 2.39, 3.51 N by the first second's bias; less once the tool's weight is off, too."""
    zero = np.nanmean(np.abs(sensor[PUSHED]), axis=0)
    np.testing.assert_allclose(zero[:3], [2.90, 2.39, 3.51], rtol=0.2)
    assert (zero[3:] < 0.1).all()


# The estimates


def test_the_repeat_aware_estimate(repeated: WrenchEstimate, sensor: dict[str, np.ndarray]) -> None:
    """Printed F̂* has 6.16, 8.66, 5.64 N."""
    error = mean_absolute_error(repeated.wrench, sensor[PUSHED])
    assert (error[:3] <= [1.9, 2.2, 2.7]).all()
    assert (correlation(repeated.wrench, sensor[PUSHED])[:3] >= [0.90, 0.60, 0.92]).all()
    assert (skill(repeated.wrench, sensor[PUSHED])[:3] > 0.4).all()


def test_without_template(
    estimates: dict[str, WrenchEstimate], sensor: dict[str, np.ndarray]
) -> None:
    error = mean_absolute_error(estimates[PUSHED].wrench, sensor[PUSHED])
    assert (error[:3] <= [2.2, 2.5, 2.8]).all()


@pytest.mark.parametrize("name", STANDSTILL)
def test_at_standstill_better_than_the_controller(
    thesis: dict[str, Taken],
    estimates: dict[str, WrenchEstimate],
    sensor: dict[str, np.ndarray],
    name: str,
) -> None:
    """F^u less its mean of the first second, which is free of contact."""
    taken = thesis[name]
    assert taken.controller is not None
    unbiased = -(taken.controller - taken.controller[: round(1 / taken.record.period)].mean(axis=0))
    controller = mean_absolute_error(unbiased, sensor[name])
    error = mean_absolute_error(estimates[name].wrench, sensor[name])
    assert (error[:3] < controller[:3]).all()
    assert (error[:3] < np.nanmean(np.abs(sensor[name][:, :3]), axis=0)).all()


@pytest.mark.parametrize("name", [PUSHED, *STANDSTILL])
def test_the_band_covers_what_it_states(
    estimates: dict[str, WrenchEstimate], sensor: dict[str, np.ndarray], name: str
) -> None:
    estimate = estimates[name]
    inside = coverage(estimate.wrench, estimate.std, sensor[name])
    assert 0.90 <= inside[:3].mean() <= 0.99


def test_the_repeat_aware_band_covers_what_it_states(
    repeated: WrenchEstimate, sensor: dict[str, np.ndarray]
) -> None:
    inside = coverage(repeated.wrench, repeated.std, sensor[PUSHED])
    assert 0.90 <= inside[:3].mean() <= 0.99


# Detection


def test_every_contact_is_found_in_time_and_none_is_made_up(
    thesis: dict[str, Taken],
    known: Fitted,
    estimates: dict[str, WrenchEstimate],
    repeated: WrenchEstimate,
    sensor: dict[str, np.ndarray],
) -> None:
    step = thesis[PUSHED].record.period
    threshold = alarm_threshold([estimates[name].log_odds for name in FITTED], step, 1.0)
    force = np.linalg.norm(sensor[PUSHED][:, :3], axis=1)
    detection = compare(alarms(repeated.log_odds, threshold), contacts(force, CONTACT), step)
    assert detection.contacts == 10
    assert detection.recall() >= 0.9
    assert detection.false == 0
    assert np.median(detection.delays) <= 0.25
    contact_free = [thesis[name] for name in (*FITTED, *REPEATED)]
    for name in REPEATED:
        assert alarms(estimates[name].log_odds, threshold) == []
        others = [taken for taken in contact_free if taken is not thesis[name]]
        assert alarms(known.repeated(thesis[name], others).log_odds, threshold) == []


# Another arm, without a force sensor


def test_pushes_of_a_ur10e(ur10e_data: Path) -> None:
    robot = load_robot(robot_path("ur10e"))

    def read(name: str) -> Taken:
        recording = TableRecording(
            name=name,
            robot="ur10e",
            format="table-csv",
            folder=str(ur10e_data),
            file=f"{name}.csv",
            columns=UR10E_COLUMNS,
            role="fit",
        )
        return take(recording, robot, "maker+rotors")

    known = fitted([read(name) for name in UR10E_FITTED], robot)
    pushed = read(UR10E_PUSHED)
    estimate = known.estimate(pushed)
    contacts = alarms(estimate.log_odds, 0.0)
    assert 3 <= len(contacts) <= 6
    assert 0.1 < sum(last - first for first, last in contacts) / len(estimate.log_odds) < 0.5
    assert np.isfinite(estimate.wrench).all()
    assert np.isfinite(estimate.std).all()
    assert np.abs(estimate.wrench[:, :3]).max() < 150
    assert pushed.reading is None
