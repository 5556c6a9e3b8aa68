"""Mounting, tilt and biases of an IMU, from what the joints predict and what it read."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from scipy.spatial.transform import Rotation

from tests.force.test_force_sensor import MOUNTINGS
from tests.robots.test_end_effector import sampled, swings
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import (
    NOMINAL_CALIBRATION,
    ImuCalibration,
    ImuRecord,
    accelerometer_bias,
    calibrate_without_each,
    calibration_for,
    level_axes,
    specific_force,
)
from ur5lib.timeseries.lowpass import Butterworth

GRAVITY = np.array([0, 0, -9.81])
MOUNTING = np.radians([-0.55, -0.08, 0.3])
TILT = np.radians([-0.14, 0.2])
GYROSCOPE_BIAS = np.array([-0.031, 0.024, 0.025])
DESCRIBED = np.array([0.017, 0.006, 0.0095])
SHIFT = np.array([-0.003, 0.004, 0.02])  # from there to where it is


def calibrate(records: list[ImuRecord]) -> ImuCalibration:
    """From all of some recordings."""
    return calibrate_without_each({str(k): record for k, record in enumerate(records)})["all"]


def record(
    seed: int, seconds: float = 30, lasting: float = 0.01, shift: np.ndarray = SHIFT
) -> ImuRecord:
    """Slow swings of an IMU, mounted, placed, tilted and biased as above; noise that lasts."""
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
    by_place = lever_derivative(rate, np.gradient(rate, 0.02, axis=0))
    free = np.einsum("nji,nj->ni", rotation, motion + up) + by_place @ shift
    felt = free @ axes + random.normal(size=3) * 0.05
    return ImuRecord(
        time=time,
        rotation=rotation,
        specific_force=np.einsum("nji,nj->ni", rotation, motion - GRAVITY),
        angular_rate=rate,
        by_place=by_place,
        accelerometer=felt + lasting * noise[0],
        gyroscope=rate @ axes + GYROSCOPE_BIAS + 0.2 * lasting * noise[1],
        place=DESCRIBED,
        gravity=GRAVITY,
    )


def lever_derivative(rate: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Of α × r + ω × (ω × r) to r, (N, 3, 3)."""
    columns = [np.cross(spin, e) + np.cross(rate, np.cross(rate, e)) for e in np.eye(3)]
    return np.stack(columns, axis=2)


def test_the_described_place_stands_unless_another_explains_recordings_left_out() -> None:
    """One recording cannot be left out; what is fitted with the described place has no shift."""
    alone = calibrate([record(1)])
    assert alone.held_out == 1
    as_described = [calibrate([record(s, shift=0 * SHIFT) for s in (k, k + 1)]) for k in range(10)]
    kept = [found for found in as_described if found.held_out >= 1]
    assert len(kept) > 1
    for found in (alone, *kept):
        assert not found.shift().any()
    moved = [calibrate([record(s, lasting=0.002) for s in (k, k + 1)]) for k in range(3)]
    for found in moved:
        assert found.held_out < 0.8
        np.testing.assert_array_equal(found.shift(), found.place - DESCRIBED)


def test_a_record_says_how_its_force_depends_on_the_place(ur5: Robot) -> None:
    """The specific force is linear in the place: its derivative is what a shift changes."""
    time, (q, _, _) = swings(600)
    known, design = (time, np.zeros(600), q), Butterworth(4, 2.0)
    here = sampled(ur5, known, np.zeros((600, 6)), DESCRIBED, design)
    there = sampled(ur5, known, np.zeros((600, 6)), DESCRIBED + SHIFT, design)
    moved = there.specific_force - here.specific_force
    np.testing.assert_allclose(np.matvec(here.by_place, SHIFT), moved, atol=1e-10)
    assert np.abs(moved).max() > 1e-3


def test_the_standard_errors_hold() -> None:
    """Within two of them in about 95 % of the cases, though residuals last for a second."""
    deviations = []
    for seed in range(40):
        found = calibrate([record(3 * seed + part) for part in range(3)])
        for truth, value, std in (
            (MOUNTING, found.mounting, found.mounting_std),
            (TILT, found.tilt, found.tilt_std),
            (GYROSCOPE_BIAS, found.gyroscope_bias, found.gyroscope_bias_std),
            (DESCRIBED + SHIFT, found.place, found.place_std),
        ):
            deviations.append((value - truth) / std)
    assert 0.85 <= np.mean(np.abs(np.concatenate(deviations)) < 2) <= 0.99


def test_thirty_recordings_take_no_more_memory_than_few() -> None:
    """Each has a bias and a clock of its own; that makes no table of all by all."""
    records = {f"{seed}": record(seed, seconds=8) for seed in range(30)}
    tracemalloc.start()
    found = calibrate_without_each(records)
    assert tracemalloc.get_traced_memory()[1] < 20e6  # bytes
    tracemalloc.stop()
    assert found["7"].from_ == tuple(name for name in records if name != "7")
    for name, truth in (("mounting", MOUNTING), ("tilt", TILT), ("gyroscope_bias", GYROSCOPE_BIAS)):
        assert getattr(found["all"], name) == pytest.approx(truth, abs=5e-4)
        few = calibrate([records["0"], records["1"]])
        assert (getattr(found["all"], f"{name}_std") < getattr(few, f"{name}_std")).all()


def test_a_calibrated_reading_is_the_predicted_force() -> None:
    """Calibration from other recordings, the bias from the recording itself."""
    found, unseen = calibrate([record(1), record(2)]), record(3)
    bias = accelerometer_bias(unseen, found)
    felt = (unseen.accelerometer - bias) @ found.axes().T
    error = np.abs(felt - specific_force(unseen, found)).mean()
    uncalibrated = unseen.accelerometer - accelerometer_bias(unseen, NOMINAL_CALIBRATION)
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


def test_an_imu_as_drawn_changes_nothing() -> None:
    unseen = record(1)
    assert np.array_equal(NOMINAL_CALIBRATION.axes(), np.eye(3))
    assert np.array_equal(specific_force(unseen, NOMINAL_CALIBRATION), unseen.specific_force)


def equations(records: list[ImuRecord]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows (N, 6, 11 + 4 R) of θ, β, b_g, Δr and of each recording's b_a and δ; what is left of the
    readings (N, 6); and the block of 2 s of each sample, counted over all recordings."""
    rows, left, blocks = [], [], []
    for number, own in enumerate(records):
        steps = np.diff(own.time)
        gaps = np.flatnonzero(steps > 1.5 * np.median(steps)) + 1
        predicted = np.concatenate([own.specific_force, own.angular_rate], axis=1)
        parts = np.split(predicted, gaps)
        change = [
            np.gradient(part, np.median(steps), axis=0) if len(part) > 1 else 0 * part
            for part in parts
        ]
        X = np.zeros((len(own.time), 6, 11 + 4 * len(records)))
        X[:, :3, 8:11] = own.by_place
        for k in range(3):
            X[:, :3, k] = np.cross(own.specific_force, np.eye(3)[k])
            X[:, 3:, k] = np.cross(own.angular_rate, np.eye(3)[k])
            X[:, k, 11 + 4 * number + k] = 1
            X[:, 3 + k, 5 + k] = 1
        for k in range(2):
            X[:, :3, 3 + k] = 9.81 * np.einsum("nji,j->ni", own.rotation, np.eye(3)[k])
        X[:, :, 14 + 4 * number] = np.concatenate(change)
        rows.append(X)
        left.append(np.concatenate([own.accelerometer, own.gyroscope], axis=1) - predicted)
        own_block = ((own.time - own.time[0]) // 2).astype(int)
        blocks.append(own_block + (blocks[-1].max() + 1 if blocks else 0))
    return np.concatenate(rows), np.concatenate(left), np.concatenate(blocks)


def test_a_calibration_is_weighted_least_squares_with_a_jackknife() -> None:
    """Of all equations at once, thrice, each time weighted by what was left before; a gap
    interrupts what tells the clock's error, and one sample alone tells nothing of it."""
    first, second = record(1, seconds=9), record(2, seconds=7)
    kept = np.delete(np.arange(len(first.time)), [*range(200, 230), *range(231, 240)])
    first = ImuRecord(
        **{
            name: np.asarray(value)[kept]
            for name, value in vars(first).items()
            if name not in {"place", "gravity"}
        },
        place=DESCRIBED,
        gravity=GRAVITY,
    )
    late = np.gradient(second.angular_rate, 0.02, axis=0)
    second = replace(second, gyroscope=second.gyroscope + 0.004 * late)
    found = calibrate([first, second])
    X, y, block = equations([first, second])
    scale = np.ones(2)

    def solved(rows: np.ndarray) -> np.ndarray:
        weight = np.repeat(1 / scale, 3)
        A = (X[rows] * weight[:, None]).reshape(-1, X.shape[2])
        return np.linalg.lstsq(A, (y[rows] * weight).ravel(), rcond=None)[0]

    everything = np.ones(len(y), bool)
    estimate = solved(everything)
    for _ in range(2):
        residual = (y - X @ estimate).reshape(-1, 2, 3)
        scale = np.sqrt((residual**2).mean(axis=(0, 2)))
        estimate = solved(everything)
    count = block.max() + 1
    changes = np.array([solved(block != one) - estimate for one in range(count)])
    std = np.sqrt((count - 1) / count * (changes**2).sum(axis=0))
    for name, part in (
        ("mounting", slice(3)),
        ("tilt", slice(3, 5)),
        ("gyroscope_bias", slice(5, 8)),
        ("place", slice(8, 11)),
    ):
        described = DESCRIBED if name == "place" else 0.0
        value = getattr(found, name) - described
        np.testing.assert_allclose(value, estimate[part], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(getattr(found, f"{name}_std"), std[part], rtol=1e-4)


def test_the_base_leans_by_its_tilt() -> None:
    """Up has the length of gravity; without tilt it is against it. Downwards, x and y are level."""
    assert np.array_equal(level_axes(GRAVITY), np.eye(3)[:, :2])
    found = replace(NOMINAL_CALIBRATION, tilt=np.array([0.3, -0.4]))
    np.testing.assert_allclose(found.up(GRAVITY), 9.81 * np.array([0.3, -0.4, np.sqrt(0.75)]))
    np.testing.assert_allclose(NOMINAL_CALIBRATION.up(GRAVITY), -GRAVITY)
    for gravity in ([9.81, 0, 0], [0, -9.81, 0], [3, 4, 5], [-1, 2, 0.5]):
        across = level_axes(np.array(gravity))
        np.testing.assert_allclose(across.T @ across, np.eye(2), atol=1e-12)
        np.testing.assert_allclose(np.array(gravity) @ across, 0, atol=1e-12)
        turned = np.cross(across[:, 0], across[:, 1])
        np.testing.assert_allclose(turned, -np.array(gravity) / np.linalg.norm(gravity), atol=1e-12)


def test_a_recording_is_calibrated_by_others() -> None:
    """Its own calibration if that is from others, else that of all; as drawn where none is."""
    records = {"a": record(1, seconds=6), "b": record(2, seconds=6)}
    known = calibrate_without_each(records)
    assert calibration_for("a", known).from_ == ("b",)
    assert calibration_for("other", known).from_ == ("a", "b")
    alone = calibrate_without_each({"a": records["a"]})
    assert calibration_for("a", alone) is calibration_for("a", {}) is NOMINAL_CALIBRATION
    of_b = calibration_for("a", known)
    np.testing.assert_array_equal(of_b.mounting, calibrate([records["b"]]).mounting)
