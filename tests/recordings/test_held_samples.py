"""A sensor that is slower than the rows in which it is written: only its own samples count."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from tests.entries import read_and_check
from ur5lib.force.sensor import fit_offset
from ur5lib.recordings.held_samples import fresh_samples
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.sensors import FORCE_CHANNELS
from ur5lib.records.codes import Found
from ur5lib.robots.description import Robot
from ur5lib.tables import named

ROWS, SLOW = 125.0, 6.0  # Hz, of the robot's file and of the sensor in it
TIME = np.arange(2500) / ROWS


def sent(rate: float, jitter: float = 0.0) -> np.ndarray:
    """When a sensor sent its samples, at most `jitter` of a period early or late."""
    random, count = np.random.default_rng(1), int(TIME[-1] * rate) + 1
    return (np.arange(count) + jitter * random.uniform(-1, 1, count)) / rate


def held(samples: np.ndarray, when: np.ndarray) -> np.ndarray:
    """The last sample (N, M) at each row."""
    return samples[np.searchsorted(when, TIME + 1e-9).clip(1) - 1]


@pytest.mark.parametrize(("rate", "jitter"), [(SLOW, 0.0), (SLOW, 0.25), (10.0, 0.1), (60.0, 0.0)])
def test_each_sample_of_a_slow_sensor_counts_once(rate: float, jitter: float) -> None:
    when = sent(rate, jitter)
    samples = np.random.default_rng(2).normal(size=(len(when), 6))
    values = held(samples, when)
    fresh = fresh_samples(values)
    assert fresh is not None
    np.testing.assert_array_equal(values[fresh], samples)


def test_a_value_that_is_sent_again_counts_again() -> None:
    """As of a sensor of coarse steps, at rest: a contact begins where it is felt."""
    when = sent(SLOW)
    samples = np.zeros((len(when), 3))
    samples[:, 0] = np.where(np.arange(len(when)) % 60 > 20, np.arange(len(when)), 7.0)
    fresh = fresh_samples(held(samples, when))
    assert fresh is not None
    np.testing.assert_allclose(np.diff(TIME[fresh]), 1 / SLOW, atol=0.05)


@pytest.mark.parametrize("step", [0.0, 1.0, 3.0, 6.0])
def test_rows_of_a_coarse_sensor_are_its_own(step: float) -> None:
    """They repeat by chance, up to most of them."""
    values = np.random.default_rng(3).normal(size=(2500, 3))
    values = np.round(values / step) * step if step else values
    assert fresh_samples(values) is None
    assert fresh_samples(np.zeros((2500, 3))) is None


def recording(folder: Path, place: str) -> dict[str, Any]:
    """A swinging arm, whose sensor of 6 Hz is in the robot's file, in one of its own, or stored."""
    phase = 2.0 * TIME[:, None] + np.arange(6)
    robot = {"actual_q": np.sin(phase), "actual_qd": 2.0 * np.cos(phase)}
    when = sent(SLOW)
    wrench = held(20.0 + np.random.default_rng(4).normal(size=(len(when), 6)), when)
    entry: dict[str, Any] = {"folder": str(folder), "format": "rtde-csv", "file": "robot.csv"}
    if place == "stored":
        np.savez(folder / "run.npz", time=TIME, wrench=wrench, **robot)
        channels = {"time": "time"} | {name: name for name in robot}
        sensor = {"channels": {"time": "time", "ft": "wrench"}}
        own = {"format": "npz", "file": "run.npz", "channels": channels, "force_sensor": sensor}
        return entry | own
    columns = {name: values for one in robot for name, values in named(robot[one], one).items()}
    forces = dict(zip(FORCE_CHANNELS, wrench.T, strict=True))
    both = columns | (forces if place == "beside" else {})
    pd.DataFrame({"timestamp": TIME, **both}).to_csv(folder / "robot.csv", index=False)
    if place == "own":
        table = pd.DataFrame({"time": TIME, **forces})
        table.to_csv(folder / "force.csv", index=False, header=False)
        entry["force_sensor"] = {"file": "force.csv", "columns": ["time", "ft"]}
    return entry


def check(intake: Intake) -> None:
    sensor = intake.sensors["force"]
    assert len(sensor) == len(sent(SLOW))
    np.testing.assert_allclose(np.diff(sensor["time"]), 1 / SLOW, atol=1 / ROWS)
    assert not [name for name in intake.robot if name.startswith("ft_")]
    found = {one.code: one for one in intake.quality.findings if one.device == "force"}
    assert found[Found.HELD_SAMPLES].count == len(TIME) - len(sensor)
    assert "measures at 6 Hz" in said(found[Found.HELD_SAMPLES])
    assert found.keys() <= {Found.HELD_SAMPLES, Found.ASSUMED_FRAME}


@pytest.mark.parametrize("place", ["beside", "own", "stored"])
def test_held_samples_are_left_out_wherever_they_are(
    tmp_path: Path, ur5: Robot, place: str
) -> None:
    intake = read_and_check(recording(tmp_path, place), ur5, 0.1)
    check(intake)
    assert abs(intake.quality.starts["force"].seconds) < 1 / ROWS


def test_the_interval_of_a_slow_sensors_bias_holds() -> None:
    """At the robot's rate, twenty rows follow from one sample of the sensor's."""
    when, each = sent(SLOW), []
    for seed in range(12):
        noise = np.random.default_rng(seed).normal(size=(len(when), 6)) * ([0.5] * 3 + [0.05] * 3)
        reading = np.column_stack([np.interp(TIME, when, own) for own in noise.T])
        offset = fit_offset(reading, np.tile([0.0, 0.0, -9.81], (len(TIME), 1)), 1 / ROWS)
        each.append(offset.bias / offset.bias_std)
    assert np.sqrt(np.mean(np.square(each))) < 1.2
