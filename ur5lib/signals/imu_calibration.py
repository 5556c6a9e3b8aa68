"""What an IMU's readings and the joints' motion, compared, tell of its mounting and biases."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ur5lib.signals.lowpass import by_segment
from ur5lib.signals.motion import differentiate

Array = NDArray[np.float64]

BLOCK = 2.0  # s; residuals further apart than this are taken as independent


@dataclass(frozen=True)
class ImuRecord:
    """What one recording's joints predict and its IMU read, low-passed alike, without gaps.

    time: (N,) [s]; rotation: R_6 (N, 3, 3); specific_force: R_6^T (a - g0) (N, 3) [m/s²] at the
    IMU and angular_rate: (N, 3) [rad/s], both predicted, in frame 6; accelerometer, gyroscope:
    (N, 3) the readings; gravity: g0 (3,) [m/s²], base frame, as the arm's description has it.
    """

    time: Array
    rotation: Array
    specific_force: Array
    angular_rate: Array
    accelerometer: Array
    gyroscope: Array
    gravity: Array


@dataclass(frozen=True)
class ImuCalibration:
    """What does not change from one recording to the next.

    mounting: (3,) [rad], rotation vector of R_m, the IMU's axes in frame 6; tilt: (2,) [rad], what
    "up" has along the two `level_axes` of gravity, zero where the base stands as described;
    gyroscope_bias: (3,) [rad/s]; each with its standard error.
    """

    mounting: Array
    mounting_std: Array
    tilt: Array
    tilt_std: Array
    gyroscope_bias: Array
    gyroscope_bias_std: Array

    def axes(self) -> Array:
        """R_m (3, 3): a reading times it is in the axes of frame 6."""
        return Rotation.from_rotvec(self.mounting).as_matrix()

    def up(self, gravity: Array) -> Array:
        """What a level IMU at rest would read (3,) [m/s²], base frame.

        gravity: (3,) [m/s²], base frame, as the arm's description has it.
        """
        upright = np.sqrt(1 - self.tilt @ self.tilt)
        return np.linalg.norm(gravity) * (level_axes(gravity) @ self.tilt) - upright * gravity


def level_axes(gravity: Array) -> Array:
    """Two unit vectors (3, 2) across gravity (3,), base frame; x and y where it is along -z."""
    up = -gravity / np.linalg.norm(gravity)
    across = np.eye(3)[np.argmin(np.abs(up))]
    first = across - (across @ up) * up
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(up, first)])


AS_DRAWN = ImuCalibration(*(np.zeros(n) for n in (3, 3, 2, 2, 3, 3)))


def calibrate_without_each(records: Mapping[str, ImuRecord]) -> dict[str, Any]:
    """A calibration from all records, "all", and for each record one from the others only.

    So that no recording is judged by what it told itself. Each has a list "from" of names.
    """
    choices = {"all": records} | {
        name: {other: record for other, record in records.items() if other != name}
        for name in records
    }
    return {
        name: {"from": list(chosen), **asdict(calibrate(list(chosen.values())))}
        for name, chosen in choices.items()
        if chosen
    }


def calibration_for(recording: str, known: Mapping[str, Any]) -> tuple[list[str], ImuCalibration]:
    """What other recordings tell of the IMU, and which; as drawn where there are none.

    known: what `calibrate_without_each` gave.
    """
    candidates = [known[key] for key in (recording, "all") if key in known]
    for found in candidates:
        if recording not in found["from"]:
            values = {name: np.array(value) for name, value in found.items() if name != "from"}
            return found["from"], ImuCalibration(**values)
    return [], AS_DRAWN


def calibrate(records: Sequence[ImuRecord]) -> ImuCalibration:
    """The calibration that fits some recordings of one arm and IMU best.

    Least squares of  accelerometer = f + f × θ + g R_6^T E β + b_a + f' δ  and
    gyroscope = ω + ω × θ + b_g + ω' δ  over the mounting θ, the base's tilt β along the level axes
    E, the gyroscope's bias b_g, and of each recording an accelerometer's bias b_a and the rest δ
    by which its clock is off, accelerations and rates weighted by their residuals. Without
    δ, a clock that is right within half a millisecond tilts the mounting by as much as all noise
    does. Standard errors are a jackknife over blocks of 2 s, within which residuals are alike.
    """
    columns = np.concatenate([_columns(records, index) for index in range(len(records))])
    misfit = np.concatenate([_misfit(record) for record in records])
    block, scale = _blocks(records), np.ones(6)
    for _ in range(3):
        estimate, covariance = _jackknife(columns / scale[:, None], misfit / scale, block)
        scale = np.repeat(_rms(misfit - columns @ estimate), 3)
    std = np.sqrt(np.diag(covariance))
    parts = (slice(0, 3), slice(3, 5), slice(5, 8))
    return ImuCalibration(*(values[part] for part in parts for values in (estimate, std)))


def accelerometer_bias(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """The bias (3,) [m/s²] that one recording's accelerometer shows, all else being calibrated."""
    predicted = specific_force(record, calibration) @ calibration.axes()
    return np.mean(record.accelerometer - predicted, axis=0)


def specific_force(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """The specific force (N, 3) [m/s²] that the joints predict, frame 6, on a tilted base."""
    lean = calibration.up(record.gravity) + record.gravity
    return record.specific_force + lean @ record.rotation


def _columns(records: Sequence[ImuRecord], index: int) -> Array:
    """Columns (N, 6, 8 + 4K) of θ, β, b_g, K times b_a and K times δ; rows: force, then rate."""
    record, count = records[index], len(records)
    columns = np.zeros((len(record.time), 6, 8 + 4 * count))
    columns[:, :3, :3] = _cross_matrix(record.specific_force)
    lean = np.linalg.norm(record.gravity) * level_axes(record.gravity)
    columns[:, :3, 3:5] = record.rotation.swapaxes(1, 2) @ lean
    columns[:, :3, 8 + 3 * index : 11 + 3 * index] = np.eye(3)
    columns[:, 3:, :3] = _cross_matrix(record.angular_rate)
    columns[:, 3:, 5:8] = np.eye(3)
    columns[:, :, 8 + 3 * count + index] = _slope(record)
    return columns


def _slope(record: ImuRecord) -> Array:
    """How fast (N, 6) the predicted force and rate change, in stretches without gaps."""
    step = np.diff(record.time, prepend=record.time[0])
    period = float(np.median(step))
    predicted = np.concatenate([record.specific_force, record.angular_rate], axis=1)
    stretch = np.cumsum(step > 1.5 * period, dtype=np.int64)
    return np.nan_to_num(by_segment(partial(differentiate, period=period), predicted, stretch))


def _misfit(record: ImuRecord) -> Array:
    """What the IMU read beyond what the joints predict (N, 6): force, then rate."""
    force = record.accelerometer - record.specific_force
    return np.concatenate([force, record.gyroscope - record.angular_rate], axis=1)


def _cross_matrix(vectors: Array) -> Array:
    """Matrices (N, 3, 3) that take θ to v × θ, v: (N, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).swapaxes(1, 2)


def _rms(residual: Array) -> Array:
    """Of forces and of rates (2,), never zero. residual: (N, 6)."""
    return np.sqrt(np.mean(residual.reshape(-1, 2, 3) ** 2, axis=(0, 2))) + 1e-12


def _blocks(records: Sequence[ImuRecord]) -> NDArray[np.int64]:
    """Labels (ΣN,) of stretches of 2 s, no two recordings sharing one."""
    labels, first = [], 0
    for record in records:
        block = ((record.time - record.time[0]) // BLOCK).astype(np.int64)
        labels.append(first + block)
        first += int(block[-1]) + 1
    return np.concatenate(labels)


def _jackknife(X: Array, y: Array, block: NDArray[np.int64]) -> tuple[Array, Array]:
    """Least squares (P,) of X (N, R, P) to y (N, R), and its covariance (P, P) by leaving out one
    block (N,) after another.
    """
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    squares = np.add.reduceat(np.einsum("nrp,nrq->npq", X, X), starts, axis=0)
    products = np.add.reduceat(np.einsum("nrp,nr->np", X, y), starts, axis=0)
    square, product = squares.sum(axis=0), products.sum(axis=0)
    estimate = np.linalg.pinv(square, hermitian=True) @ product
    others = np.linalg.pinv(square - squares, hermitian=True) @ (product - products)[..., None]
    change = others[..., 0] - estimate
    return estimate, (len(starts) - 1) / len(starts) * change.T @ change
