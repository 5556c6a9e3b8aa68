"""The clock of a device: from its gyroscope and the joints' rates, else from start stamps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ur5lib.errors import Remark
from ur5lib.records.clocks import ClockRelation
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.signals.clock import CLOCK_WANDER, MOTION_METHOD, STAMPS_METHOD
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.lowpass import inner_lowpass
from ur5lib.timeseries.sampling import differentiate, interpolated
from ur5lib.timeseries.segments import by_segment, period

GAP_STEPS = 5.0  # a step longer than this many mean steps is a gap
BAND_LIMIT = 4.0  # Hz; motion of the arm is below, vibration above
FILTER_ORDER = 4
# The search, and plausible offsets, go up to these, in standard errors of the stamps.
SEARCH_DEVIATIONS = 10.0
PLAUSIBLE_DEVIATIONS = 5.0
MAX_DRIFT = 0.01  # the drift of a quartz is far below
MIN_EXPLAINED_SHARE = 0.8  # joints explain at least this share of the gyroscope's variance
JACKKNIFE_BLOCKS = 8  # few, so that each is longer than the residuals' correlation time
MIN_BLOCK_SAMPLES = 20
# Error that a jackknife within one recording cannot show: clocks from gyroscope and accelerometer
# of one IMU differ by 3 to 7 ms.
LATENCY_STD = 0.005  # s
MIN_RATE_VARIANCE = 1e-30  # (rad/s)²: avoids infinities for a perfect fit or a dead gyroscope


def clock_from_rotation(
    time: Array,
    rate: Array,
    segment: Labels,
    device_time: Array,
    gyroscope: Array,
    stamps: ClockRelation,
) -> tuple[ClockRelation, Remark | None]:
    """Estimate the clock for which a gyroscope measures the angular velocity of the joints.

    time: (N,) [s], the robot's; rate: (N, 3) [rad/s], angular velocity of frame 6 in frame 6, R_6^T
    J_w qd; segment: (N,) labels of unbroken stretches; device_time: (M,) [s], increasing;
    gyroscope: (M, 3) [rad/s], its axes nearly parallel to frame 6; stamps: clock by start stamps,
    centre of the search. Returns the clock and None, or the clock of the stamps and a remark that
    gives the reason.
    Least squares of gyroscope(t_device) = ω + ω × θ + b over offset, drift, a small mounting
    rotation θ and the bias b, both sides with the same low-pass. Standard errors by a jackknife
    over blocks of time, as neighbouring residuals are correlated, widened by LATENCY_STD and
    CLOCK_WANDER.
    """
    if min(len(time), len(device_time)) < MIN_BLOCK_SAMPLES * JACKKNIFE_BLOCKS:
        text = "the record is too short to determine its clock from motion"
        return stamps, Remark(CauseCode.SHORT_RECORD, text)
    if max(np.diff(time).mean(), np.diff(device_time).mean()) > 1 / (4 * BAND_LIMIT):
        text = "the sampling rate is too low to determine the clock from motion"
        return stamps, Remark(CauseCode.SLOW_RECORD, text)
    pair = _compare(time, rate, segment, device_time, gyroscope)
    starts = _search(pair, stamps)
    if not starts:
        text = "the records of the device and the robot hardly overlap without gaps"
        return stamps, Remark(CauseCode.LITTLE_OVERLAP, text)
    # best clock, its standard errors, and the share of variance it explains
    (offset, drift), columns, residual = _choose(pair, starts, stamps)
    offset_std, drift_std = _jackknife(columns, residual)
    offset_std = float(np.hypot(offset_std, LATENCY_STD))
    drift_std = float(np.hypot(drift_std, CLOCK_WANDER / (time[-1] - time[0])))
    clock = ClockRelation(float(offset), offset_std, float(drift), drift_std, MOTION_METHOD)
    variance = np.nanvar(pair.gyroscope, axis=0).mean() + MIN_RATE_VARIANCE
    unexplained = np.mean(residual**2) + MIN_RATE_VARIANCE
    explained = 1 - float(unexplained / variance) if len(residual) else 0.0
    doubt = _objection(clock, stamps, explained)
    return (clock, None) if doubt is None else (stamps, doubt)


def even_samples(time: Array, values: Array) -> tuple[Array, Array]:
    """Resample a device's record at even steps of its clock: (K,) [s] and (K, C), NaN in gaps.

    time: (M,) [s], increasing in irregular steps; values: (M, C).
    """
    steps = np.diff(time)
    usual = steps[steps <= _longest_step(time)].mean()
    grid = np.linspace(time[0], time[-1], 1 + round((time[-1] - time[0]) / usual))
    return grid, interpolate(grid, time, values)


def interpolate(at: Array, time: Array, values: Array) -> Array:
    """Interpolate a device's record (M, C) linearly at times (K,); NaN in gaps and outside."""
    if len(time) < 2:
        return np.full((len(at), values.shape[1]), np.nan)
    result = interpolated(at, time, values, outside=np.nan)
    next_sample = np.searchsorted(time, at).clip(1, len(time) - 1)
    result[(np.diff(time)[next_sample - 1] > _longest_step(time)) & (at < time[next_sample])] = (
        np.nan
    )
    return result


def _longest_step(time: Array) -> float:
    """Return the longest step of a device [s] that does not count as a gap."""
    return GAP_STEPS * float(np.diff(time).mean())


@dataclass(frozen=True)
class _Pair:
    """Angular velocities of robot and device, low-passed alike.

    time: (N,) and rate: (N, 3), the robot's, thinned as far as the band allows; device_time: (M,),
    gyroscope: (M, 3) and its derivative slope: (M, 3), the device's on its own clock.
    """

    time: Array
    rate: Array
    device_time: Array
    gyroscope: Array
    slope: Array


def _compare(
    time: Array, rate: Array, segment: Labels, device_time: Array, gyroscope: Array
) -> _Pair:
    """Return both angular velocities, low-passed alike, with the robot's thinned."""
    # the robot's ω, at some 4 samples per period of the band's upper end
    period = float(np.median(np.diff(time)))
    rate = _in_band(rate, segment, period)
    stride = max(1, int(1 / (4 * BAND_LIMIT * period)))
    rows = np.flatnonzero(np.isfinite(rate).all(axis=1))[::stride]
    # the gyroscope, at even steps of its own clock
    device_clock_time, even = even_samples(device_time, gyroscope)
    step = device_clock_time[1] - device_clock_time[0]
    even = _in_band(even, np.zeros(len(device_clock_time), dtype=np.int64), step)
    return _Pair(time[rows], rate[rows], device_clock_time, even, np.gradient(even, step, axis=0))


def _in_band(values: Array, segment: Labels, period: float) -> Array:
    """Low-pass without delay; NaN near the ends of an unbroken part, where the filter
    extrapolates.
    """
    return by_segment(inner_lowpass, values, segment, 1 / period, FILTER_ORDER, BAND_LIMIT)


def _misfit(pair: _Pair, clock: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Return the device's times (N',) [s], gyroscope minus ω (N', 3), and their rows (N',).

    clock: offset and drift. Rows are those of the robot's samples that both sides recorded.
    """
    device_time = (pair.time - clock[0]) / (1 + clock[1])
    misfit = interpolate(device_time, pair.device_time, pair.gyroscope) - pair.rate
    rows = np.flatnonzero(np.isfinite(misfit).all(axis=1))
    return device_time[rows], misfit[rows], rows


def _linearise(pair: _Pair, clock: Array) -> tuple[Array, Array]:
    """Return columns (N', 3, 8) of offset, drift, θ (3) and b (3), and the misfit (N', 3)."""
    device_time, misfit, rows = _misfit(pair, clock)
    # -∂(gyroscope)/∂offset = g' / (1 + drift), -∂(gyroscope)/∂drift = t_device g' / (1 + drift)
    slope = interpolate(device_time, pair.device_time, pair.slope)[:, :, None] / (1 + clock[1])
    # ω × θ and b
    turned = np.cross(pair.rate[rows, None], np.eye(3)).swapaxes(1, 2)  # (N', 3, 3)
    bias = np.broadcast_to(np.eye(3), turned.shape)
    columns = np.concatenate([slope, slope * device_time[:, None, None], turned, bias], axis=2)
    finite = np.isfinite(slope).all(axis=(1, 2))
    return columns[finite], misfit[finite]


def _solve(columns: Array, misfit: Array) -> Array:
    """Solve least squares (P,) of columns (N, 3, P) to misfit (N, 3); zero if undetermined."""
    A = columns.reshape(-1, columns.shape[2])
    return np.linalg.pinv(A.T @ A, rcond=1e-12, hermitian=True) @ (A.T @ misfit.ravel())


def _search(pair: _Pair, stamps: ClockRelation) -> list[Array]:
    """Return clocks (offset, drift) to start a fit from: local minima of the misfit over the
    offset.

    The misfit is computed on a grid around the stamps' offset, for each offset with the best drift.
    """
    length = float(np.ptp(pair.time)) if len(pair.time) else 0.0
    reach, step = SEARCH_DEVIATIONS * stamps.offset_std, 1 / (4 * BAND_LIMIT)
    offsets = stamps.offset + np.arange(-reach, reach + step, step)
    # neighbouring drifts shift the ends of the record by one step of the offset
    drifts = np.linspace(-MAX_DRIFT, MAX_DRIFT, 3 + 2 * int(MAX_DRIFT * length / (2 * step)))

    def variance(clock: Array) -> float:
        """Return the variance of the misfit under a clock, less its mean, which is the bias; θ
        matters little here.
        """
        misfit = _misfit(pair, clock)[1]
        enough = max(MIN_BLOCK_SAMPLES * JACKKNIFE_BLOCKS, len(pair.time) // 2)
        return float(misfit.var(axis=0).sum()) if len(misfit) >= enough else np.inf

    misfit = np.array([[variance(np.array([o, d])) for d in drifts] for o in offsets])
    # offsets with a best misfit that is not above that of their neighbours
    best = np.pad(misfit.min(axis=1), 1, constant_values=np.inf)
    valleys = np.isfinite(best[1:-1]) & (best[1:-1] <= np.minimum(best[:-2], best[2:]))
    rows = np.flatnonzero(valleys)
    return [np.array([offsets[row], drifts[misfit[row].argmin()]]) for row in rows]


def _choose(pair: _Pair, starts: list[Array], stamps: ClockRelation) -> tuple[Array, Array, Array]:
    """Return the best of the fits from all starts: clock (offset, drift), columns (N', 3, 8) and
    residuals (N', 3).

    A periodic motion fits equally well one period later, so the stamps count as a measurement, too.
    """

    def cost(fit: tuple[Array, Array, Array]) -> float:
        clock, _, residual = fit
        if len(residual) < MIN_BLOCK_SAMPLES * JACKKNIFE_BLOCKS:
            return np.inf
        # -2 log likelihood: n log σ² + ((offset - stamps) / std)²
        independent = 2 * BAND_LIMIT * float(np.ptp(pair.time))
        deviation = (clock[0] - stamps.offset) / stamps.offset_std
        return independent * float(np.log(np.mean(residual**2) + MIN_RATE_VARIANCE)) + deviation**2

    return min((_fit(pair, start) for start in starts), key=cost)


def _fit(pair: _Pair, clock: Array) -> tuple[Array, Array, Array]:
    """Return a fit by Gauss-Newton that starts from a clock nearby: clock (offset, drift), columns
    (N', 3, 8) and residuals (N', 3).
    """
    for _ in range(10):
        columns, misfit = _linearise(pair, clock)
        change = _solve(columns, misfit)
        clock = clock + change[:2]
    return clock, columns, misfit - columns @ change


def _jackknife(columns: Array, residual: Array) -> tuple[float, float]:
    """Return the standard errors of offset and drift by a jackknife over blocks of time."""
    blocks = np.array_split(np.arange(len(columns)), JACKKNIFE_BLOCKS)
    changes = [
        _solve(np.delete(columns, block, axis=0), np.delete(residual, block, axis=0))
        for block in blocks
    ]
    variance = (JACKKNIFE_BLOCKS - 1) / JACKKNIFE_BLOCKS * np.square(changes).sum(axis=0)
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1]))


def _objection(clock: ClockRelation, stamps: ClockRelation, explained: float) -> Remark | None:
    """Return why the motion does not determine the clock; None if it does."""
    difference, drift = clock.offset - stamps.offset, clock.drift or 0.0
    if explained < MIN_EXPLAINED_SHARE:
        text = (
            f"the joints explain only {max(explained, 0.0):.0%} of the gyroscope's variance: the "
            "arm hardly turned, the IMU is turned, or its file belongs to another recording"
        )
        return Remark(CauseCode.UNEXPLAINED_ROTATION, text)
    if abs(difference) > PLAUSIBLE_DEVIATIONS * stamps.offset_std or abs(drift) > MAX_DRIFT:
        text = (
            f"the gyroscope implies a start {number(difference, '+.2f')} s from the start stamps "
            f"and a drift of {number(drift, '+.2%')}, which is implausible: its file may belong to "
            "another recording"
        )
        return Remark(CauseCode.IMPLAUSIBLE_CLOCK, text)
    if clock.offset_std > stamps.offset_std:
        text = (
            f"the gyroscope determines the offset to ±{number(clock.offset_std, '.2g')} s, no "
            f"better than the start stamps (±{number(stamps.offset_std, '.2g')} s)"
        )
        return Remark(CauseCode.UNCERTAIN_CLOCK, text)
    return None


def device_clock(
    device_time: Array,
    gyroscope: Array | None,
    stamps: ClockRelation,
    robot: tuple[Array, Labels, Array],
    frames: tuple[Array, Array],
) -> tuple[ClockRelation, Remark | None]:
    """Return a device's clock, and why it is by its start stamp alone, if it is.

    device_time: (M,) [s], as read, on its own clock; gyroscope: (M, 3) [rad/s], if it has one;
    stamps: its clock by start stamps, or by those of the robot's host; robot: time (N,) [s],
    segment (N,) and q (N, 6) [rad], repaired; frames: R_6 (N, 3, 3) and J_g (N, 6, 6) of the
    robot's samples.
    If the robot's host stamped each sample, or the device shares the robot's clock, the stamps are
    used. Otherwise, a gyroscope is compared with the angular rate of frame 6; other devices measure
    no motion that differs from contact, so their start stamps are used.
    """
    if gyroscope is None or stamps.method != STAMPS_METHOD:
        return stamps, None
    (time, segment, q), (rotation, jacobian) = robot, frames
    # not the controller's velocities, which lag the positions by some ms
    qd = by_segment(differentiate, q, segment, period(time))
    omega = np.einsum("nij,nj->ni", jacobian[:, 3:], qd)
    return clock_from_rotation(
        time=time,
        rate=np.einsum("nji,nj->ni", rotation, omega),  # in frame 6
        segment=segment,
        device_time=device_time,
        gyroscope=gyroscope,
        stamps=stamps,
    )
