"""A force sensor that is zeroed during a recording, and contacts that must not be taken for it."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from tests.entries import read_and_check
from ur5lib.commands.check import look_through
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.sensors import FORCE_CHANNELS
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, gravity_torque, link_frames
from ur5lib.study.reading import parse_study
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

TIME = np.arange(1000) / 125.0
WHEN = 3.154  # s, of the zeroing: between two samples
AFTER = TIME > WHEN
AWAY = np.array([2.0, -1.0, 2.0]) / 3.0
MASS = 0.5  # kg, behind the sensor
FORCE = [f"ft_{one}" for one in ("fx", "fy", "fz")]


def recording(arm: Robot, contact: Array, seed: int = 0) -> tuple[pd.DataFrame, Array]:
    """A swinging arm that bears a contact (N,) [N], and its sensor's reading (N, 6)."""
    random = np.random.default_rng(seed)
    phase = 0.8 * TIME[:, None] + np.arange(6)
    q = 0.6 * np.sin(phase) + [0.0, -1.2, 1.4, -1.0, 1.2, 0.0]
    rotation = link_frames(arm, q)[0][:, -1]
    force = contact[:, None] * AWAY
    base = np.concatenate([np.einsum("nij,nj->ni", rotation, force), np.zeros_like(force)], axis=1)
    load = np.einsum("nji,nj->ni", geometric_jacobian(arm, q), base)
    torque = gravity_torque(arm, arm.chosen_model, q) - load
    current = torque / arm.family_torque_constants() + random.normal(0, 0.05, q.shape)
    robot = {"actual_q": q, "actual_qd": 0.48 * np.cos(phase), "actual_current": current}
    weight = MASS * np.einsum("nji,j->ni", rotation, np.array(arm.gravity))
    wrench = np.concatenate([force + weight, 0.05 * weight], axis=1)
    table = {name: each for of in robot for name, each in named(robot[of], of).items()}
    noisy = wrench + random.normal(0, [0.1] * 3 + [0.01] * 3, wrench.shape)
    return pd.DataFrame({"timestamp": TIME, **table}), noisy


def entry_of(folder: Path, robot: pd.DataFrame, wrench: Array, own: bool) -> dict[str, Any]:
    """Write the robot's file, and the sensor's in it or beside it."""
    entry: dict[str, Any] = {"folder": str(folder), "format": "rtde-csv", "file": "robot.csv"}
    sensor = pd.DataFrame(wrench, columns=FORCE_CHANNELS)
    if own:
        sensor.insert(0, "time", TIME)
        sensor.to_csv(folder / "force.csv", index=False, header=False)
        entry["force_sensor"] = {"file": "force.csv", "columns": ["time", "ft"]}
    else:
        robot = robot.join(sensor)
    robot.to_csv(folder / "robot.csv", index=False)
    return entry


def zeroed(reading: Array, size: float) -> Array:
    """A reading that is off by a size [N] and zeroed at WHEN."""
    first = int(AFTER.argmax())
    off = np.concatenate([size * AWAY, 0.1 * size * AWAY])
    return reading - reading[first] + np.where(AFTER[:, None], 0.0, off)


def zeroings(intake: Intake) -> list[tuple[float, float]]:
    """What is said of each zeroing: its time [s] and size [N]."""
    sentences = [said(one) for one in intake.quality.findings if one.code == "zeroed"]
    each = re.findall(r"at (\S+) s by (\S+) N", "".join(sentences))
    return [(float(time), float(force)) for time, force in each]


def read(folder: Path, arm: Robot, robot: pd.DataFrame, wrench: Array, own: bool = False) -> Intake:
    return read_and_check(entry_of(folder, robot, wrench, own), arm, 0.1)


def force_of(intake: Intake) -> Array:
    return intake.sensors.get("force", intake.robot)[FORCE].to_numpy()


def check(intake: Intake, wrench: Array) -> None:
    """The reading differs by a constant from what a sensor measures that nobody zeroed."""
    off = force_of(intake) - wrench[:, :3]
    assert np.abs(off - np.median(off, axis=0)).max() < 0.6


@pytest.mark.parametrize("size", [5.0, 10.0, 27.0, 50.0])
@pytest.mark.parametrize("own", [False, True])
def test_what_was_recorded_before_is_put_on_the_new_zero(
    tmp_path: Path, ur5: Robot, size: float, own: bool
) -> None:
    robot, wrench = recording(ur5, np.zeros_like(TIME))
    intake = read(tmp_path, ur5, robot, zeroed(wrench, size), own)
    ((time, force),) = zeroings(intake)
    assert time == pytest.approx(WHEN, abs=0.01)
    assert force == pytest.approx(size, abs=0.3)
    check(intake, wrench)


@pytest.mark.parametrize("size", [10.0, 27.0])
def test_what_follows_is_no_contact(tmp_path: Path, ur5: Robot, size: float) -> None:
    """As `ur5 check` sees it: of the sensor alone, it is contact in a recording to fit on."""
    robot, wrench = recording(ur5, np.zeros_like(TIME))
    entry = entry_of(tmp_path, robot, zeroed(wrench, 2 * size), own=False)
    entry |= {"name": "r", "robot": "ur5", "role": "fit"}
    study = parse_study({"study": "s", "title": "t", "recordings": [entry]}, "study.yaml")
    quality, _ = look_through(study.recordings[0], study)
    found = {one.code for one in quality.findings}
    assert "zeroed" in found
    assert "contact" not in found


def test_a_sensor_that_is_zeroed_twice_has_one_zero(tmp_path: Path, ur5: Robot) -> None:
    """At the second time, by what its tool's weight has turned since."""
    robot, wrench = recording(ur5, np.zeros_like(TIME))
    reading, again = zeroed(wrench, 27.0), 620
    reading[again:] -= reading[again]
    intake = read(tmp_path, ur5, robot, reading)
    assert [time for time, _ in zeroings(intake)] == pytest.approx([WHEN, TIME[again]], abs=0.01)
    check(intake, wrench)


def bump(length: float) -> Array:
    """A contact that begins at 2 s and ends at WHEN, within a time [s]."""
    return np.where(TIME > 2.0, 27.0 * np.clip((WHEN - TIME) / length, 0.0, 1.0), 0.0)


CONTACTS = {
    "ends at once": bump(1e-9),
    "ends in 0.1 s": bump(0.1),
    "begins at once": 27.0 * AFTER,
    "pushes of a hand": 27.0 * np.sin(np.pi * TIME / 2.0) ** 2,
}


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("share", [0.4, 1.0, 2.0])
@pytest.mark.parametrize("own", [False, True])
def test_a_contact_is_left_as_it_is(
    tmp_path: Path, ur5: Robot, contact: str, share: float, own: bool
) -> None:
    """On a sensor that was zeroed where nothing touched the arm, as late as at its end."""
    robot, wrench = recording(ur5, np.multiply(share, CONTACTS[contact]))
    wrench -= wrench[0 if contact == "begins at once" else int(AFTER.argmax())]
    intake = read(tmp_path, ur5, robot, wrench, own)
    assert not zeroings(intake)
    np.testing.assert_allclose(force_of(intake), wrench[:, :3], atol=1e-6)


def test_a_contact_that_friction_holds_ends_at_the_bias(tmp_path: Path, ur5: Robot) -> None:
    """Of a sensor that was never zeroed, this is not zero, whatever the currents show."""
    robot, wrench = recording(ur5, np.zeros_like(TIME))
    wrench[:, :3] += 6.0 * AWAY + np.outer(CONTACTS["ends at once"], AWAY)
    assert not zeroings(read(tmp_path, ur5, robot, wrench))


def test_a_sensor_that_is_gone_was_not_zeroed(tmp_path: Path, ur5: Robot) -> None:
    robot, wrench = recording(ur5, np.zeros_like(TIME))
    gone = np.where(AFTER[:, None], 0.0, wrench + 20.0)
    assert not zeroings(read(tmp_path, ur5, robot, gone))
