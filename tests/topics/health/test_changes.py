"""Changes between dates: those that are there are found, and no others."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tests.conftest import PROJECT
from tests.house.test_benchmarks import run_benchmark
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.health.changes import (
    MIN_DATES,
    WORST_CORRELATION,
    DatedSeries,
    coloured,
    explained_shares,
    find_changes,
    over_spans,
    variance_between_dates,
    whitened,
)

DATES = 20
SPREAD = 0.02  # between dates, of a value of 1
DRIFT, JUMP, JUMPED = 0.15, 0.12, 11
LEVEL = 0.05 / 6  # of each joint


def made_up(seed: int, dates: int = DATES) -> DatedSeries:
    """A quantity that does not change but for its spread and its temperature."""
    random = np.random.default_rng(seed)
    day = np.sort(random.choice(np.arange(1.0, 90.0), dates, replace=False))
    std_error = 0.01 * np.exp(0.3 * random.standard_normal(dates))
    warmth = 30 + 3 * random.standard_normal(dates)
    noise = np.hypot(std_error, SPREAD) * random.standard_normal(dates)
    return DatedSeries(day, 1 - 0.009 * (warmth - 30) + noise, std_error, warmth)


def slow(seed: int, correlation: float) -> DatedSeries:
    """A quantity that does not change, but whose noise is correlated from date to date."""
    noise = np.random.default_rng(seed).standard_normal((1, DATES))
    value = 1 + SPREAD * coloured(noise, correlation)[0]
    return DatedSeries(3.0 * np.arange(DATES), value, np.full(DATES, 0.01))


def independent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dates are known to be independent."""
    for name in ("SEARCH_CORRELATIONS", "SIZE_CORRELATIONS"):
        monkeypatch.setattr(f"ur5lib.topics.health.changes.{name}", np.zeros(1))


def drifting(series: DatedSeries, size: float = DRIFT) -> DatedSeries:
    course = (series.day - series.day[0]) / np.ptp(series.day)
    return replace(series, value=series.value + size * course)


def jumping(series: DatedSeries, size: float = JUMP) -> DatedSeries:
    return replace(series, value=series.value + size * (series.day >= series.day[JUMPED]))


def test_drifts_and_jumps_are_told_apart_and_jumps_are_dated(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("ur5lib.topics.health.changes.NOISE_DRAWS", 2000)
    series = [(drifting(made_up(100 * seed)), jumping(made_up(seed))) for seed in range(20)]
    drifts, jumps = (
        [find_changes(own, LEVEL)[0] for own in kind] for kind in zip(*series, strict=True)
    )
    drifts = [change for change in drifts if change.kind == "drift"]
    assert len(drifts) >= 18  # dates may leave open whether it was a jump
    assert all(abs(one.before - 1) < 5 * SPREAD for one in drifts)
    assert {one.kind for one in jumps} == {"jump"}
    days = [jumping.day[JUMPED - 1 : JUMPED + 1] for _, jumping in series]
    dated = [one.first <= a and b <= one.last for one, (a, b) in zip(jumps, days, strict=True)]
    assert sum(dated) >= 17


@pytest.mark.parametrize("among_slow_noise", [False, True])
@pytest.mark.parametrize(("change", "size"), [(drifting, DRIFT), (jumping, JUMP)])
def test_intervals_hold_the_size_as_often_as_stated(
    change: Callable[[DatedSeries, float], DatedSeries],
    size: float,
    among_slow_noise: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        "ur5lib.topics.health.changes.NOISE_DRAWS", 200 if among_slow_noise else 500
    )
    if among_slow_noise:
        size, series = 0.3, [slow(seed, WORST_CORRELATION) for seed in range(100)]
    else:
        series = [made_up(seed) for seed in range(1000, 1100)]
    found = [find_changes(change(own, size), LEVEL)[0] for own in series]
    assert 90 <= sum(one.low < size < one.high for one in found) <= 99


@pytest.mark.parametrize(("correlation", "most"), [(0.0, 5), (0.5, 10)])
def test_slow_noise_makes_false_changes_on_few_arms(
    correlation: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a hundred arms of three quantities each, at most 5 % on average.

    With the slowest noise, that is the chance: more than ten have one of 1 %.
    """
    monkeypatch.setattr("ur5lib.topics.health.changes.NOISE_DRAWS", 1000)
    arms = [[slow(1000 + 3 * arm + k, correlation) for k in range(3)] for arm in range(100)]
    assert sum(any(find_changes(own, 0.05 / 3) for own in arm) for arm in arms) <= most


def test_coloured_noise_has_its_correlation_and_whitens_again() -> None:
    noise = np.random.default_rng(0).standard_normal((20_000, 6))
    slow_noise = coloured(noise, 0.4)
    powers = 0.4 ** np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    np.testing.assert_allclose(np.cov(slow_noise.T), powers, atol=0.03)
    np.testing.assert_allclose(whitened(slow_noise.T, 0.4).T, noise, atol=1e-12)


def test_what_temperature_explains_is_no_change(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred quiet series that warm up over time: at 5 %, some five false changes."""
    monkeypatch.setattr("ur5lib.topics.health.changes.NOISE_DRAWS", 1000)
    false = 0
    for seed in range(100):
        series = made_up(seed)
        warmth = series.day / 5 + series.covariate
        value = series.value - 0.009 * series.day / 5
        false += bool(find_changes(replace(series, value=value, covariate=warmth), 0.05))
    assert 0 < false <= 12


def uncertain(random: np.random.Generator) -> Array:
    """Errors (n,) of dates that are equally certain, each from one degree of freedom."""
    return np.asarray(SPREAD * np.sqrt(random.chisquare(1, DATES)))


def first_two(random: np.random.Generator) -> Array:
    """Errors (n,) of dates of which the first two are four times as uncertain as the others."""
    return np.where(np.arange(DATES) < 2, 4 * SPREAD, SPREAD)


@pytest.mark.parametrize(("stated", "known"), [(uncertain, False), (first_two, True)])
def test_errors_uncertain_or_known_make_few_false_changes(
    stated: Callable[[np.random.Generator], Array], known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 400 quiet series, at most 20 on average change falsely, and more than 29 hardly ever.

    Their noise is as slow as is guarded against. With noise that is drawn by the weights alone, 43
    of those of uncertain errors do; with equal weights, some 130 of those of known errors.
    """
    monkeypatch.setattr("ur5lib.topics.health.changes.NOISE_DRAWS", 400)
    monkeypatch.setattr("ur5lib.topics.health.changes.BATCH_DRAWS", 400)
    false = 0
    for seed in range(10_000, 10_400):
        random = np.random.default_rng(seed)
        error = stated(random)
        noise = coloured(random.standard_normal((1, DATES)), WORST_CORRELATION)[0]
        value = 1 + noise * (error if known else SPREAD)
        false += bool(find_changes(DatedSeries(np.arange(20.0), value, error), 0.05, seed))
    assert 6 <= false <= 29


@pytest.mark.parametrize("changing", [drifting, jumping])
def test_temperature_s_part_is_told_apart(
    changing: Callable[[DatedSeries, float], DatedSeries],
) -> None:
    """It warms by 6 K with the change and by some K at random; -0.9 % per kelvin."""
    series = changing(made_up(3), -0.054)
    warmth = changing(replace(series, value=series.covariate), 6.0).value
    (change,) = find_changes(changing(replace(series, covariate=warmth), 0.3), LEVEL)
    assert change.low < 0.3 < change.high
    assert change.explained == pytest.approx(-0.054, abs=0.03)


def test_a_temperature_of_each_group_explains_nothing() -> None:
    series = jumping(replace(made_up(4), group=np.arange(DATES) % 2), 2 * JUMP)
    (change,) = find_changes(replace(series, covariate=30.0 + series.group), LEVEL)
    assert change.explained == 0.0


def test_units_do_not_matter() -> None:
    """Weights, sizes and chances are those of the same series in Nm or mNm."""
    series = drifting(made_up(6))
    (one,) = find_changes(series, LEVEL)
    milli = replace(series, value=1000 * series.value, std_error=1000 * series.std_error)
    (other,) = find_changes(milli, LEVEL)
    assert (other.kind, other.chance) == (one.kind, one.chance)
    assert [other.size, other.std_error, other.before, other.explained] == pytest.approx(
        [1000 * own for own in (one.size, one.std_error, one.before, one.explained)]
    )


def test_a_drift_is_that_of_linear_regression(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where all dates weigh the same and are independent; with the t-distribution's interval."""
    independent(monkeypatch)
    series = replace(made_up(7), covariate=None, std_error=np.full(DATES, 0.01))
    series = drifting(series, 0.5)
    (change,) = find_changes(series, LEVEL)
    line, length = stats.linregress(series.day, series.value), np.ptp(series.day)
    half = line.stderr * length * stats.t.ppf(0.975, DATES - 2)
    assert [change.size, change.std_error] == pytest.approx(
        [line.slope * length, line.stderr * length]
    )
    assert [change.low, change.high] == pytest.approx([change.size - half, change.size + half])
    assert change.before == pytest.approx(line.intercept + line.slope * series.day[0])


def test_a_jump_s_dates_hold_95_percent_of_its_likelihood(monkeypatch: pytest.MonkeyPatch) -> None:
    """p ∝ S^(-(n - 2) / 2), with S the sum of squares about the means before and after."""
    independent(monkeypatch)
    monkeypatch.setattr("ur5lib.topics.health.changes.NOISE_DRAWS", 100)
    monkeypatch.setattr("ur5lib.topics.health.changes.MAX_CHANGES", 1)
    after = np.arange(2, DATES - 1)
    for seed in range(40):
        series = replace(made_up(seed), covariate=None, std_error=np.full(DATES, 0.01))
        series = jumping(series, 0.06)
        left = [_scatter(series.value[:k]) + _scatter(series.value[k:]) for k in after]
        share = (np.array(left) / min(left)) ** (-(DATES - 2) / 2)
        order = np.argsort(-share)
        count = 1 + int(np.searchsorted(np.cumsum(share[order]) / share.sum(), 0.95))
        expected = (
            series.day[after[order[:count]].min() - 1],
            series.day[after[order[:count]].max()],
        )
        found = [one for one in find_changes(series, 0.2) if one.kind == "jump"]
        assert [(one.first, one.last) for one in found] in ([], [expected])


def _scatter(value: np.ndarray) -> float:
    return float(((value - value.mean()) ** 2).sum())


@pytest.mark.parametrize("outlier", [0, -1])
def test_one_outlier_at_an_end_is_no_jump_there(outlier: int) -> None:
    series = replace(made_up(8), covariate=None)
    series.value[outlier] += 1.0
    jumps = [one for one in find_changes(series, 0.05) if one.kind == "jump"]
    assert all(series.day[1] <= one.first and one.last <= series.day[-2] for one in jumps)


def test_six_dates_tell_a_change_and_twenty_at_most_three() -> None:
    six = replace(jumping(made_up(9, 20), 1.0), covariate=None)
    six = DatedSeries(six.day[8:14], six.value[8:14], six.std_error[8:14])
    assert [one.kind for one in find_changes(six, LEVEL)] == ["jump"]
    date, many = np.arange(DATES), replace(made_up(10), covariate=None)
    steps = 100 * (date >= 10) + 20 * (date >= 5) + 4 * (date >= 15) + (date >= 17)
    assert len(find_changes(replace(many, value=many.value + steps), LEVEL)) == 3


def test_groups_hide_no_change_and_make_none() -> None:
    """Three groups in turn, far apart; then one group before a date and another one after."""
    series = replace(made_up(4), covariate=None, group=np.arange(DATES) % 3)
    apart = replace(series, value=series.value + 0.5 * series.group)
    assert find_changes(apart, LEVEL) == []
    (change,) = find_changes(jumping(apart, 2 * JUMP), LEVEL)
    assert change.low < 2 * JUMP < change.high
    assert change.before == pytest.approx(1.5, abs=0.05)
    later = np.array(series.day >= series.day[JUMPED], dtype=int)
    assert find_changes(replace(jumping(series, 0.5), group=later), LEVEL) == []
    alone = replace(jumping(series, 2 * JUMP), group=np.arange(DATES))  # each date of its own
    assert [one.kind for one in find_changes(alone, LEVEL)] == ["jump"]


def test_two_changes_of_one_series_are_both_found() -> None:
    series = replace(made_up(5), covariate=None)
    twice = jumping(drifting(series, 0.3), -0.4)
    kinds = {change.kind: change for change in find_changes(twice, LEVEL)}
    assert kinds["drift"].size == pytest.approx(0.3, abs=0.1)
    assert kinds["jump"].size == pytest.approx(-0.4, abs=0.1)


def test_few_dates_tell_no_change() -> None:
    few = made_up(1, MIN_DATES - 1)
    assert find_changes(replace(few, value=few.day), 0.5) == []


def test_values_without_any_spread_have_no_change_but_the_true_one() -> None:
    flat = replace(made_up(1), value=np.ones(DATES), std_error=np.zeros(DATES), covariate=None)
    assert find_changes(flat, LEVEL) == []
    (change,) = find_changes(jumping(flat), LEVEL)
    assert (change.kind, change.size) == ("jump", pytest.approx(JUMP))


@pytest.mark.parametrize("groups", [False, True])
def test_a_change_needs_three_degrees_of_freedom_beside_it(groups: bool) -> None:
    """Six dates less a constant, a covariate and a change leave three; two groups, one less."""
    random, day = np.random.default_rng(4), np.arange(6.0)
    value = np.where(day < 3, 0.0, 10.0) + 0.01 * random.standard_normal(6)
    group = np.array([0, 1, 0, 1, 0, 1]) if groups else None
    series = DatedSeries(day, value, np.full(6, 0.01), random.standard_normal(6), group)
    assert len(find_changes(series, LEVEL)) == (not groups)


def test_what_a_jump_owes_to_the_covariate_is_by_its_means_before_and_after() -> None:
    random, day = np.random.default_rng(5), np.arange(20.0)
    warmth = np.where(day < 12, 0.0, 5.0) + random.standard_normal(20)
    value = 0.3 * warmth + np.where(day < 12, 0.0, 10.0) + 0.01 * random.standard_normal(20)
    (change,) = find_changes(DatedSeries(day, value, np.full(20, 0.01), warmth), LEVEL)
    assert change.size == pytest.approx(10.0, rel=0.01)
    rise = warmth[12:].mean() - warmth[:12].mean()
    assert change.explained == pytest.approx(0.3 * rise, rel=0.02)


def test_the_variation_is_what_the_errors_leave() -> None:
    value, ones = np.random.default_rng(0).normal(0, 2, 5000), np.ones(5000)
    assert variance_between_dates(value, ones) == pytest.approx(2**2 - 1, rel=0.1)
    assert variance_between_dates(value, 3 * ones) == 0


def test_neither_drift_nor_jump_adds_to_the_variation() -> None:
    """A median over twenty dates scatters itself: the mean over seeds counts."""
    series = [replace(made_up(seed), covariate=None) for seed in range(100)]
    plain, changed = (
        np.mean([variance_between_dates(own.value, own.std_error) for own in some])
        for some in (series, [jumping(drifting(own)) for own in series])
    )
    assert changed == pytest.approx(plain, rel=0.25)


def test_shares_are_those_of_least_squares() -> None:
    random = np.random.default_rng(0)
    fixed, tried, value = (random.standard_normal((12, k)) for k in (2, 3, 1))
    share = explained_shares(fixed, np.column_stack([tried, fixed[:, 0]]), value.T)[0]

    def left(columns: np.ndarray) -> float:
        return float(np.linalg.lstsq(columns, value)[1][0])

    for k in range(3):
        both = np.column_stack([fixed, tried[:, k]])
        assert share[k] == pytest.approx(1 - left(both) / left(fixed))
    assert share[3] == 0.0  # nothing new


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e3, 1e9])
def test_shares_do_not_depend_on_the_units_of_the_columns(unit: float) -> None:
    random = np.random.default_rng(0)
    fixed, tried, value = (random.standard_normal((12, k)) for k in (2, 3, 1))
    expected = explained_shares(fixed, tried, value.T)
    np.testing.assert_allclose(explained_shares(fixed, unit * tried, value.T), expected)


# Of hundreds of dates


def two_years(seed: int, size: float) -> DatedSeries:
    """A run each day, along one of three paths in turn; a change within the 14th of 24 months."""
    random, day = np.random.default_rng(seed), np.arange(730.0)
    group, warmth = np.arange(730) % 3, 30 - 4 * np.cos(2 * np.pi * day / 365)
    worn = np.interp(day / 730, [13 / 24, 14 / 24], [0.0, size])
    value = 1 + 0.1 * group - 0.009 * (warmth - 30) + worn + SPREAD * random.standard_normal(730)
    return DatedSeries(day, value, np.full(730, 0.01), warmth, group)


def test_a_change_in_two_years_is_found_with_its_month() -> None:
    (found,) = find_changes(over_spans(two_years(1, size=0.05)), LEVEL)
    assert found.kind == "jump"
    assert found.low < 0.05 < found.high
    assert 12 / 24 < found.first / 730 < found.last / 730 < 15 / 24
    assert found.first < 14 / 24 * 730
    assert found.last > 13 / 24 * 730


def test_two_years_without_a_change_show_none() -> None:
    assert not any(find_changes(over_spans(two_years(seed, 0.0)), LEVEL) for seed in range(10))


def test_few_dates_are_taken_as_they_are() -> None:
    series = made_up(0)
    assert over_spans(series) is series


@pytest.mark.thorough
@pytest.mark.slow
def test_false_changes_are_counted() -> None:
    printed = run_benchmark("false_changes", PROJECT)
    assert all(text in printed for text in ("1 seeds, 2 quantities", "| 0.5 |")), printed
