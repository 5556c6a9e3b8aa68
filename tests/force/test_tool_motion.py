"""Weight and inertia of a tool behind a force sensor, by the dynamics and on the stand."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.smoothing.test_smoothing import kinematics, random_states
from tests.stand.test_stand_devices import FOURIER, PUSH, Recorded
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.force.sensor_reading import OwnClock, moved_tool, sensor_reading
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.end_effector import ToolMotion, expected_values, point_acceleration, tool_motion
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.resampling import resample
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import measured, motion_record
from ur5lib.steps.judge_sensor import sensor_wrenches
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated

TOOL: dict[str, Any] = {
    "mass": 1.0,
    "center_of_mass": [0.01, -0.02, 0.06],
    "inertia": [1e-3, 1.2e-3, 5e-4, 1e-4, -5e-5, 7e-5],
}
LATE = 0.03  # s, of the sensor's clock


def test_each_point_of_the_tool_is_pulled_by_its_own_acceleration(ur5: Robot) -> None:
    q, qd, qdd = random_states()
    R, J = kinematics(ur5, q)
    gravity, point = np.array(ur5.gravity), np.array([0.1, -0.2, 0.3])
    moved = point_acceleration(R, J, qd, qdd, point)
    expected_pull = np.einsum("nji,nj->ni", R, gravity - moved[:, :3])
    found = tool_motion(R, J, qd, qdd, gravity)
    np.testing.assert_allclose(found.pull_at(point), expected_pull, atol=1e-10)


def test_weight_and_inertia_of_a_tool_are_what_it_takes_of_the_joint_torques(ur5: Robot) -> None:
    """τ of the bare arm minus τ with the tool is Jᵀ of the tool's wrench at the flange."""
    q, qd, qdd = random_states()
    R, J = kinematics(ur5, q)
    tool, moved = Payload(**TOOL), tool_motion(R, J, qd, qdd, np.array(ur5.gravity))
    center = np.array(tool.center_of_mass)
    force = tool.mass * moved.pull_at(center)
    moment = np.cross(center, force) - moved.gyration(tool.inertia)
    wrench = np.concatenate([np.matvec(R, force), np.matvec(R, moment)], axis=1)
    bare, loaded = (LinkModel(arm, "C") for arm in (ur5, ur5.carrying(tool)))
    taken = bare.inverse_dynamics(q, qd, qdd) - loaded.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(np.matvec(J.mT, wrench), taken, atol=1e-9)


def test_what_the_clock_cannot_place_has_a_mean_of_zero() -> None:
    """A sine of ω is damped by the mean of cos ω ε over the clock's errors ε, exp(-(ω σ)² / 2)."""
    time = 0.008 * np.arange(1000)
    segment = np.repeat([0, 1], 500)
    for frequency in (0.5, 5.0, 22.0):
        sine = np.sin(2 * np.pi * frequency * time)[:, None] + 2.0
        found = expected_values(sine, segment, 0.008, 0.028)
        gain = np.exp(-((2 * np.pi * frequency * 0.028) ** 2) / 2)
        inner = slice(60, 440)
        np.testing.assert_allclose(found[inner], gain * (sine[inner] - 2) + 2, atol=2e-3)
    steps = np.where(segment == 0, -1.0, 3.0)[:, None]  # nothing flows across a split
    np.testing.assert_allclose(expected_values(steps, segment, 0.008, 0.028), steps)
    np.testing.assert_array_equal(expected_values(steps, segment, 0.008, 0.0), steps)


def errors(recorded: Recorded, clock_std: float) -> tuple[float, float]:
    """Root mean square error [N] of the compensated force, with the tool's weight alone and with
    its inertia, on the clock of the sensor's start stamp."""
    intake, arm = recorded.repaired, recorded.arm
    clock = clock_from_stamps(intake.quality.starts["force"].seconds, clock_std)
    time = intake.robot["time"].to_numpy()
    reading = resample(intake.sensors["force"], clock, time)
    signals = Signals.from_table(pd.concat([intake.robot, reading], axis=1))
    assert signals.force_sensor is not None
    own = OwnClock(signals.force_sensor, clock_std, signals.period)
    frames = Kinematics.of(time, *flange_kinematics(arm, signals.actual_q))
    joints = smooth_encoders(signals.time, signals.segment, *measured(signals))
    moved = moved_tool(arm, frames, motion_record(signals, joints))
    true = interpolated(
        time, recorded.true()["time"].to_numpy(), channel(recorded.true(), "wrench")
    )

    def error(moved: ToolMotion) -> float:
        found = sensor_reading(arm, signals, moved, 1.0, own=own)
        wrench = sensor_wrenches(arm, signals, found, frames.rotation).wrench["compensated"]
        return float(np.sqrt(np.nanmean((wrench - true)[:, :3] ** 2)))

    return error(at_rest(moved, np.array(arm.gravity) @ frames.rotation)), error(moved)


def at_rest(moved: ToolMotion, weight: Array) -> ToolMotion:
    return replace(moved, pull=weight, rate=0 * moved.rate, spin=0 * moved.spin)


@pytest.mark.parametrize(("late", "most"), [(0.0, 0.1), (LATE, 0.8)])
def test_inertia_is_no_contact(tmp_path: Path, late: float, most: float) -> None:
    """1 kg in fast motion: its weight alone leaves more than a newton; a late clock leaves some."""
    clock = {"offset_s": 0.05, "drift_ppm": 0, "jitter_s": 1e-4, "stamp_error_s": late}
    plan = {"payload": TOOL, "contacts": [PUSH], "seconds": 10, "trajectory": FOURIER}
    recorded = Recorded("ur5", "thesis-csv", tmp_path, plan | {"force_sensor": {"clock": clock}})
    weight, inertia = errors(recorded, max(late, 0.006))
    assert weight > 0.8
    assert inertia < most
