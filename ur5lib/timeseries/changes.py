"""Changes of a quantity from date to date: slow drifts, and jumps.

A value y of date t, with the standard error s, is a constant, plus an effect of a covariate x such
as the temperature, plus changes: c x + Σ d f(t), where f is t for a drift and 0 before, 1 after a
jump. Changes are found one by one by the largest F among all of them. Its distribution without any
change depends on the dates and the weights alone; it is simulated, so that the chance of a false
change is the stated one although many jumps were tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from ur5lib.timeseries.arrays import Array, Labels

FEWEST = 6  # dates: a constant, a covariate and a change leave three degrees of freedom
BESIDE = 2  # dates on either side of a jump, at least: one alone may be an outlier
MOST = 3  # changes of one series
DRAWS = 20_000
COVERED = 0.95
MEDIAN_CHI2 = 0.4549  # of one degree of freedom
LEAST = 1e-12  # of what is divided by, beside its scale
APART = 1e-6  # share of a change that the covariate leaves, above which both can be told apart


@dataclass(frozen=True)
class Series:
    """A quantity on n dates, (n,) each.

    day: ascending, in days; value; std_error: of each value on its own date; covariate: None where
    it is unknown. The variation from date to date is estimated.
    """

    day: Array
    value: Array
    std_error: Array
    covariate: Array | None = None


@dataclass(frozen=True)
class Change:
    """A change of a series.

    kind: drift, evenly between the days `first` and `last`, or jump, at some time between them
    (95 %); before: the value on the first date; size: of the change, with its standard error and
    95 % interval (low, high); explained: what the covariate contributed in the same time, in the
    same unit; chance: of a change as clear as this without any.
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
class _Problem:
    """A series as columns of a regression, multiplied by the square root of the weights.

    base: (n, P), of the constant and the covariate; tried: (n, K), of a drift and of every jump;
    value: (n,); after: (K - 1,), the first date after each jump.
    """

    base: Array
    tried: Array
    value: Array
    after: Labels

    @classmethod
    def of(cls, series: Series) -> "_Problem":
        variance = series.std_error**2 + variation(series.value, series.std_error)
        root = 1 / np.sqrt(np.maximum(variance, LEAST * np.mean(series.value**2)))[:, None]
        base = [np.ones_like(series.day)]
        if series.covariate is not None and np.ptp(series.covariate) > 0:
            base.append(series.covariate - series.covariate.mean())
        date = np.arange(len(series.day))
        after = date[BESIDE : len(date) - BESIDE + 1]
        drift = (series.day - series.day[0]) / np.ptp(series.day)
        tried = np.column_stack([drift, date[:, None] >= after])
        return cls(root * np.stack(base, axis=1), root * tried, root[:, 0] * series.value, after)

    def columns(self, chosen: Sequence[int]) -> Array:
        """Return the columns (n, P + C) of the constant, the covariate and chosen changes."""
        return np.column_stack([self.base, self.tried[:, chosen]])


def find_changes(series: Series, level: float, seed: int = 0) -> list[Change]:
    """Return the changes of a series, the clearest first.

    level: chance of any false change. With fewer than FEWEST dates, there are none.
    """
    if len(series.day) < FEWEST:
        return []
    problem = _Problem.of(series)
    noise = np.random.default_rng(seed).standard_normal((DRAWS, len(series.day)))
    chosen, chances = list[int](), list[float]()
    while len(chosen) < min(MOST, len(series.day) - FEWEST + 1):
        fixed = problem.columns(chosen)
        share = explained_shares(fixed, problem.tried, problem.value[None])[0]
        by_chance = explained_shares(fixed, problem.tried, noise).max(axis=1)
        chance = float((1 + (by_chance >= share.max()).sum()) / (1 + DRAWS))
        if chance > level:
            break
        chosen.append(_likeliest(share, len(series.day) - fixed.shape[1] - 1))
        chances.append(chance)
    return [_change(series, problem, chosen, *pair) for pair in enumerate(chances)]


def explained_shares(fixed: Array, tried: Array, values: Array) -> Array:
    """Return what each further column explains of the variance that others leave, (B, K).

    fixed: (n, P); tried: (n, K), one of which is added; values: (B, n). F = share / (1 - share)
    times the degrees of freedom. A column that hardly differs from the fixed ones explains nothing.
    """
    basis = np.linalg.qr(fixed)[0]
    rest = tried - basis @ (basis.T @ tried)
    norm = (rest**2).sum(axis=0)
    differs = norm > APART * (tried**2).sum(axis=0)
    unit = np.where(differs, rest, 0.0) / np.sqrt(np.where(differs, norm, 1.0))
    left = values - (values @ basis) @ basis.T
    total = np.maximum((left**2).sum(axis=1, keepdims=True), LEAST)
    shares: Array = (left @ unit) ** 2 / total
    return shares


def variation(value: Array, std_error: Array) -> float:
    """Return the variance from date to date beyond the standard errors; value, std_error: (n,).

    From the median of squared successive differences, d² = (s₁² + s₂² + 2 σ²) χ²₁: neither a slow
    drift nor a few jumps add to it.
    """
    difference = np.median(np.diff(value) ** 2) / MEDIAN_CHI2
    return float(max(0.0, difference / 2 - np.median(std_error**2)))


def _likeliest(share: Array, freedom: int) -> int:
    """Return the place of the likeliest change: a drift, or else the best jump.

    Beforehand, a drift is as likely as a jump, on any date alike.
    """
    odds = _odds(share, freedom)
    return 0 if odds[0] > odds[1:].mean() else 1 + int(share[1:].argmax())


def _odds(share: Array, freedom: int) -> Array:
    """Return the likelihood of each change, relative to that of the best; share: (K,).

    p ∝ (residual sum of squares)^(-degrees of freedom / 2).
    """
    left = np.maximum(1 - share, LEAST)
    odds: Array = (left / left.min()) ** (-freedom / 2)
    return odds


def _change(
    series: Series, problem: _Problem, chosen: Sequence[int], place: int, chance: float
) -> Change:
    """Return one of the chosen changes, with its size beside all others."""
    columns = problem.columns(chosen)
    value, std_error, freedom = _least_squares(columns, problem.value)
    own = problem.base.shape[1] + place
    half = std_error[own] * float(stdtrit(freedom, 0.5 + COVERED / 2))
    is_drift = chosen[place] == 0
    when = (0, len(series.day) - 1) if is_drift else _jump_dates(problem, chosen, place)
    effect = value[1] if problem.base.shape[1] > 1 else 0.0
    return Change(
        kind="drift" if is_drift else "jump",
        first=float(series.day[when[0]]),
        last=float(series.day[when[1]]),
        before=float(value[0]),
        size=float(value[own]),
        std_error=float(std_error[own]),
        low=float(value[own] - half),
        high=float(value[own] + half),
        explained=float(effect * _covariate_change(series, problem, chosen[place])),
        chance=chance,
    )


def _least_squares(columns: Array, value: Array) -> tuple[Array, Array, int]:
    """Return coefficients (P,), their standard errors from the residuals, degrees of freedom."""
    coefficients = np.asarray(np.linalg.lstsq(columns, value)[0], dtype=np.float64)
    freedom = len(value) - columns.shape[1]
    variance = np.sum((value - columns @ coefficients) ** 2) / freedom
    std_error: Array = np.sqrt(variance * np.diag(np.linalg.inv(columns.T @ columns)))
    return coefficients, std_error, freedom


def _jump_dates(problem: _Problem, chosen: Sequence[int], place: int) -> tuple[int, int]:
    """Return the dates between which a jump lies with a probability of COVERED, as indices.

    Beforehand, every date is as likely.
    """
    others = [number for i, number in enumerate(chosen) if i != place]
    fixed = problem.columns(others)
    share = explained_shares(fixed, problem.tried[:, 1:], problem.value[None])[0]
    odds = _odds(share, len(problem.value) - fixed.shape[1] - 1)
    order = np.argsort(-odds)
    total = np.cumsum(odds[order]) / odds.sum()
    kept = problem.after[order[: int(np.searchsorted(total, COVERED)) + 1]]
    return int(kept.min()) - 1, int(kept.max())


def _covariate_change(series: Series, problem: _Problem, change: int) -> float:
    """Return by how much the covariate rose while the series changed."""
    if series.covariate is None:
        return 0.0
    if change == 0:
        return float(np.polyfit(series.day, series.covariate, 1)[0] * np.ptp(series.day))
    first = problem.after[change - 1]
    return float(series.covariate[first:].mean() - series.covariate[:first].mean())
