"""Recordings and records of arms with other than six joints."""

from pathlib import Path
from textwrap import dedent

import h5py
import numpy as np
import pandas as pd
import pytest
import yaml

from tests.conftest import PROJECT
from tests.house.test_seven_joints import arm
from tests.robots.test_from_urdf import made_up, saved
from ur5lib.checks.channels import check_robot
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.commands.described import describe_urdf
from ur5lib.errors import InputError
from ur5lib.identification.current_samples import prior_of
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.report.figures.charts import residual_panels, scatter_panels
from ur5lib.report.figures.traces import (
    TORQUE_PANELS,
    StyledLines,
    Traces,
    draw_traces,
)
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics, gravity_torque
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import measured, motion_record
from ur5lib.study.reading import parse_study
from ur5lib.tables import channel, named, write_table

PERIOD = 0.008


def sensing(count: int) -> Robot:
    """An arm with the first joints of another, whose torque is measured."""
    described = arm().model_dump()
    for own in (described, *described["models"].values()):
        for name, values in own.items():
            if isinstance(values, tuple | list) and len(values) == 7:
                own[name] = values[:count]
    return Robot.model_validate(described | {"effort": "torque"})


def recorded(count: int, folder: Path) -> Intake:
    """Four seconds of sines, with the torque of gravity and a little noise."""
    time, random = np.arange(0, 4, PERIOD), np.random.default_rng(count)
    rate = np.arange(1, count + 1)
    q, qd = np.sin(time[:, None] * rate) / 2, rate * np.cos(time[:, None] * rate) / 2
    robot = sensing(count)
    torque = gravity_torque(robot, "made up", q) + random.normal(0, 0.1, q.shape)
    table = {"timestamp": 100 + time}
    for name, values in {"actual_q": q, "actual_qd": qd, "actual_torque": torque}.items():
        table |= {f"{name}_{j}": values[:, j] for j in range(count)}
    pd.DataFrame(table).to_csv(folder / "run.csv", index=False)
    entry = {"name": "run", "format": "rtde-csv", "folder": str(folder), "file": "run.csv"}
    return read_and_repair(ENTRY.validate_python(entry | {"role": "fit"}), robot, 0.1)


@pytest.mark.parametrize("count", [2, 7])
def test_a_recording_has_the_joints_of_its_arm(count: int, tmp_path: Path) -> None:
    """Measured torque takes the place of currents; nothing contradicts the arm."""
    found, robot = recorded(count, tmp_path), sensing(count)
    for name in ("actual_q", "actual_qd", "actual_torque"):
        assert channel(found.robot, name).shape[1] == count
    assert not check_robot(found.robot, PERIOD, [(-10.0, 10.0)] * count, [10.0] * count)
    assert not stop_signs(Checked(found.robot, robot, None, None, True, cutoff=2.0))


@pytest.mark.parametrize("count", [2, 7])
def test_records_have_the_joints_of_their_tables(count: int, tmp_path: Path) -> None:
    table, robot = recorded(count, tmp_path).robot, sensing(count)
    write_table(table, tmp_path / "signals.parquet")
    signals = Signals.read(tmp_path / "signals.parquet")
    motion = motion_record(
        signals, smooth_encoders(signals.time, signals.segment, *measured(signals))
    )
    motion.write(tmp_path / "motion.parquet")
    again = Motion.read(tmp_path / "motion.parquet")
    assert again.qdd_std.shape == signals.actual_q.shape == (len(table), count)
    np.testing.assert_array_equal(again.qd, motion.qd)
    kinematics = Kinematics.of(again.time, *flange_kinematics(robot, again.q))
    kinematics.write(tmp_path / "kinematics.parquet")
    read = Kinematics.read(tmp_path / "kinematics.parquet")
    np.testing.assert_array_equal(read.jacobian, kinematics.jacobian)


def test_a_sensor_is_known_to_measure_torque() -> None:
    """Its constant is 1 Nm/Nm before the fit, and no friction of other arms is expected."""
    prior = prior_of(sensing(7), [])
    np.testing.assert_allclose(prior.inverse_constant.mean, 1.0)
    assert not prior.typical


@pytest.mark.parametrize("joint", range(6))
def test_a_recording_tells_no_ratio_of_a_joint_that_it_does_not_know(
    joint: int, ur5: Robot
) -> None:
    """Beside another that knows it; its ratios of the other joints count."""
    ratio = np.linspace(8.0, 13.0, 6)
    partly = ratio.copy()
    partly[joint] = np.nan
    whole, found = (prior_of(ur5, some).inverse_constant for some in ([ratio], [ratio, partly]))
    np.testing.assert_array_equal(found.mean, whole.mean)
    np.testing.assert_array_equal(found.precision, whole.precision)


@pytest.mark.parametrize("count", [2, 8])
def test_figures_have_a_panel_for_each_joint(count: int) -> None:
    time, values = np.arange(20.0), np.random.default_rng(0).normal(size=(20, count))
    series: StyledLines = {"measured": (values, "joint")}
    assert draw_traces(Traces(time, series, series), TORQUE_PANELS).data.shape[1] == 1 + 2 * count
    assert draw_traces(Traces(time, series), TORQUE_PANELS).data.shape[1] == 1 + count
    assert scatter_panels(values, values, ("{}", "of {}")).data.shape[1] == 2 * count
    assert residual_panels(values, {"x": values}, "Nm").data.shape[1] == 2 * count


def test_bring_your_own_arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's study, of an arm from a URDF, reads a CSV and an HDF5 file of seven joints."""
    page = (PROJECT / "docs" / "robots.md").read_text().split("## Bring your own arm")[1]
    study = page.split("\n\n    study: ")[1].split("\n\nA CSV")[0]
    monkeypatch.chdir(tmp_path)
    describe_urdf(saved(made_up(7), tmp_path), None, "tool", "my-arm")
    (tmp_path / "raw" / "mine").mkdir(parents=True)
    time, rate = np.arange(0, 4, PERIOD), np.arange(1, 8)
    q, qd = np.sin(time[:, None] * rate) / 2, rate * np.cos(time[:, None] * rate) / 2
    table = {"timestamp": time} | named(q, "actual_q") | named(qd, "actual_qd")
    table |= named(q, "actual_torque")
    pd.DataFrame(table).to_csv(tmp_path / "raw" / "mine" / "free.csv", index=False)
    with h5py.File(tmp_path / "raw" / "mine" / "pushed.h5", "w") as file:
        file["t"], file["state/q"], file["state/dq"], file["state/tau_J"] = time, q, qd, q
    known = parse_study(yaml.safe_load(dedent("    study: " + study)), "the page")
    for recording in known.recordings:
        intake = read_and_repair(recording, recording.arm.description(), 0.1)
        np.testing.assert_allclose(channel(intake.robot, "actual_torque"), q, atol=1e-9)


def test_an_arm_with_other_joints_is_refused(tmp_path: Path) -> None:
    recorded(7, tmp_path)
    entry = {"name": "run", "format": "rtde-csv", "folder": str(tmp_path), "file": "run.csv"}
    entry = ENTRY.validate_python(entry | {"role": "fit"})
    for count in (2, 6):
        with pytest.raises(InputError, match=f"{count} joints"):
            read_and_repair(entry, sensing(count), 0.1)
