"""Derivative and interpolation of several columns at once."""

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels

# Samples this many periods of the cut-off apart contain all of a low-passed signal.
STEP_IN_PERIODS = 0.064


def thinning(period: float, cutoff: float) -> int:
    """Return the stride at which samples of low-passed values are used.

    period: [s]; cutoff: of the low-pass [Hz].
    """
    return max(1, round(STEP_IN_PERIODS / cutoff / period))


def differentiate(values: Array, period: float) -> Array:
    """Return the derivative of uniform samples by central differences, one-sided at the ends.

    values: (N, M); period: [s]. Returns (N, M); NaN where there are fewer than two samples.
    """
    if len(values) < 2:
        return np.full_like(values, np.nan)
    return np.gradient(values, period, axis=0)


def interpolated(
    at: Array | Labels, places: Array | Labels, values: Array, outside: float | None = None
) -> Array:
    """Return values (N, M) at ascending `places` (N,) interpolated linearly at `at` (K,).

    outside: value beyond both ends; None: the values of the ends.
    """
    columns = [np.interp(at, places, column, outside, outside) for column in values.T]
    return np.stack(columns, axis=1)


def monotone(at: Array | Labels, places: Array, values: Array) -> Array:
    """Return values (N, M) at ascending `places` (N,) interpolated at `at` (K,) by cubics that
    leave no two neighbours' range.

    Fritsch and Butland, https://doi.org/10.1137/0905021, to the bit as `PchipInterpolator` of
    scipy, whose module takes longer to load than a recording to read.
    """
    steps = np.diff(places)[:, None]
    slopes = np.diff(values, axis=0) / steps
    rates = _monotone_rates(steps, slopes)
    k = np.clip(np.searchsorted(places, at, side="right") - 1, 0, len(steps) - 1)
    x, step, slope, rate = (at - places[k])[:, None], steps[k], slopes[k], rates[k]
    bend = (rate + rates[k + 1] - 2 * slope) / step
    result: Array = values[k] + rate * x + ((slope - rate) / step - bend) * (x * x)
    return result + bend / step * (x * x * x)


def _monotone_rates(steps: Array, slopes: Array) -> Array:
    """Return the derivatives (N, M) at samples: harmonic means of the slopes on both sides."""
    if len(slopes) == 1:
        return np.repeat(slopes, 2, axis=0)
    before, after = slopes[:-1], slopes[1:]
    of_before, of_after = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (of_before / before + of_after / after) / (of_before + of_after)
        inner = np.where(np.sign(before) * np.sign(after) > 0, 1.0 / mean, 0.0)
    first, last = _end_rate(steps, slopes), _end_rate(steps[::-1], slopes[::-1])
    return np.concatenate([first[None], inner, last[None]])


def _end_rate(steps: Array, slopes: Array) -> Array:
    """Return the derivative (M,) at the first sample, by two slopes, of the first one's sign."""
    (step, next_step), (slope, next_slope) = steps[:2], slopes[:2]
    rate = ((2 * step + next_step) * slope - step * next_slope) / (step + next_step)
    steep = (np.sign(slope) != np.sign(next_slope)) & (np.abs(rate) > 3.0 * np.abs(slope))
    within = np.where(steep, 3.0 * slope, rate)
    return np.where(np.sign(rate) != np.sign(slope), 0.0, within)
