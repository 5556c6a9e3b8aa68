"""Calibration of an IMU against the joints: mounting, tilt of the base, and biases."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

BLOCK = 2.0  # s; residuals further apart than this count as independent


@dataclass(frozen=True)
class ImuRecord:
    """Predictions of one recording's joints and readings of its IMU, low-passed alike, no gaps.

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
    """The calibration that all recordings share.

    mounting: (3,) [rad], rotation vector of R_m, the IMU's axes in frame 6; tilt: (2,) [rad],
    components of "up" along the two `level_axes`, zero if the base stands as described;
    gyroscope_bias: (3,) [rad/s]; each with its standard error.
    """

    mounting: Array
    mounting_std: Array
    tilt: Array
    tilt_std: Array
    gyroscope_bias: Array
    gyroscope_bias_std: Array

    def axes(self) -> Array:
        """Return R_m (3, 3), from the IMU's axes to those of frame 6."""
        return Rotation.from_rotvec(self.mounting).as_matrix()

    def up(self, gravity: Array) -> Array:
        """Return the specific force at rest (3,) [m/s²], base frame, with the base's tilt.

        gravity: (3,) [m/s²], base frame, as the arm's description has it.
        """
        upright = np.sqrt(1 - self.tilt @ self.tilt)
        return np.linalg.norm(gravity) * (level_axes(gravity) @ self.tilt) - upright * gravity


def level_axes(gravity: Array) -> Array:
    """Return two unit vectors (3, 2) across gravity (3,), base frame; x and y if it is along -z."""
    up = -gravity / np.linalg.norm(gravity)
    across = np.eye(3)[np.argmin(np.abs(up))]
    first = across - (across @ up) * up
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(up, first)])


AS_DRAWN = ImuCalibration(*(np.zeros(n) for n in (3, 3, 2, 2, 3, 3)))


def calibrate_without_each(records: Mapping[str, ImuRecord]) -> dict[str, Any]:
    """Return a calibration from all records, "all", and for each record one from the others.

    So no recording is judged by a calibration that it contributed to. Each has a list "from" of
    recordings' names.
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
    """Return the calibration from other recordings, and their names; as drawn without any.

    known: result of `calibrate_without_each`.
    """
    candidates = [known[key] for key in (recording, "all") if key in known]
    for found in candidates:
        if recording not in found["from"]:
            values = {name: np.array(value) for name, value in found.items() if name != "from"}
            return found["from"], ImuCalibration(**values)
    return [], AS_DRAWN


def calibrate(records: Sequence[ImuRecord]) -> ImuCalibration:
    """Fit the calibration to recordings of one arm and IMU.

    Least squares of  accelerometer = f + f × θ + g R_6^T E β + b_a + f' δ  and
    gyroscope = ω + ω × θ + b_g + ω' δ  over the mounting θ, the base's tilt β along the level axes
    E, the gyroscope's bias b_g, and for each recording an accelerometer's bias b_a and a remaining
    clock error δ. Accelerations and rates are weighted by their residuals. Without δ, a clock error
    of half a millisecond changes the mounting by as much as all noise does. Standard errors are a
    jackknife over blocks of 2 s, within which residuals are correlated.
    """
    return _calibration([_sums(record) for record in records])


def _calibration(sums: "Sequence[_Sums]") -> ImuCalibration:
    """Fit the calibration, alternating with the weights of forces and rates."""
    scale = np.ones(2)
    for _ in range(3):
        estimate, covariance = _jackknife(sums, scale)
        scale = _rms(sums, scale, estimate)
    std = np.sqrt(np.diag(covariance))
    parts = (slice(0, 3), slice(3, 5), slice(5, 8))
    return ImuCalibration(*(values[part] for part in parts for values in (estimate, std)))


def accelerometer_bias(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """Return the accelerometer's bias (3,) [m/s²] in one recording, given the calibration."""
    predicted = specific_force(record, calibration) @ calibration.axes()
    return np.mean(record.accelerometer - predicted, axis=0)


def specific_force(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """Return the specific force (N, 3) [m/s²] predicted by the joints, frame 6, tilted base."""
    lean = calibration.up(record.gravity) + record.gravity
    return record.specific_force + lean @ record.rotation


@dataclass(frozen=True)
class _Sums:
    """Normal equations of a recording: sums over each of its B blocks, by force and rate.

    squares: X^T X (B, 2, 12, 12), products: X^T y (B, 2, 12) and power: y^T y (B, 2) of columns X
    and misfit y; count: N, the samples behind them.
    """

    squares: Array
    products: Array
    power: Array
    count: int

    def weighted(self, scale: Array) -> tuple[Array, Array]:
        """Return squares (B, 12, 12) and products (B, 12), forces and rates divided by a scale."""
        weight = 1 / scale**2
        return np.einsum("bkpq,k->bpq", self.squares, weight), self.products.swapaxes(1, 2) @ weight


def _sums(record: ImuRecord) -> _Sums:
    """Sum the normal equations of a recording over its blocks."""
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
    """Return columns (N, 6, 12) of θ, β, b_g, and the recording's b_a and δ; rows: force, rate."""
    columns = np.zeros((len(record.time), 6, 12))
    # f × θ + g R_6ᵀ E β + b_a
    columns[:, :3, :3] = _cross_matrix(record.specific_force)
    lean = np.linalg.norm(record.gravity) * level_axes(record.gravity)
    columns[:, :3, 3:5] = record.rotation.swapaxes(1, 2) @ lean
    columns[:, :3, 8:11] = np.eye(3)
    # ω × θ + b_g
    columns[:, 3:, :3] = _cross_matrix(record.angular_rate)
    columns[:, 3:, 5:8] = np.eye(3)
    # f' δ and ω' δ
    columns[:, :, 11] = _slope(record)
    return columns


def _slope(record: ImuRecord) -> Array:
    """Return the derivatives (N, 6) of the predicted force and rate in stretches without gaps."""
    step = np.diff(record.time, prepend=record.time[0])
    period = float(np.median(step))
    predicted = np.concatenate([record.specific_force, record.angular_rate], axis=1)
    stretch = np.cumsum(step > 1.5 * period, dtype=np.int64)
    return np.nan_to_num(by_segment(partial(differentiate, period=period), predicted, stretch))


def _misfit(record: ImuRecord) -> Array:
    """Return readings minus predictions (N, 6): force, then rate."""
    force = record.accelerometer - record.specific_force
    return np.concatenate([force, record.gyroscope - record.angular_rate], axis=1)


def _cross_matrix(vectors: Array) -> Array:
    """Return matrices (N, 3, 3) that take θ to v × θ, v: (N, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).swapaxes(1, 2)


def _own(square: Array, product: Array, shared: Array) -> Array:
    """Return the recording's own parameters (4,) that fit best, given the shared ones (8,)."""
    right = product[8:] - square[8:, :8] @ shared
    return np.linalg.pinv(square[8:, 8:], hermitian=True) @ right


def _without_own(square: Array, product: Array) -> tuple[Array, Array]:
    """Return the normal equations (..., 8, 8) and (..., 8) of the shared parameters.

    The recording's own parameters are eliminated (Schur complement).
    """
    cross = square[..., :8, 8:] @ np.linalg.pinv(square[..., 8:, 8:], hermitian=True)
    return (
        square[..., :8, :8] - cross @ square[..., 8:, :8],
        product[..., :8] - (cross @ product[..., 8:, None])[..., 0],
    )


def _rms(sums: Sequence[_Sums], scale: Array, shared: Array) -> Array:
    """Return the root mean squares (2,) of the residuals of forces and rates, never zero."""
    total = np.zeros(2)
    for part in sums:
        squares, products = part.weighted(scale)
        estimate = np.append(shared, _own(squares.sum(axis=0), products.sum(axis=0), shared))
        explained = 2 * part.products.sum(axis=0) - part.squares.sum(axis=0) @ estimate
        # |y - X p|² = yᵀ y - 2 pᵀ Xᵀ y + pᵀ Xᵀ X p
        total += part.power.sum(axis=0) - explained @ estimate
    return np.sqrt(np.maximum(total, 0) / (3 * sum(part.count for part in sums))) + 1e-12


def _jackknife(sums: Sequence[_Sums], scale: Array) -> tuple[Array, Array]:
    """Return the shared parameters (8,) and their covariance (8, 8) by a jackknife over blocks.

    Each recording's own parameters are eliminated first.
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
    """Solve normal equations (..., 8, 8), (..., 8); zero for undetermined parameters."""
    return (np.linalg.pinv(square, rcond=1e-12, hermitian=True) @ product[..., None])[..., 0]
