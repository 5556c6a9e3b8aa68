"""What an IMU's readings and the joints' motion, compared, tell of its mounting and biases."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

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
    sums = {name: _sums(record) for name, record in records.items()}
    choices = {"all": sums} | {
        name: {other: part for other, part in sums.items() if other != name} for name in sums
    }
    return {
        name: {"from": list(chosen), **asdict(_calibration(list(chosen.values())))}
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
    return _calibration([_sums(record) for record in records])


def _calibration(sums: "Sequence[_Sums]") -> ImuCalibration:
    scale = np.ones(2)
    for _ in range(3):
        estimate, covariance = _jackknife(sums, scale)
        scale = _rms(sums, scale, estimate)
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


@dataclass(frozen=True)
class _Sums:
    """What least squares need of a recording: sums over each of its B blocks, by force and rate.

    squares: X^T X (B, 2, 12, 12), products: X^T y (B, 2, 12) and power: y^T y (B, 2) of columns X
    and misfit y; count: N, the samples behind them.
    """

    squares: Array
    products: Array
    power: Array
    count: int

    def weighted(self, scale: Array) -> tuple[Array, Array]:
        """Squares (B, 12, 12) and products (B, 12), forces and rates divided by a scale (2,)."""
        weight = 1 / scale**2
        return np.einsum("bkpq,k->bpq", self.squares, weight), self.products.swapaxes(1, 2) @ weight


def _sums(record: ImuRecord) -> _Sums:
    columns, misfit = _columns(record), _misfit(record)
    block = ((record.time - record.time[0]) // BLOCK).astype(np.int64)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    X, y = columns.reshape(-1, 2, 3, 12), misfit.reshape(-1, 2, 3)

    def by_block(terms: str, *factors: Array) -> Array:
        return np.add.reduceat(np.einsum(terms, *factors), starts, axis=0)

    return _Sums(
        squares=by_block("nkip,nkiq->nkpq", X, X),
        products=by_block("nkip,nki->nkp", X, y),
        power=by_block("nki,nki->nk", y, y),
        count=len(y),
    )


def _columns(record: ImuRecord) -> Array:
    """Columns (N, 6, 12) of θ, β, b_g, and of the recording's own b_a and δ; rows: force, rate."""
    columns = np.zeros((len(record.time), 6, 12))
    columns[:, :3, :3] = _cross_matrix(record.specific_force)
    lean = np.linalg.norm(record.gravity) * level_axes(record.gravity)
    columns[:, :3, 3:5] = record.rotation.swapaxes(1, 2) @ lean
    columns[:, :3, 8:11] = np.eye(3)
    columns[:, 3:, :3] = _cross_matrix(record.angular_rate)
    columns[:, 3:, 5:8] = np.eye(3)
    columns[:, :, 11] = _slope(record)
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


def _own(square: Array, product: Array, shared: Array) -> Array:
    """The recording's own parameters (4,) that fit best beside the shared ones (8,)."""
    left = product[8:] - square[8:, :8] @ shared
    return np.linalg.pinv(square[8:, 8:], hermitian=True) @ left


def _without_own(square: Array, product: Array) -> tuple[Array, Array]:
    """Normal equations (..., 8, 8) and (..., 8) of the shared parameters, the own eliminated."""
    cross = square[..., :8, 8:] @ np.linalg.pinv(square[..., 8:, 8:], hermitian=True)
    return (
        square[..., :8, :8] - cross @ square[..., 8:, :8],
        product[..., :8] - (cross @ product[..., 8:, None])[..., 0],
    )


def _rms(sums: Sequence[_Sums], scale: Array, shared: Array) -> Array:
    """Of the residuals of forces and of rates (2,), never zero."""
    left = np.zeros(2)
    for part in sums:
        squares, products = part.weighted(scale)
        estimate = np.append(shared, _own(squares.sum(axis=0), products.sum(axis=0), shared))
        explained = 2 * part.products.sum(axis=0) - part.squares.sum(axis=0) @ estimate
        left += part.power.sum(axis=0) - explained @ estimate
    return np.sqrt(np.maximum(left, 0) / (3 * sum(part.count for part in sums))) + 1e-12


def _jackknife(sums: Sequence[_Sums], scale: Array) -> tuple[Array, Array]:
    """Least squares (8,) of what recordings share, and its covariance (8, 8) by leaving out one
    block after another. Each recording's own parameters are eliminated first, as there is no end
    to them.
    """
    square, product = np.zeros((8, 8)), np.zeros(8)
    changed = []
    for part in sums:
        squares, products = part.weighted(scale)
        whole = squares.sum(axis=0), products.sum(axis=0)
        own = _without_own(*whole)
        others = _without_own(whole[0] - squares, whole[1] - products)
        square, product = square + own[0], product + own[1]
        changed.append([others[0] - own[0], others[1] - own[1]])
    squares, products = (np.concatenate(parts) for parts in zip(*changed, strict=True))
    estimate = _solved(square, product)
    change = _solved(square + squares, product + products) - estimate
    return estimate, (len(change) - 1) / len(change) * change.T @ change


def _solved(square: Array, product: Array) -> Array:
    """Zero where nothing tells."""
    return (np.linalg.pinv(square, rcond=1e-12, hermitian=True) @ product[..., None])[..., 0]
