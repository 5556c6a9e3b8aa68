"""How a device's clock runs against the robot's."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.lowpass import inner_lowpass
from ur5lib.timeseries.segments import by_segment

GAP = 5.0  # mean steps of a device; a longer one is a gap
BAND, ORDER = 4.0, 4  # Hz; below it an arm moves, above it it shakes
REACH, TRUST = 10.0, 5.0  # stamps' standard errors: how far is searched, and how far is believed
MAX_DRIFT = 0.01  # far more than a quartz drifts
EXPLAINED = 0.8  # least share of the gyroscope's variance that the joints must explain
BLOCKS = 8  # of the jackknife: few, so that each is longer than what correlates the residuals
SAMPLES = 20  # least number in a block
# What no jackknife of one recording sees [s]: clocks found from gyroscope and accelerometer of one
# IMU differ by 3 to 7 ms; over a recording the clock wanders about its straight line, which tilts
# it.
LATENCY, WANDER = 0.005, 0.004
# Standard deviation of a drift that nothing tells. A quartz is good to 1e-4, but a host's software
# counts a device's stamps: the only host whose drift is known, the thesis's, is off by 0.0033.
UNKNOWN_DRIFT = 0.003
BY_STAMPS, BY_MOTION = "start stamps", "angular rate"  # how an offset was found
NOTHING = 1e-30  # (rad/s)²: keeps a perfect fit, or a dead gyroscope, from infinity


@dataclass(frozen=True)
class Clock:
    """t_robot = offset + (1 + drift) t_device, both counted from their own start stamps.

    offset, offset_std: [s]; drift, drift_std: dimensionless, None where it was not estimated;
    method: how it was found.
    """

    offset: float
    offset_std: float
    drift: float | None
    drift_std: float | None
    method: str

    def device_time(self, time: Array) -> Array:
        """What the device's clock shows at the robot's times (N,) [s]."""
        return (time - self.offset) / (1 + (self.drift or 0.0))

    def end_std(self, duration: float) -> float:
        """Standard error [s] at the end of a recording of this duration [s].

        A drift that was not estimated counts as 0 ± UNKNOWN_DRIFT.
        """
        drift_std = UNKNOWN_DRIFT if self.drift_std is None else self.drift_std
        return float(np.hypot(self.offset_std, drift_std * duration))


def clock_from_stamps(offset: float, std: float) -> Clock:
    """The clock that two start stamps tell [s]; they say nothing of a drift."""
    return Clock(offset, std, None, None, BY_STAMPS)


def clock_from_rotation(
    time: Array,
    rate: Array,
    segment: Labels,
    device_time: Array,
    gyroscope: Array,
    stamps: Clock,
) -> tuple[Clock, str | None]:
    """The clock under which a gyroscope felt the turning that the joints tell.

    time: (N,) [s], the robot's; rate: (N, 3) [rad/s], angular velocity of frame 6 in frame 6,
    R_6^T J_w qd; segment: (N,) labels of unbroken stretches; device_time: (M,) [s], increasing;
    gyroscope: (M, 3) [rad/s], its axes nearly parallel to frame 6; stamps: where to search.
    Returns the clock and None, or the stamps' and why the turning does not tell a better one.

    Least squares of gyroscope(t_device) = ω + ω × θ + b over offset, drift, a small mounting
    rotation θ and the bias b, both sides low-passed alike. Standard errors by a jackknife over
    blocks of time, because neighbouring residuals are alike, and the latencies it cannot see.
    """
    if min(len(time), len(device_time)) < SAMPLES * BLOCKS:
        return stamps, "the record is too short to determine its clock from motion"
    if max(np.diff(time).mean(), np.diff(device_time).mean()) > 1 / (4 * BAND):
        return stamps, "the sampling rate is too low to determine the clock from motion"
    pair = _compare(time, rate, segment, device_time, gyroscope)
    starts = _search(pair, stamps)
    if not starts:
        return stamps, "the records of the device and the robot hardly overlap without gaps"
    (offset, drift), columns, residual = _choose(pair, starts, stamps)
    offset_std, drift_std = _jackknife(columns, residual)
    offset_std = float(np.hypot(offset_std, LATENCY))
    drift_std = float(np.hypot(drift_std, WANDER / (time[-1] - time[0])))
    clock = Clock(float(offset), offset_std, float(drift), drift_std, BY_MOTION)
    variance = np.nanvar(pair.gyroscope, axis=0).mean() + NOTHING
    explained = 1 - float(np.mean(residual**2) / variance) if len(residual) else 0.0
    reason = _objection(clock, stamps, explained)
    return (clock, None) if reason is None else (stamps, reason)


def even_samples(time: Array, values: Array) -> tuple[Array, Array]:
    """A device's record at even steps of its own clock: (K,) [s] and (K, C), NaN inside gaps.

    time: (M,) [s], increasing in irregular steps; values: (M, C).
    """
    steps = np.diff(time)
    usual = steps[steps <= _longest_step(time)].mean()
    grid = np.linspace(time[0], time[-1], 1 + round((time[-1] - time[0]) / usual))
    return grid, interpolate(grid, time, values)


def interpolate(at: Array, time: Array, values: Array) -> Array:
    """A device's record (M, C) at other times (K,), linearly; NaN in gaps and beyond its ends."""
    if len(time) < 2:
        return np.full((len(at), values.shape[1]), np.nan)
    result = np.column_stack(
        [np.interp(at, time, column, left=np.nan, right=np.nan) for column in values.T]
    )
    after = np.searchsorted(time, at).clip(1, len(time) - 1)
    result[(np.diff(time)[after - 1] > _longest_step(time)) & (at < time[after])] = np.nan
    return result


def _longest_step(time: Array) -> float:
    """The longest step of a device [s] that is no gap."""
    return GAP * float(np.diff(time).mean())


@dataclass(frozen=True)
class _Pair:
    """Both sides in the same band.

    time: (N,) and rate: (N, 3), the robot's, as many samples as the band needs; own: (M,),
    gyroscope: (M, 3) and its derivative slope: (M, 3), the device's on its own clock.
    """

    time: Array
    rate: Array
    own: Array
    gyroscope: Array
    slope: Array


def _compare(
    time: Array, rate: Array, segment: Labels, device_time: Array, gyroscope: Array
) -> _Pair:
    period = float(np.median(np.diff(time)))
    rate = _in_band(rate, segment, period)
    own, even = even_samples(device_time, gyroscope)
    step = own[1] - own[0]
    even = _in_band(even, np.zeros(len(own), dtype=np.int64), step)
    kept = np.flatnonzero(np.isfinite(rate).all(axis=1))[:: max(1, int(1 / (4 * BAND * period)))]
    return _Pair(time[kept], rate[kept], own, even, np.gradient(even, step, axis=0))


def _in_band(values: Array, segment: Labels, period: float) -> Array:
    """Low-passed without delay; NaN near the ends of a stretch, where the filter has to guess."""
    lowpass = partial(inner_lowpass, rate=1 / period, order=ORDER, cutoff=BAND)
    return by_segment(lowpass, values, segment)


def _misfit(pair: _Pair, clock: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Gyroscope minus ω under a clock (offset, drift): (N', 3).

    Before it, the device's times (N',) [s]; after it, their rows (N',): those that both saw.
    """
    own = (pair.time - clock[0]) / (1 + clock[1])
    misfit = interpolate(own, pair.own, pair.gyroscope) - pair.rate
    rows = np.flatnonzero(np.isfinite(misfit).all(axis=1))
    return own[rows], misfit[rows], rows


def _linearise(pair: _Pair, clock: Array) -> tuple[Array, Array]:
    """Columns (N', 3, 8) of offset, drift, θ (3) and b (3), and the misfit (N', 3) they explain."""
    own, misfit, rows = _misfit(pair, clock)
    slope = interpolate(own, pair.own, pair.slope)[:, :, None] / (1 + clock[1])
    turned = np.cross(pair.rate[rows, None], np.eye(3)).swapaxes(1, 2)  # ω × θ
    bias = np.broadcast_to(np.eye(3), turned.shape)
    columns = np.concatenate([slope, slope * own[:, None, None], turned, bias], axis=2)
    known = np.isfinite(slope).all(axis=(1, 2))
    return columns[known], misfit[known]


def _solve(columns: Array, misfit: Array) -> Array:
    """Least squares (P,) of columns (N, 3, P) to misfit (N, 3); zero where nothing tells."""
    A = columns.reshape(-1, columns.shape[2])
    return np.linalg.pinv(A.T @ A, rcond=1e-12, hermitian=True) @ (A.T @ misfit.ravel())


def _search(pair: _Pair, stamps: Clock) -> list[Array]:
    """Clocks (offset, drift) around the stamps' to start a fit from: wherever offsets fit best."""
    length = float(np.ptp(pair.time)) if len(pair.time) else 0.0
    reach, step = REACH * stamps.offset_std, 1 / (4 * BAND)
    offsets = stamps.offset + np.arange(-reach, reach + step, step)
    # Neighbouring drifts move the ends of the record by one step of the offset each.
    drifts = np.linspace(-MAX_DRIFT, MAX_DRIFT, 3 + 2 * int(MAX_DRIFT * length / (2 * step)))

    def left_over(clock: Array) -> float:
        """The misfit's variance: its mean is the bias, and a small rotation hardly counts here."""
        misfit = _misfit(pair, clock)[1]
        enough = max(SAMPLES * BLOCKS, len(pair.time) // 2)
        return float(misfit.var(axis=0).sum()) if len(misfit) >= enough else np.inf

    left = np.array([[left_over(np.array([o, d])) for d in drifts] for o in offsets])
    best = np.pad(left.min(axis=1), 1, constant_values=np.inf)
    valleys = np.isfinite(best[1:-1]) & (best[1:-1] <= np.minimum(best[:-2], best[2:]))
    return [np.array([offsets[row], drifts[left[row].argmin()]]) for row in np.flatnonzero(valleys)]


def _choose(pair: _Pair, starts: list[Array], stamps: Clock) -> tuple[Array, Array, Array]:
    """The best fit from any start: clock, columns and residuals.

    A periodic motion fits as well one period on; so the stamps count as a measurement too.
    """

    def cost(fit: tuple[Array, Array, Array]) -> float:
        clock, _, residual = fit
        if len(residual) < SAMPLES * BLOCKS:
            return np.inf
        independent = 2 * BAND * float(np.ptp(pair.time))
        deviation = (clock[0] - stamps.offset) / stamps.offset_std
        return independent * float(np.log(np.mean(residual**2) + NOTHING)) + deviation**2

    return min((_fit(pair, start) for start in starts), key=cost)


def _fit(pair: _Pair, clock: Array) -> tuple[Array, Array, Array]:
    """Gauss-Newton from a clock nearby: the best clock, columns and residuals there."""
    for _ in range(10):
        columns, misfit = _linearise(pair, clock)
        change = _solve(columns, misfit)
        clock = clock + change[:2]
    return clock, columns, misfit - columns @ change


def _jackknife(columns: Array, residual: Array) -> tuple[float, float]:
    """Standard errors of offset and drift, from leaving out one block of time after another."""
    blocks = np.array_split(np.arange(len(columns)), BLOCKS)
    changes = [
        _solve(np.delete(columns, block, axis=0), np.delete(residual, block, axis=0))
        for block in blocks
    ]
    variance = (BLOCKS - 1) / BLOCKS * np.square(changes).sum(axis=0)
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1]))


def _objection(clock: Clock, stamps: Clock, explained: float) -> str | None:
    """Why the turning does not determine the clock, if so."""
    apart, drift = clock.offset - stamps.offset, clock.drift or 0.0
    if explained < EXPLAINED:
        return (
            f"the joints explain only {max(explained, 0):.0%} of the gyroscope's variance: the "
            "arm hardly turned, the IMU is rotated, or its file belongs to another recording"
        )
    if abs(apart) > TRUST * stamps.offset_std or abs(drift) > MAX_DRIFT:
        return (
            f"the gyroscope implies a start {apart:+.2f} s from the start stamps and a drift of "
            f"{drift:+.2%}, which is implausible: its file may belong to another recording"
        )
    if clock.offset_std > stamps.offset_std:
        return (
            f"the gyroscope determines the offset to ±{clock.offset_std:.2g} s, no better than "
            f"the start stamps (±{stamps.offset_std:.2g} s)"
        )
    return None
