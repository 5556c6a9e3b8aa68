"""Changes of a quantity from date to date: slow drifts, and jumps.

A value of date t is y = a + c x + Σ d f(t): a constant a of its group, such as the path that was
recorded; an effect c of a covariate x, such as the temperature; and changes of size d. The shape f
rises evenly from 0 to 1 for a drift, and is 0 before and 1 after a jump. A change that comes
together with another group or covariate cannot be separated from it.

Changes are added one by one, each the one with the largest F statistic of all candidates. Without
any change, the distribution of that F depends on the dates and the weights alone. It is simulated,
so that the chance of a false change is the stated one although many jumps are tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from ur5lib.timeseries.arrays import Array, Labels

FREEDOM = 3  # smallest degrees of freedom of the residuals
FEWEST = FREEDOM + 3  # dates: for a constant, a covariate and a change
BESIDE = 2  # fewest dates on either side of a jump: one alone may be an outlier
MOST = 3  # changes of one series
DRAWS = 20_000
COVERED = 0.95
MEDIAN_CHI2 = 0.4549  # of one degree of freedom
LEAST = 1e-12  # smallest divisor, relative to its scale
SAME = 1e-9  # range of a covariate within the groups, up to which they explain it
APART = 1e-6  # share of a change that the other columns leave, above which they are separable


@dataclass(frozen=True)
class Series:
    """A quantity on n dates, all arrays (n,).

    day: the dates, ascending, in days; value, std_error: in any unit, the error being that within
    the date (the variation from date to date is estimated); covariate: None if it is unknown;
    group: labels; dates of different groups may differ systematically; None for one group.
    """

    day: Array
    value: Array
    std_error: Array
    covariate: Array | None = None
    group: Labels | None = None


@dataclass(frozen=True)
class Change:
    """A change of a series, in the unit of its values.

    kind: a drift rises evenly from the day `first` to the day `last`; a jump happened at some time
    between them, with a probability of 95 %; before: the value on the first date, mean of all
    groups; size: of the change, with std_error and 95 % interval (low, high); explained: what the
    covariate contributed in the same time; chance: the probability that noise alone shows a change
    as clear as this one.
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
    """A series as a regression; each row is multiplied by the square root of its weight.

    base: (n, P), columns of the constant, the groups and the covariate; tried: (n, K), of a drift
    and of every jump; value: (n,); after: (K - 1,), the first date after each jump; adjusts:
    whether the covariate is among the base, as its last column.
    """

    base: Array
    tried: Array
    value: Array
    after: Labels
    adjusts: bool

    @classmethod
    def of(cls, series: Series) -> "_Problem":
        # stated errors are uncertain: a date with a very small one would weigh too much
        error = np.maximum(series.std_error, np.median(series.std_error))
        variance = error**2 + variation(series.value, error)
        root = 1 / np.sqrt(np.maximum(variance, LEAST * np.mean(series.value**2)))[:, None]
        groups = _indicators(series)
        base = [np.ones_like(series.day), *(groups[:, 1:] - groups[:, 1:].mean(axis=0)).T]
        if series.covariate is not None:
            within = series.covariate - groups @ np.linalg.lstsq(groups, series.covariate)[0]
            base += [within] * bool(np.ptp(within) > SAME)
        date = np.arange(len(series.day))
        after = date[BESIDE : len(date) - BESIDE + 1]
        drift = (series.day - series.day[0]) / np.ptp(series.day)
        tried = np.column_stack([drift, date[:, None] >= after])
        scaled = root * np.stack(base, axis=1), root * tried, root[:, 0] * series.value
        return cls(*scaled, after, adjusts=len(base) > groups.shape[1])

    def columns(self, chosen: Sequence[int]) -> Array:
        """Return the columns (n, P + C) of the base and of chosen changes."""
        return np.column_stack([self.base, self.tried[:, chosen]])


def find_changes(series: Series, level: float, seed: int = 0) -> list[Change]:
    """Return the changes of a series in the order in which they were found, the clearest first.

    level: the chance of any false change; seed: of the simulated noise. Returns none if there are
    fewer than FEWEST dates, or too few for the number of groups.
    """
    if len(series.day) < FEWEST:
        return []
    problem = _Problem.of(series)
    noise = np.random.default_rng(seed).standard_normal((DRAWS, len(series.day)))
    chosen, chances = list[int](), list[float]()
    while len(chosen) < MOST:
        fixed = problem.columns(chosen)
        freedom = len(series.day) - fixed.shape[1] - 1
        if freedom < FREEDOM:
            break
        share = explained_shares(fixed, problem.tried, problem.value[None])[0]
        by_chance = explained_shares(fixed, problem.tried, noise).max(axis=1)
        chance = float((1 + (by_chance >= share.max()).sum()) / (1 + DRAWS))
        if chance > level:
            break
        chosen.append(_likeliest(share, freedom))
        chances.append(chance)
    return [_change(series, problem, chosen, *pair) for pair in enumerate(chances)]


def _indicators(series: Series) -> Array:
    """Return a column for each group, (n, G), which is 1 on its dates and 0 on others.

    Groups of a single date count as one group.
    """
    if series.group is None:
        return np.ones((len(series.day), 1))
    _, place, count = np.unique(series.group, return_inverse=True, return_counts=True)
    label = np.where(count[place] > 1, place, -1)
    return (label[:, None] == np.unique(label)).astype(float)


def explained_shares(fixed: Array, tried: Array, values: Array) -> Array:
    """Return the share (B, K) of the remaining variance that each further column explains.

    fixed: (n, P), columns whose effect is removed first; tried: (n, K), of which one at a time is
    added; values: (B, n), rows to explain. F is share / (1 - share) times the degrees of freedom. A
    column that hardly differs from the fixed ones explains nothing.
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
    """Return the variance from date to date that exceeds the standard errors.

    value, std_error: (n,).

    From the median of squared successive differences, d² = (s₁² + s₂² + 2 σ²) χ²₁: neither a slow
    drift nor a few jumps add to it.
    """
    difference = np.median(np.diff(value) ** 2) / MEDIAN_CHI2
    return float(max(0.0, difference / 2 - np.median(std_error**2)))


def _likeliest(share: Array, freedom: int) -> int:
    """Return the place of the likeliest change: a drift, or else the best jump.

    A priori, a drift is as likely as a jump, and each date of a jump as likely as another.
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
    """Return one of the chosen changes, its size fitted together with all others."""
    columns = problem.columns(chosen)
    value, std_error, freedom = _least_squares(columns, problem.value)
    own = problem.base.shape[1] + place
    half = std_error[own] * float(stdtrit(freedom, 0.5 + COVERED / 2))
    is_drift = chosen[place] == 0
    when = (0, len(series.day) - 1) if is_drift else _jump_dates(problem, chosen, place)
    effect = value[problem.base.shape[1] - 1] if problem.adjusts else 0.0
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

    A priori, every date is as likely as another.
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
