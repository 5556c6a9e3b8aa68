"""Mounting, tilt and biases of an IMU, from what the joints predict and what it read."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from scipy.spatial.transform import Rotation

from tests.library.test_force_sensor import MOUNTINGS
from ur5lib.signals.imu_calibration import (
    AS_DRAWN,
    ImuRecord,
    accelerometer_bias,
    calibrate,
    calibrate_without_each,
    level_axes,
    specific_force,
)

GRAVITY = np.array([0, 0, -9.81])
MOUNTING = np.radians([-0.55, -0.08, 0.3])
TILT = np.radians([-0.14, 0.2])
GYROSCOPE_BIAS = np.array([-0.031, 0.024, 0.025])


def record(seed: int, seconds: float = 30, lasting: float = 0.01) -> ImuRecord:
    """Slow swings of an IMU that is mounted, tilted and biased as above; noise that lasts."""
    random = np.random.default_rng(seed)
    time = np.arange(0, seconds, 0.02)
    phase = random.uniform(0.3, 0.9, 3) * time[:, None] + random.uniform(0, 6, 3)
    rotation = Rotation.from_euler("xyz", np.sin(phase) * random.uniform(0.5, 1.5, 3)).as_matrix()
    rate = 0.4 * np.cos(phase)
    motion = 0.3 * np.sin(2 * phase)
    up = 9.81 * np.array([*TILT, np.sqrt(1 - TILT @ TILT)])
    axes = Rotation.from_rotvec(MOUNTING).as_matrix()
    noise = signal.lfilter(
        [np.sqrt(1 - 0.98**2)], [1, -0.98], random.normal(size=(2, *rate.shape)), 1
    )
    felt = np.einsum("nji,nj->ni", rotation, motion + up) @ axes + random.normal(size=3) * 0.05
    return ImuRecord(
        time=time,
        rotation=rotation,
        specific_force=np.einsum("nji,nj->ni", rotation, motion - GRAVITY),
        angular_rate=rate,
        accelerometer=felt + lasting * noise[0],
        gyroscope=rate @ axes + GYROSCOPE_BIAS + 0.2 * lasting * noise[1],
        gravity=GRAVITY,
    )


def test_without_noise_the_truth_comes_back() -> None:
    found = calibrate([record(1, lasting=0), record(2, lasting=0)])
    assert found.mounting == pytest.approx(MOUNTING, abs=1e-4)  # small angles, to second order
    assert found.tilt == pytest.approx(TILT, abs=1e-4)
    assert found.gyroscope_bias == pytest.approx(GYROSCOPE_BIAS, abs=1e-4)


def test_the_standard_errors_hold() -> None:
    """Within two of them in about 95 % of the cases, though residuals last for a second."""
    deviations = []
    for seed in range(40):
        found = calibrate([record(3 * seed + part) for part in range(3)])
        for truth, value, std in (
            (MOUNTING, found.mounting, found.mounting_std),
            (TILT, found.tilt, found.tilt_std),
            (GYROSCOPE_BIAS, found.gyroscope_bias, found.gyroscope_bias_std),
        ):
            deviations.append((value - truth) / std)
    assert 0.85 <= np.mean(np.abs(np.concatenate(deviations)) < 2) <= 0.99


def test_sixty_recordings_take_no_more_memory_than_few() -> None:
    """Each has a bias and a clock of its own; that makes no table of all by all."""
    records = {f"{seed}": record(seed, seconds=20) for seed in range(60)}
    tracemalloc.start()
    found = calibrate_without_each(records)
    assert tracemalloc.get_traced_memory()[1] < 100e6  # bytes
    tracemalloc.stop()
    assert found["7"]["from"] == [name for name in records if name != "7"]
    for name, truth in (("mounting", MOUNTING), ("tilt", TILT), ("gyroscope_bias", GYROSCOPE_BIAS)):
        assert found["all"][name] == pytest.approx(truth, abs=5e-4)
        few = calibrate([records["0"], records["1"]])
        assert (found["all"][f"{name}_std"] < getattr(few, f"{name}_std")).all()


def test_a_calibrated_reading_is_the_predicted_force() -> None:
    """Calibration from other recordings, the bias from the recording itself."""
    found, unseen = calibrate([record(1), record(2)]), record(3)
    bias = accelerometer_bias(unseen, found)
    felt = (unseen.accelerometer - bias) @ found.axes().T
    error = np.abs(felt - specific_force(unseen, found)).mean()
    uncalibrated = unseen.accelerometer - accelerometer_bias(unseen, AS_DRAWN)
    assert error < 0.015
    assert np.abs(uncalibrated - unseen.specific_force).mean() > 2 * error


@pytest.mark.parametrize("angles", MOUNTINGS.values(), ids=MOUNTINGS)
def test_the_base_s_axes_change_nothing(angles: list[float]) -> None:
    """They turn, and with them R_6 and gravity: mounting and biases stay, "up" turns along."""
    base = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    records = [record(1), record(2)]
    turned = [
        replace(own, rotation=base @ own.rotation, gravity=base @ own.gravity) for own in records
    ]
    upright, found = calibrate(records), calibrate(turned)
    for name in ("mounting", "mounting_std", "gyroscope_bias", "gyroscope_bias_std"):
        np.testing.assert_allclose(getattr(found, name), getattr(upright, name), atol=1e-9)
    np.testing.assert_allclose(found.up(base @ GRAVITY), base @ upright.up(GRAVITY), atol=1e-9)
    np.testing.assert_allclose(
        specific_force(turned[0], found), specific_force(records[0], upright), atol=1e-9
    )


def test_gravity_downwards_leaves_x_and_y_level() -> None:
    assert np.array_equal(level_axes(GRAVITY), np.eye(3)[:, :2])


def test_an_imu_as_drawn_changes_nothing() -> None:
    unseen = record(1)
    assert np.array_equal(AS_DRAWN.axes(), np.eye(3))
    assert np.array_equal(specific_force(unseen, AS_DRAWN), unseen.specific_force)
