"""Calibration of an IMU against the joints: mounting, place, tilt of the base, and biases."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.tables import BY_KEY
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import BLOCK_DURATION, by_segment

RECORDING_PARAMETERS = (
    4  # parameters of a recording: the accelerometer's bias and a remaining clock error
)
PLACE_COLUMNS = slice(8, 11)  # the IMU's follow mounting, tilt and gyroscope's bias


@dataclass(frozen=True)
class ImuRecord:
    """A recording's predictions by the joints and readings of the IMU, with the same low-pass, no
    gaps.

    time: (N,) [s]; rotation: R_6 (N, 3, 3); specific_force: R_6^T (a - g0) (N, 3) [m/s²] at the IMU
    and angular_rate: (N, 3) [rad/s], both predicted, in frame 6; by_place: (N, 3, 3) [1/s²],
    derivative of the specific force with respect to the IMU's place; accelerometer, gyroscope: (N,
    3) the readings; place: (3,) [m] of the IMU in frame 6, and gravity: g0 (3,) [m/s²], base frame,
    both by the arm's description.
    """

    time: Array
    rotation: Array
    specific_force: Array
    angular_rate: Array
    by_place: Array
    accelerometer: Array
    gyroscope: Array
    place: Array
    gravity: Array


@dataclass(frozen=True)
class ImuCalibration:
    """The calibration that all recordings share.

    mounting: (3,) [rad], rotation vector of R_m, the IMU's axes in frame 6; tilt: (2,) [rad],
    components of "up" along the two `level_axes`, zero if the base is mounted as described;
    gyroscope_bias: (3,) [rad/s]; place: (3,) [m], in frame 6; each with its standard error.
    described: (3,) [m], the place in the arm's description; held_out: error of the specific force
    on left-out recordings, ratio of estimated to described place, 1 for a single recording. Below
    1, the estimated place is used, and the rest was fitted with it. from_: names of the recordings.
    """

    __pydantic_config__ = BY_KEY
    mounting: Array
    mounting_std: Array
    tilt: Array
    tilt_std: Array
    gyroscope_bias: Array
    gyroscope_bias_std: Array
    place: Array
    place_std: Array
    described: Array
    held_out: float
    from_: tuple[str, ...] = ()

    def shift(self) -> Array:
        """Return the IMU's place in use minus the described one (3,) [m]."""
        return self.place - self.described if self.held_out < 1 else np.zeros(3)

    def axes(self) -> Array:
        """Return R_m (3, 3), from the IMU's axes to those of frame 6."""
        return Rotation.from_rotvec(self.mounting).as_matrix()

    def up(self, gravity: Array) -> Array:
        """Return the specific force at rest (3,) [m/s²], base frame, with the base's tilt.

        gravity: (3,) [m/s²], base frame, as the arm's description has it.
        """
        # up is a unit vector: its components across gravity leave √(1 - β²) along it
        upright = np.sqrt(1 - self.tilt @ self.tilt)
        return np.linalg.norm(gravity) * (level_axes(gravity) @ self.tilt) - upright * gravity


_UNCHANGED: list[Any] = [*(np.zeros(n) for n in (3, 3, 2, 2, 3, 3, 3, 3, 3)), 1.0]
NOMINAL_CALIBRATION = ImuCalibration(*_UNCHANGED)  # as in the arm's drawing


def level_axes(gravity: Array) -> Array:
    """Return two unit vectors (3, 2) across gravity (3,), base frame; x and y if it is along -z."""
    up = -gravity / np.linalg.norm(gravity)
    across = np.eye(3)[np.argmin(np.abs(up))]
    first = across - (across @ up) * up
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(up, first)])


def calibrate_without_each(records: Mapping[str, ImuRecord]) -> dict[str, ImuCalibration]:
    """Return a calibration from all records, "all", and for each record one from the others.

    No recording is thus judged by a calibration that it contributed to. Whether the estimated place
    is used is decided once, by all records.
    """
    sums = {name: _Sums.of(record) for name, record in records.items()}
    held_out = _place_error_ratio(list(sums.values()))
    choices = {"all": sums} | {
        name: {other: part for other, part in sums.items() if other != name} for name in sums
    }
    return {
        name: replace(_calibration([*contributing.values()], held_out), from_=tuple(contributing))
        for name, contributing in choices.items()
        if contributing
    }


def calibration_for(recording: str, calibrations: Mapping[str, ImuCalibration]) -> ImuCalibration:
    """Return the calibration from other recordings; without any, the nominal one.

    calibrations: result of `calibrate_without_each`.
    """
    candidates = [calibrations[key] for key in (recording, "all") if key in calibrations]
    return next(
        (calibration for calibration in candidates if recording not in calibration.from_),
        NOMINAL_CALIBRATION,
    )


def _calibration(sums: "Sequence[_Sums]", held_out: float) -> ImuCalibration:
    """Fit the calibration with the place estimated, and with it as described if that is better.

    Least squares of  accelerometer = f + f × θ + g R_6^T E β + ∂f/∂r Δr + b_a + f' δ  and
    gyroscope = ω + ω × θ + b_g + ω' δ  over the mounting θ, the base's tilt β along the level axes
    E, the gyroscope's bias b_g, the error Δr of the IMU's described place, and for each recording
    an accelerometer's bias b_a and a remaining clock error δ. Accelerations and rates are weighted
    by their residuals. Without δ, a clock error of half a millisecond changes the mounting by as
    much as all noise does. Standard errors are a jackknife over blocks of 2 s, within which
    residuals are correlated.
    """
    value, std = _jackknife(sums)
    described = sums[0].place
    place = [value[PLACE_COLUMNS] + described, std[PLACE_COLUMNS], described]
    if held_out >= 1:
        value, std = _jackknife([part.as_described() for part in sums])
    parts = (slice(0, 3), slice(3, 5), slice(5, 8))
    fields: list[Any] = [values[part] for part in parts for values in (value, std)]
    fields += [*place, held_out]
    return ImuCalibration(*fields)


def _place_error_ratio(sums: "Sequence[_Sums]") -> float:
    """Return the RMS error of left-out specific forces with the estimated place, divided by that
    with the described place; 1 for a single recording.
    """
    if len(sums) < 2:
        return 1.0
    estimated, described = map(_left_out_squares, (sums, [part.as_described() for part in sums]))
    return float(np.sqrt(estimated / described))


def _left_out_squares(sums: "Sequence[_Sums]") -> float:
    """Return the sum of squared residuals of each recording's specific forces, by the calibration
    from the others.
    """
    scale = _scale(sums)
    reduced = [_without_own(part.weighted(scale).sum(axis=0)) for part in sums]
    others = np.sum(reduced, axis=0) - reduced
    parts = zip(sums, _normal_solution(others), strict=True)
    return float(sum(part.unexplained_squares(scale, shared)[0] for part, shared in parts))


def accelerometer_bias(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """Return the accelerometer's bias (3,) [m/s²] in one recording, given the calibration."""
    predicted = specific_force(record, calibration) @ calibration.axes()
    return np.mean(record.accelerometer - predicted, axis=0)


def specific_force(record: ImuRecord, calibration: ImuCalibration) -> Array:
    """Return the specific force (N, 3) [m/s²] predicted by the joints, frame 6, tilted base."""
    lean = calibration.up(record.gravity) + record.gravity
    moved = np.matvec(record.by_place, calibration.shift())
    return record.specific_force + lean @ record.rotation + moved


@dataclass(frozen=True)
class _Sums:
    """The normal equations of a recording: sums over each of its B blocks, by force and rate.

    products: Zᵀ Z (B, 2, P + 1, P + 1) of the columns X of shared parameters, the misfit y, and the
    columns of the recording's own RECORDING_PARAMETERS, Z = [X_shared y X_own], P = 15;
    count: N, the samples behind them; place: (3,) [m], as described.
    """

    products: Array
    count: int
    place: Array

    @classmethod
    def of(cls, record: ImuRecord) -> Self:
        """Return the sums of a recording."""
        block = ((record.time - record.time[0]) // BLOCK_DURATION).astype(np.int64)
        starts = np.flatnonzero(np.diff(block, prepend=-1))
        Z = _columns(record).reshape(len(block), 2, 3, -1)
        products = np.add.reduceat(np.einsum("nkip,nkiq->nkpq", Z, Z), starts, axis=0)
        return cls(products, len(block), record.place)

    def as_described(self) -> Self:
        """Return the sums without the columns of the IMU's place, P = 12."""
        products = np.delete(np.delete(self.products, PLACE_COLUMNS, axis=2), PLACE_COLUMNS, axis=3)
        return replace(self, products=products)

    def weighted(self, scale: Array) -> Array:
        """Return the products (B, P + 1, P + 1), forces and rates divided by a scale (2,)."""
        return np.einsum("bkpq,k->bpq", self.products, scale**-2.0)

    def unexplained_squares(self, scale: Array, shared: Array) -> Array:
        """Return the squared residuals (2,) of forces and rates, given the shared parameters."""
        normal = self.weighted(scale).sum(axis=0)
        z = np.append(-shared, 1.0)
        # the recording's own parameters that fit best, given the shared ones
        own_parameters = np.linalg.pinv(
            normal[-RECORDING_PARAMETERS:, -RECORDING_PARAMETERS:], hermitian=True
        ) @ (normal[-RECORDING_PARAMETERS:, :-RECORDING_PARAMETERS] @ z)
        z = np.append(z, -own_parameters)
        # |y - X p|² = zᵀ Zᵀ Z z, never zero
        return np.maximum(self.products.sum(axis=0) @ z @ z, 1e-24)


def _columns(record: ImuRecord) -> Array:
    """Return Z (N, 6, 16): columns of θ, β, b_g, Δr; the misfit; the recording's b_a and δ.

    Rows: force and rate.
    """
    predicted = np.concatenate([record.specific_force, record.angular_rate], axis=1)
    columns = np.zeros((len(record.time), 6, 16))
    # f × θ + g R_6ᵀ E β + ∂f/∂r Δr + b_a
    columns[:, :3, :3] = _cross_matrix(record.specific_force)
    lean = np.linalg.norm(record.gravity) * level_axes(record.gravity)
    columns[:, :3, 3:5] = record.rotation.swapaxes(1, 2) @ lean
    columns[:, :3, PLACE_COLUMNS] = record.by_place
    columns[:, :3, 12:15] = np.eye(3)
    # ω × θ + b_g
    columns[:, 3:, :3] = _cross_matrix(record.angular_rate)
    columns[:, 3:, 5:8] = np.eye(3)
    # readings less predictions
    columns[:, :, 11] = np.hstack([record.accelerometer, record.gyroscope]) - predicted
    # f' δ and ω' δ, derivatives in stretches without gaps
    step = np.diff(record.time, prepend=record.time[0])
    period = float(np.median(step))
    stretch = np.cumsum(step > 1.5 * period, dtype=np.int64)
    slope = by_segment(differentiate, predicted, stretch, period)
    columns[:, :, 15] = np.nan_to_num(slope)
    return columns


def _cross_matrix(vectors: Array) -> Array:
    """Return matrices (N, 3, 3) that take θ to v × θ, v: (N, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).swapaxes(1, 2)


def _without_own(products: Array) -> Array:
    """Return products (..., S + 1, S + 1) of shared parameters and misfit.

    The recording's own parameters are eliminated (Schur complement).
    """
    own_inverse = np.linalg.pinv(
        products[..., -RECORDING_PARAMETERS:, -RECORDING_PARAMETERS:], hermitian=True
    )
    cross = products[..., :-RECORDING_PARAMETERS, -RECORDING_PARAMETERS:]
    return (
        products[..., :-RECORDING_PARAMETERS, :-RECORDING_PARAMETERS]
        - cross @ own_inverse @ cross.mT
    )


def _scale(sums: Sequence[_Sums]) -> Array:
    """Return the scales (2,) of forces and rates: their residuals' RMS, found iteratively."""
    scale, count = np.ones(2), 3 * sum(part.count for part in sums)
    for _ in range(2):
        reduced = [_without_own(part.weighted(scale).sum(axis=0)) for part in sums]
        shared = _normal_solution(np.sum(reduced, axis=0))
        squares = np.sum([part.unexplained_squares(scale, shared) for part in sums], axis=0)
        scale = np.sqrt(squares / count) + 1e-12  # root mean squares, never zero
    return scale


def _jackknife(sums: Sequence[_Sums]) -> tuple[Array, Array]:
    """Return the shared parameters (S,) and their standard errors (S,), by a jackknife over
    blocks.
    """
    scale = _scale(sums)
    blocks = [part.weighted(scale) for part in sums]  # (B, P + 1, P + 1) each
    reduced = [_without_own(recording.sum(axis=0)) for recording in blocks]
    total = np.sum(reduced, axis=0)
    without = [
        total - recording + _without_own(recording_blocks.sum(axis=0) - recording_blocks)
        for recording, recording_blocks in zip(reduced, blocks, strict=True)
    ]
    estimate = _normal_solution(total)
    change = _normal_solution(np.concatenate(without)) - estimate
    return estimate, np.sqrt((len(change) - 1) / len(change) * np.sum(change**2, axis=0))


def _normal_solution(products: Array) -> Array:
    """Solve normal equations (..., S + 1, S + 1), right side in the last column, for (..., S).

    Undetermined parameters are zero.
    """
    square, right = products[..., :-1, :-1], products[..., :-1, -1]
    return np.matvec(np.linalg.pinv(square, rcond=1e-12, hermitian=True), right)
