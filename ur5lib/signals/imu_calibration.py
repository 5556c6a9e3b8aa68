"""Calibration of an IMU against the joints: mounting, place, tilt of the base, and biases."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.tables import BY_KEY
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import BLOCK, by_segment

OWN = 4  # parameters of a recording: the accelerometer's bias and a remaining clock error
PLACE = slice(8, 11)  # of the IMU, after mounting, tilt and gyroscope's bias


@dataclass(frozen=True)
class ImuRecord:
    """Predictions of one recording's joints and readings of its IMU, low-passed alike, no gaps.

    time: (N,) [s]; rotation: R_6 (N, 3, 3); specific_force: R_6^T (a - g0) (N, 3) [m/s²] at the
    IMU and angular_rate: (N, 3) [rad/s], both predicted, in frame 6; by_place: (N, 3, 3) [1/s²],
    derivative of the specific force to the IMU's place; accelerometer, gyroscope: (N, 3) the
    readings; place: (3,) [m] of the IMU in frame 6, and gravity: g0 (3,) [m/s²], base frame, as the
    arm's description has them.
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
    components of "up" along the two `level_axes`, zero if the base stands as described;
    gyroscope_bias: (3,) [rad/s]; place: (3,) [m], in frame 6; each with its standard error.
    described: (3,) [m], the place in the arm's description; held_out: error of the specific force
    on recordings left out, with the estimated place by that with the described one, 1 if there is
    but one recording. Below 1, the calibration was fitted and is used with the estimated place.
    from_: names of the recordings.
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
        """Return by how much the IMU's place differs (3,) [m] from the arm's description."""
        return self.place - self.described if self.held_out < 1 else np.zeros(3)

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


_NOTHING: list[Any] = [*(np.zeros(n) for n in (3, 3, 2, 2, 3, 3, 3, 3, 3)), 1.0]
AS_DRAWN = ImuCalibration(*_NOTHING)


def calibrate_without_each(records: Mapping[str, ImuRecord]) -> dict[str, ImuCalibration]:
    """Return a calibration from all records, "all", and for each record one from the others.

    So no recording is judged by a calibration that it contributed to. Whether the place is taken as
    estimated is chosen once, on all of them.
    """
    sums = {name: _normal_equations(record) for name, record in records.items()}
    held_out = _held_out(list(sums.values()))
    choices = {"all": sums} | {
        name: {other: part for other, part in sums.items() if other != name} for name in sums
    }
    return {
        name: replace(_calibration([*chosen.values()], held_out), from_=tuple(chosen))
        for name, chosen in choices.items()
        if chosen
    }


def calibration_for(recording: str, known: Mapping[str, ImuCalibration]) -> ImuCalibration:
    """Return the calibration from other recordings; as drawn without any.

    known: result of `calibrate_without_each`.
    """
    candidates = [known[key] for key in (recording, "all") if key in known]
    return next((found for found in candidates if recording not in found.from_), AS_DRAWN)


def calibrate(records: Sequence[ImuRecord]) -> ImuCalibration:
    """Fit the calibration to recordings of one arm and IMU.

    Least squares of  accelerometer = f + f × θ + g R_6^T E β + ∂f/∂r Δr + b_a + f' δ  and
    gyroscope = ω + ω × θ + b_g + ω' δ  over the mounting θ, the base's tilt β along the level axes
    E, the gyroscope's bias b_g, the error Δr of the IMU's described place, and for each recording
    an accelerometer's bias b_a and a remaining clock error δ. Accelerations and rates are weighted
    by their residuals. Without δ, a clock error of half a millisecond changes the mounting by as
    much as all noise does. Standard errors are a jackknife over blocks of 2 s, within which
    residuals are correlated.
    """
    sums = [_normal_equations(record) for record in records]
    return _calibration(sums, _held_out(sums))


def _calibration(sums: "Sequence[_NormalEquations]", held_out: float) -> ImuCalibration:
    """Fit the calibration with the place estimated, and with it as described if that is better."""
    value, std = _jackknife(sums)
    described = sums[0].place
    place = [value[PLACE] + described, std[PLACE], described]
    if held_out >= 1:
        value, std = _jackknife([part.as_described() for part in sums])
    parts = (slice(0, 3), slice(3, 5), slice(5, 8))
    found: list[Any] = [values[part] for part in parts for values in (value, std)]
    found += [*place, held_out]
    return ImuCalibration(*found)


def _scale(sums: "Sequence[_NormalEquations]") -> Array:
    """Return the scales of forces and rates (2,), in turn with what is left of both."""
    scale = np.ones(2)
    for _ in range(2):
        square, product = _shared_equations(sums, scale)[0]
        scale = _rms(sums, scale, _solved(square, product))
    return scale


def _held_out(sums: "Sequence[_NormalEquations]") -> float:
    """Return the error of forces left out, with the estimated place by that as described."""
    if len(sums) < 2:
        return 1.0
    estimated, described = map(_left_out, (sums, [part.as_described() for part in sums]))
    return float(np.sqrt(estimated / described))


def _left_out(sums: "Sequence[_NormalEquations]") -> float:
    """Return the squares of forces that calibrations from the other recordings leave."""
    scale = _scale(sums)
    (square, product), parts = _shared_equations(sums, scale)
    left = [
        part.left(scale, _solved(square - own[0], product - own[1]))[0]
        for part, (_, _, own) in zip(sums, parts, strict=True)
    ]
    return float(sum(left))


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
class _NormalEquations:
    """Normal equations of a recording: sums over each of its B blocks, by force and rate.

    squares: X^T X (B, 2, P, P), products: X^T y (B, 2, P) and power: y^T y (B, 2) of columns X and
    misfit y, P = 15, the last four the recording's own; count: N, the samples behind them; place:
    (3,) [m], as described.
    """

    squares: Array
    products: Array
    power: Array
    count: int
    place: Array

    def as_described(self) -> "_NormalEquations":
        """Return the sums without the columns of the IMU's place, P = 12."""
        squares = np.delete(np.delete(self.squares, PLACE, axis=2), PLACE, axis=3)
        return replace(self, squares=squares, products=np.delete(self.products, PLACE, axis=2))

    def left(self, scale: Array, shared: Array) -> Array:
        """Return the squares (2,) that are left of forces and rates, given shared parameters."""
        square, product = (part.sum(axis=0) for part in self.weighted(scale))
        # the recording's own parameters that fit best, given the shared ones
        right = product[-OWN:] - square[-OWN:, :-OWN] @ shared
        own = np.linalg.pinv(square[-OWN:, -OWN:], hermitian=True) @ right
        estimate = np.append(shared, own)
        explained = 2 * self.products.sum(axis=0) - self.squares.sum(axis=0) @ estimate
        # |y - X p|² = yᵀ y - 2 pᵀ Xᵀ y + pᵀ Xᵀ X p, never zero
        return np.maximum(self.power.sum(axis=0) - explained @ estimate, 1e-24)

    def weighted(self, scale: Array) -> tuple[Array, Array]:
        """Return squares (B, P, P) and products (B, P), forces and rates divided by a scale."""
        weight = 1 / scale**2
        return np.einsum("bkpq,k->bpq", self.squares, weight), self.products.swapaxes(1, 2) @ weight


def _normal_equations(record: ImuRecord) -> _NormalEquations:
    """Sum the normal equations of a recording over its blocks."""
    columns, force = _columns(record), record.accelerometer - record.specific_force
    misfit = np.concatenate([force, record.gyroscope - record.angular_rate], axis=1)
    block = ((record.time - record.time[0]) // BLOCK).astype(np.int64)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    X, y = columns.reshape(-1, 2, 3, columns.shape[2]), misfit.reshape(-1, 2, 3)

    def by_block(terms: str, *factors: Array) -> Array:
        return np.add.reduceat(np.einsum(terms, *factors), starts, axis=0)

    return _NormalEquations(
        squares=by_block("nkip,nkiq->nkpq", X, X),
        products=by_block("nkip,nki->nkp", X, y),
        power=by_block("nki,nki->nk", y, y),
        count=len(y),
        place=record.place,
    )


def _columns(record: ImuRecord) -> Array:
    """Return columns (N, 6, 15) of θ, β, b_g, Δr, and the recording's b_a and δ.

    Rows: force and rate.
    """
    columns = np.zeros((len(record.time), 6, 15))
    # f × θ + g R_6ᵀ E β + ∂f/∂r Δr + b_a
    columns[:, :3, :3] = _cross_matrix(record.specific_force)
    lean = np.linalg.norm(record.gravity) * level_axes(record.gravity)
    columns[:, :3, 3:5] = record.rotation.swapaxes(1, 2) @ lean
    columns[:, :3, PLACE] = record.by_place
    columns[:, :3, 11:14] = np.eye(3)
    # ω × θ + b_g
    columns[:, 3:, :3] = _cross_matrix(record.angular_rate)
    columns[:, 3:, 5:8] = np.eye(3)
    # f' δ and ω' δ
    columns[:, :, 14] = _slope(record)
    return columns


def _slope(record: ImuRecord) -> Array:
    """Return the derivatives (N, 6) of the predicted force and rate in stretches without gaps."""
    step = np.diff(record.time, prepend=record.time[0])
    period = float(np.median(step))
    predicted = np.concatenate([record.specific_force, record.angular_rate], axis=1)
    stretch = np.cumsum(step > 1.5 * period, dtype=np.int64)
    return np.nan_to_num(by_segment(differentiate, predicted, stretch, period))


def _cross_matrix(vectors: Array) -> Array:
    """Return matrices (N, 3, 3) that take θ to v × θ, v: (N, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).swapaxes(1, 2)


def _without_own(square: Array, product: Array) -> tuple[Array, Array]:
    """Return the normal equations (..., S, S) and (..., S) of the shared parameters.

    The recording's own parameters are eliminated (Schur complement).
    """
    own = np.linalg.pinv(square[..., -OWN:, -OWN:], hermitian=True)
    cross = square[..., :-OWN, -OWN:] @ own
    return (
        square[..., :-OWN, :-OWN] - cross @ square[..., -OWN:, :-OWN],
        product[..., :-OWN] - np.matvec(cross, product[..., -OWN:]),
    )


def _rms(sums: Sequence[_NormalEquations], scale: Array, shared: Array) -> Array:
    """Return the root mean squares (2,) of the residuals of forces and rates, never zero."""
    total = np.sum([part.left(scale, shared) for part in sums], axis=0)
    return np.sqrt(total / (3 * sum(part.count for part in sums))) + 1e-12


def _jackknife(sums: Sequence[_NormalEquations]) -> tuple[Array, Array]:
    """Return the shared parameters (S,), with standard errors by a jackknife over blocks."""
    (square, product), parts = _shared_equations(sums, _scale(sums))
    changed = []
    for squares, products, own in parts:
        others = _without_own(squares.sum(axis=0) - squares, products.sum(axis=0) - products)
        changed.append([others[0] - own[0], others[1] - own[1]])
    squares, products = (np.concatenate(change) for change in zip(*changed, strict=True))
    estimate = _solved(square, product)
    change = _solved(square + squares, product + products) - estimate
    return estimate, np.sqrt((len(change) - 1) / len(change) * np.sum(change**2, axis=0))


Equations = tuple[Array, Array]  # squares and products


def _shared_equations(
    sums: Sequence[_NormalEquations], scale: Array
) -> tuple[Equations, list[tuple[Array, Array, Equations]]]:
    """Return the equations of the shared parameters, (S, S) and (S,).

    And of each recording its weighted squares and products by block, and its part of the equations,
    from which its own parameters are eliminated.
    """
    parts = []
    for part in sums:
        squares, products = part.weighted(scale)
        own = _without_own(squares.sum(axis=0), products.sum(axis=0))
        parts.append((squares, products, own))
    square, product = (np.sum([own[k] for _, _, own in parts], axis=0) for k in (0, 1))
    return (square, product), parts


def _solved(square: Array, product: Array) -> Array:
    """Solve normal equations (..., S, S), (..., S); zero for undetermined parameters."""
    return np.matvec(np.linalg.pinv(square, rcond=1e-12, hermitian=True), product)
