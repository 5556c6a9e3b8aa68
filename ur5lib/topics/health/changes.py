"""Changes of a quantity from date to date: slow drifts, and jumps.

A value on date t is y = a + c x + Σ d f(t): a is constant for a group of dates, such as those with
the same path; c is the effect of a covariate x, such as the temperature; d are the sizes of
changes. f rises linearly from 0 to 1 for a drift, and is 0 before and 1 after a jump. A change that
coincides with a change of group or covariate cannot be separated from it.

The residuals are correlated from date to date by a first-order autoregression,
r(t) = ρ r(t-1) + noise. Slow noise looks like a drift or a jump, and twenty dates determine ρ
poorly. Therefore every likelihood is a mean over a range of ρ, all equally likely a priori.

Changes are added one by one, each the likeliest of all candidates. A change is accepted by the
ratio of the likelihoods with and without it. Without any change, the distribution of that ratio
depends only on the dates, the weights and ρ. It is simulated with ρ = WORST_CORRELATION, for which
large ratios are most frequent, and twice: with noise according to the weights, and with equal noise
on all dates, since weights are estimates. So the chance of a false change is at most the stated
one, although many jumps are tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.signal import lfilter
from scipy.special import stdtrit

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import BAND_COVERAGE

MIN_DEGREES_OF_FREEDOM = 3  # of the residuals
MIN_DATES = MIN_DEGREES_OF_FREEDOM + 3  # a constant, a covariate and a change take this many
FALSE_ALARM_PROBABILITY = 0.05  # chance of any false change on an arm, at most
MIN_DATES_BESIDE_JUMP = 2  # a jump has this many on either side: one alone may be an outlier
MAX_CHANGES = 3  # of one series
# A series of more dates is averaged over this many spans; with 2 years, each takes 12 days.
MAX_SINGLE_DATES = 120
SPAN_COUNT = 60
# The chance of a false change is as stated up to this correlation of neighbouring dates.
WORST_CORRELATION = 0.5
SEARCH_CORRELATIONS = np.linspace(0.0, WORST_CORRELATION, 6)  # ρ of the search for changes
# ρ for the sizes of changes, larger: residuals look less correlated than the noise is.
SIZE_CORRELATIONS = np.linspace(0.0, 0.75, 6)
NOISE_DRAWS = 20_000  # simulated series in all
BATCH_DRAWS = 1_000  # simulated series at a time
MEDIAN_CHI2 = 0.4549  # median of χ² with one degree of freedom
MIN_RELATIVE_DIVISOR = 1e-12  # least divisor, relative to the dividend's scale
MAX_CONSTANT_RANGE = 1e-9  # a covariate with a smaller range within the groups counts as constant
MIN_UNEXPLAINED_SHARE = 1e-6  # a change's column is tried if the others leave this share of it


@dataclass(frozen=True)
class DatedSeries:
    """A quantity on n dates, all arrays (n,).

    day: the dates, ascending, in days; value, std_error: in any unit; std_error is the error within
    a date, the variation from date to date is estimated; covariate: another quantity that may
    explain changes, such as the temperature, None if unknown; group: labels; dates of different
    groups may differ systematically; None for one group.
    """

    day: Array
    value: Array
    std_error: Array
    covariate: Array | None = None
    group: Labels | None = None


@dataclass(frozen=True)
class Change:
    """A change of a series, in the unit of its values.

    kind: a drift rises linearly from the day `first` to the day `last`; a jump lies between them
    with a probability of 95 %; before: the value on the first date, mean of all groups; size: with
    std_error and 95 % interval (low, high); explained: the covariate's contribution in the same
    time; chance: p-value, the probability of a change as clear as this one by noise alone.
    """

    kind: Literal["drift", "jump"]
    first: float
    last: float
    before: float
    size: float
    std_error: float
    low: float
    high: float
    explained: float
    chance: float


@dataclass(frozen=True)
class _ChangeRegression:
    """A series as a weighted regression; each row is multiplied by √weight.

    base: (n, P), columns of the constant (√weight), the groups and the covariate; tried: (n, K),
    columns of a drift and of every jump; value: (n,); after: (K - 1,), index of the first date
    after each jump; adjusts: whether the last column of the base is the covariate.
    """

    base: Array
    tried: Array
    value: Array
    after: Labels
    adjusts: bool

    @classmethod
    def from_series(cls, series: DatedSeries) -> "_ChangeRegression":
        # Standard errors are estimates: a date with a very small one would weigh too much.
        error = np.maximum(series.std_error, np.median(series.std_error))
        variance = error**2 + variance_between_dates(series.value, error)
        root = (
            1
            / np.sqrt(np.maximum(variance, MIN_RELATIVE_DIVISOR * np.mean(series.value**2)))[
                :, None
            ]
        )
        groups = _indicators(series)
        base = [np.ones_like(series.day), *(groups[:, 1:] - groups[:, 1:].mean(axis=0)).T]
        if series.covariate is not None:
            within = series.covariate - groups @ np.linalg.lstsq(groups, series.covariate)[0]
            base += [within] * bool(np.ptp(within) > MAX_CONSTANT_RANGE)
        date = np.arange(len(series.day))
        after = date[MIN_DATES_BESIDE_JUMP : len(date) - MIN_DATES_BESIDE_JUMP + 1]
        drift = (series.day - series.day[0]) / np.ptp(series.day)
        tried = np.column_stack([drift, date[:, None] >= after])
        scaled = root * np.stack(base, axis=1), root * tried, root[:, 0] * series.value
        return cls(*scaled, after, adjusts=len(base) > groups.shape[1])

    def columns(self, chosen: Sequence[int]) -> Array:
        """Return the columns (n, P + C) of the base and of chosen changes."""
        return np.column_stack([self.base, self.tried[:, chosen]])


def over_spans(series: DatedSeries) -> DatedSeries:
    """Return the means of a series of many dates over SPAN_COUNT successive spans.

    A series of at most MAX_SINGLE_DATES dates stays as it is. Fitted model: value = constant of its
    group + mean of its span. Standard errors are the larger of two: by the stated ones, and by the
    scatter within the span. Simulating the noise of all dates would take minutes, and a change need
    not be dated to the day.
    """
    if len(series.day) <= MAX_SINGLE_DATES:
        return series
    span = np.arange(len(series.day)) * SPAN_COUNT // len(series.day)
    which = (span[:, None] == np.arange(SPAN_COUNT)).astype(float)
    root = 1 / np.maximum(series.std_error, np.median(series.std_error))[:, None]
    groups = _indicators(series)
    groups = groups[:, 1:] - groups[:, 1:].mean(axis=0)
    columns = root * np.hstack([which, groups])
    coefficients = np.linalg.lstsq(columns, root[:, 0] * series.value)[0]
    residual = root[:, 0] * series.value - columns @ coefficients
    # Σ 1 / σ² of each span
    weight = which.T @ root[:, 0] ** 2
    scatter = which.T @ residual**2 / np.maximum(which.sum(axis=0) - 1, 1)
    mean = which.T / which.sum(axis=0)[:, None]
    warmth = None if series.covariate is None else mean @ series.covariate
    error = np.sqrt(np.maximum(scatter, 1.0) / weight)
    return DatedSeries(mean @ series.day, coefficients[:SPAN_COUNT], error, warmth)


def find_changes(series: DatedSeries, level: float, seed: int = 0) -> list[Change]:
    """Return the changes of a series in the order in which they were found, the clearest first.

    level: largest chance of any false change; seed: of the simulated noise. Returns [] if there are
    fewer than MIN_DATES dates, or too few for the number of groups.
    """
    if len(series.day) < MIN_DATES:
        return []
    problem = _ChangeRegression.from_series(series)
    noise = _worst_noise(seed, NOISE_DRAWS, len(series.day))
    chosen, chances = list[int](), list[float]()
    while len(chosen) < MAX_CHANGES:
        if len(series.day) - problem.columns(chosen).shape[1] - 1 < MIN_DEGREES_OF_FREEDOM:
            break
        odds = _log_odds(problem, chosen, problem.value[None])
        chance = _chance(problem, chosen, _any_change(odds)[0], noise, level)
        if chance > level:
            break
        chosen.append(_likeliest_change(odds[0]))
        chances.append(chance)
    return [_change(series, problem, chosen, *pair) for pair in enumerate(chances)]


@lru_cache(1)
def _worst_noise(seed: int, draws: int, dates: int) -> Array:
    """Return noise (draws, dates) with ρ = WORST_CORRELATION; cached: an arm's series share it."""
    noise = np.random.default_rng(seed).standard_normal((draws, dates))
    return coloured(noise, WORST_CORRELATION)


def coloured(noise: Array, correlation: float) -> Array:
    """Return independent noise (B, n) turned into a first-order autoregression along its rows.

    The variance stays the same. correlation: ρ of neighbours.
    """
    result = np.sqrt(1 - correlation**2) * noise
    result[:, 0] = noise[:, 0]
    return np.asarray(lfilter([1.0], [1.0, -correlation], result, axis=1))


def whitened(rows: Array, correlation: float) -> Array:
    """Return rows (n, ...) with the correlation of neighbours removed: inverse of `coloured`."""
    result = rows.astype(float)
    result[1:] -= correlation * rows[:-1]
    result[1:] /= np.sqrt(1 - correlation**2)
    return result


def _chance(
    problem: _ChangeRegression, chosen: Sequence[int], observed: float, noise: Array, level: float
) -> float:
    """Return the chance that noise (B, n) alone gives log odds of a further change ≥ `observed`.

    The returned chance is the larger of two: with noise according to the weights, and with equal
    noise on all dates. The simulation stops once the chance exceeds the level.
    """
    alike = noise * problem.base[:, 0]
    above = np.ones(2)
    for first in range(0, len(noise), BATCH_DRAWS):
        for kind, drawn in enumerate((noise, alike)):
            odds = _log_odds(problem, chosen, drawn[first : first + BATCH_DRAWS])
            above[kind] += (_any_change(odds) >= observed).sum()
        if above.max() > level * (1 + len(noise)):
            break
    return float(above.max()) / (1 + len(noise))


def _log_odds(problem: _ChangeRegression, chosen: Sequence[int], values: Array) -> Array:
    """Return log odds (B, K) of each further change against none, for values (B, n).

    Both likelihoods are means over SEARCH_CORRELATIONS, and integrals over coefficients and
    variance.
    """
    none, changed = list[Array](), list[Array]()
    for correlation in SEARCH_CORRELATIONS:
        fixed, tried = (
            whitened(part, correlation) for part in (problem.columns(chosen), problem.tried)
        )
        rows = whitened(values.T, correlation).T
        none.append(_log_likelihood(fixed, rows, correlation))
        residual = np.maximum(1 - explained_shares(fixed, tried, rows), MIN_RELATIVE_DIVISOR)
        freedom = len(fixed) - fixed.shape[1] - 1
        changed.append(none[-1][:, None] - freedom / 2 * np.log(residual))
    return _log_sum(np.stack(changed)) - _log_sum(np.stack(none))[:, None]


def _log_sum(logarithms: Array) -> Array:
    """Return log Σ exp(logarithms) over the first axis, (N, ...) to (...).

    Ten times as fast as `numpy.logaddexp.reduce`, which would dominate the simulation.
    """
    highest = logarithms.max(axis=0)
    return np.asarray(highest + np.log(np.exp(logarithms - highest).sum(axis=0)))


def _log_likelihood(columns: Array, rows: Array, correlation: float) -> Array:
    """Return the restricted log likelihoods (B,) of whitened rows (B, n), up to a constant.

    p ∝ (1 - ρ²)^(-(n-1)/2) |XᵀX|^(-1/2) S^(-ν/2), with X the whitened columns (n, P), S the
    residual sum of squares and ν = n - P (Harville 1974).
    """
    basis, triangle = np.linalg.qr(columns)
    residual = np.maximum(
        (rows**2).sum(axis=1) - ((rows @ basis) ** 2).sum(axis=1), MIN_RELATIVE_DIVISOR
    )
    size, count = columns.shape
    # log (1 - ρ²)^((n-1)/2) |XᵀX|^(1/2), with |XᵀX|^(1/2) = |R|
    volume = (size - 1) / 2 * np.log(1 - correlation**2) + np.log(abs(np.diag(triangle))).sum()
    result: Array = -volume - (size - count) / 2 * np.log(residual)
    return result


def _any_change(log_odds: Array) -> Array:
    """Return log odds (B,) of a change of any kind against none; see `_likeliest_change` for the
    prior.
    """
    jumps = _log_sum(log_odds[:, 1:].T) - np.log(log_odds.shape[1] - 1)
    return np.asarray(np.logaddexp(log_odds[:, 0], jumps))


def _indicators(series: DatedSeries) -> Array:
    """Return indicator columns (n, G) of the groups: 1 on a group's dates, 0 on others.

    All groups of a single date form one group.
    """
    if series.group is None:
        return np.ones((len(series.day), 1))
    _, place, count = np.unique(series.group, return_inverse=True, return_counts=True)
    label = np.where(count[place] > 1, place, -1)
    return (label[:, None] == np.unique(label)).astype(float)


def explained_shares(fixed: Array, tried: Array, values: Array) -> Array:
    """Return the share (B, K) of the residual variance that each tried column explains.

    fixed: (n, P), columns fitted first; tried: (n, K), added one at a time; values: (B, n).
    F = share / (1 - share) times the degrees of freedom. A column that is almost a linear
    combination of the fixed ones explains 0.
    """
    basis = np.linalg.qr(fixed)[0]
    remaining = tried - basis @ (basis.T @ tried)
    norm = (remaining**2).sum(axis=0)
    differs = norm > MIN_UNEXPLAINED_SHARE * (tried**2).sum(axis=0)
    unit = np.where(differs, remaining, 0.0) / np.sqrt(np.where(differs, norm, 1.0))
    residual = values - (values @ basis) @ basis.T
    total = np.maximum((residual**2).sum(axis=1, keepdims=True), MIN_RELATIVE_DIVISOR)
    shares: Array = (residual @ unit) ** 2 / total
    return shares


def variance_between_dates(value: Array, std_error: Array) -> float:
    """Return the variance σ² from date to date in excess of the standard errors s.

    value, std_error: (n,).

    The median of squared successive differences, d² = (s₁² + s₂² + 2 σ²) χ²₁, determines it: a slow
    drift or a few jumps do not affect this median.
    """
    # median of d² = (2 s² + 2 σ²) median of χ²₁
    difference = np.median(np.diff(value) ** 2) / MEDIAN_CHI2
    return float(max(0.0, difference / 2 - np.median(std_error**2)))


def _likeliest_change(log_odds: Array) -> int:
    """Return the index of the likeliest change, the drift or the best jump; log_odds: (K,).

    Prior: a drift is as likely as a jump, and all dates of a jump are equally likely.
    """
    odds = np.exp(log_odds - log_odds.max())
    return 0 if odds[0] > odds[1:].mean() else 1 + int(odds[1:].argmax())


def _change(
    series: DatedSeries,
    problem: _ChangeRegression,
    chosen: Sequence[int],
    place: int,
    chance: float,
) -> Change:
    """Return the change with index `chosen[place]`; the sizes of all chosen changes are fitted
    together.
    """
    columns = problem.columns(chosen)
    value, std_error, freedom = _generalised_least_squares(columns, problem.value)
    column = problem.base.shape[1] + place
    # Student's t with the residuals' degrees of freedom
    half = std_error[column] * float(stdtrit(freedom, 0.5 + BAND_COVERAGE / 2))
    is_drift = chosen[place] == 0
    when = (0, len(series.day) - 1) if is_drift else _jump_dates(problem, chosen, place)
    effect = value[problem.base.shape[1] - 1] if problem.adjusts else 0.0
    return Change(
        kind="drift" if is_drift else "jump",
        first=float(series.day[when[0]]),
        last=float(series.day[when[1]]),
        before=float(value[0]),
        size=float(value[column]),
        std_error=float(std_error[column]),
        low=float(value[column] - half),
        high=float(value[column] + half),
        explained=float(effect * _covariate_change(series, problem, chosen[place])),
        chance=chance,
    )


def _generalised_least_squares(columns: Array, value: Array) -> tuple[Array, Array, int]:
    """Return coefficients (P,), their standard errors (P,) from the residuals, degrees of freedom.

    Means over ρ in SIZE_CORRELATIONS, weighted by likelihood; the standard errors include the
    variance of the coefficients over ρ.
    """
    fits, freedom = [], len(value) - columns.shape[1]
    for correlation in SIZE_CORRELATIONS:
        X, y = whitened(columns, correlation), whitened(value, correlation)
        solution = np.linalg.lstsq(X, y)[0]
        variance = np.sum((y - X @ solution) ** 2) / freedom * np.diag(np.linalg.inv(X.T @ X))
        fits.append((_log_likelihood(X, y[None], correlation)[0], solution, variance))
    likelihoods, coefficients, variances = map(np.array, zip(*fits, strict=True))
    weight = np.exp(likelihoods - np.logaddexp.reduce(likelihoods))
    mean = weight @ coefficients
    variance = weight @ (variances + (coefficients - mean) ** 2)
    return mean, np.sqrt(variance), freedom


def _jump_dates(problem: _ChangeRegression, chosen: Sequence[int], place: int) -> tuple[int, int]:
    """Return the indices of the dates between which a jump lies with probability BAND_COVERAGE.

    Prior: all dates are equally likely.
    """
    others = [number for i, number in enumerate(chosen) if i != place]
    log_odds = _log_odds(problem, others, problem.value[None])[0, 1:]
    odds = np.exp(log_odds - log_odds.max())
    order = np.argsort(-odds)
    total = np.cumsum(odds[order]) / odds.sum()
    likely_dates = problem.after[order[: int(np.searchsorted(total, BAND_COVERAGE)) + 1]]
    return int(likely_dates.min()) - 1, int(likely_dates.max())


def _covariate_change(series: DatedSeries, problem: _ChangeRegression, change: int) -> float:
    """Return the rise of the covariate during a change of the series."""
    if series.covariate is None:
        return 0.0
    if change == 0:
        return float(np.polyfit(series.day, series.covariate, 1)[0] * np.ptp(series.day))
    first = problem.after[change - 1]
    return float(series.covariate[first:].mean() - series.covariate[:first].mean())
