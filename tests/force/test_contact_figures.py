"""Figures of force by contact, on pushes whose errors are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5lib.force.contact_figures import (
    contact_errors,
    error_figures,
    error_parts,
    figures_by_contact,
    force_errors,
    mean_parts,
    periods,
    resampled_figures,
)
from ur5lib.force.estimators import Stated
from ur5lib.force.sensed_contact import contacts, in_contact, is_free
from ur5lib.records.contacts import ContactError
from ur5lib.timeseries.metrics import NORMAL95

PERIOD = 0.01


def pushed(count: int, height: float = 20.0) -> np.ndarray:
    """Wrenches (N, 6) of triangular pushes of a second along x, two seconds apart."""
    push = height * (1 - np.abs(np.linspace(-1, 1, 100)))
    force = np.tile(np.concatenate([np.zeros(200), push]), count)
    return np.concatenate([force, np.zeros(200)])[:, None] * np.eye(6)[0]


def norm(wrench: np.ndarray) -> np.ndarray:
    return np.linalg.norm(wrench[:, :3], axis=1)


def test_a_sample_is_in_contact_or_free_or_neither() -> None:
    force = norm(pushed(3))
    during = periods(force, PERIOD)
    assert during["all"].all()
    assert not (during["contact"] & during["free"]).any()
    assert (force[during["contact"]] > 5).all()
    assert (force[during["free"]] < 1).all()
    assert 0 < during["contact"].mean() < 1 / 3 < during["free"].mean() < 2 / 3


def test_free_samples_keep_away_from_any_touch() -> None:
    force = np.zeros(301)
    force[150] = 4.0
    np.testing.assert_array_equal(np.flatnonzero(~is_free(force, PERIOD)), np.arange(100, 201))


def test_what_the_sensor_did_not_measure_is_neither_in_contact_nor_free() -> None:
    during = periods(np.full(10, np.nan), PERIOD)
    assert not during["contact"].any()
    assert not during["free"].any()


def test_errors_in_contact_are_not_thinned_by_free_samples() -> None:
    reference = pushed(3)
    figures = figures_by_contact(0.8 * reference, None, reference, norm(reference), PERIOD)
    assert figures["contact"]["slope"][0] == pytest.approx(0.8)
    assert figures["contact"]["skill"][0] == pytest.approx(0.8)
    assert figures["contact"]["mean_force"][0] == pytest.approx(12.5, abs=0.2)
    assert figures["contact"]["mae"][0] == pytest.approx(2.5, abs=0.1)
    assert figures["free"]["mae"][0] < 0.2
    longer = np.concatenate([reference, np.zeros((5000, 6))])
    again = figures_by_contact(0.8 * longer, None, longer, norm(longer), PERIOD)
    assert again["contact"]["mae"][0] == figures["contact"]["mae"][0]
    assert again["all"]["mae"][0] < 0.5 * figures["all"]["mae"][0]


def test_a_band_that_is_right_when_free_may_be_wrong_in_contact() -> None:
    reference = pushed(3)
    std = np.full_like(reference, 0.5)
    figures = figures_by_contact(0.5 * reference, std, reference, norm(reference), PERIOD)
    assert figures["free"]["coverage95"][0] == 1
    assert figures["contact"]["coverage95"][0] == 0
    assert figures["contact"]["interval_score95"][0] > 100


def test_an_even_band_is_as_wide_as_the_estimate_errs_without_contact() -> None:
    """Nearly all of 5 N lies outside of it in contact; with no free sample, there is none."""
    reference = pushed(3)
    force, quiet = norm(reference), pushed(3) == 0
    estimate = np.where(quiet, 1.0, reference + 5.0)
    figures = figures_by_contact(estimate, None, reference, force, PERIOD)
    half = np.quantile(np.abs(estimate - reference)[is_free(force, PERIOD)], 0.95, axis=0)
    error = np.abs(estimate - reference)[in_contact(force)]
    expected = 2 * half + 40 * np.maximum(error - half, 0).mean(axis=0)
    np.testing.assert_allclose(figures["contact"]["even_interval_score95"], expected)
    touched = figures_by_contact(estimate, None, reference, np.full(len(force), 20.0), PERIOD)
    assert "even_interval_score95" not in touched["contact"]


def test_a_band_in_missed_contacts_is_judged_apart() -> None:
    """Of three contacts the first is found; the band holds the second, not the third."""
    reference = pushed(3)
    number = np.minimum(np.arange(len(reference)) // 300, 2)
    estimate = np.where(number[:, None] == 0, reference, 0.0)
    std = np.where(number == 2, 0.1, 50.0)[:, None] * np.ones(6)
    figures = figures_by_contact(estimate, std, reference, norm(reference), PERIOD)
    assert figures["missed"]["coverage95"][0] == pytest.approx(0.5, abs=0.01)
    assert figures["contact"]["coverage95"][0] == pytest.approx(2 / 3, abs=0.01)
    found = figures_by_contact(reference, std, reference, norm(reference), PERIOD)
    assert "missed" not in found


def test_without_contact_there_are_no_figures_in_contact() -> None:
    still = np.zeros((100, 6))
    figures = figures_by_contact(still, None, still, norm(still), PERIOD)
    assert set(figures) == {"all", "free"}


def test_samples_without_an_estimate_count_for_neither() -> None:
    reference = pushed(2)
    estimate = 0.8 * reference
    estimate[:300] = np.nan
    known = pytest.approx(np.abs(reference[300:, 0]).mean())
    assert figures_of(estimate, reference)["zero_mae"][0] == known
    estimate[:300], estimate[:300, 5] = reference[:300], np.nan  # not even one component
    assert figures_of(estimate, reference)["zero_mae"][0] == known
    unread = reference.copy()
    unread[:300, 2] = np.nan
    assert figures_of(0.8 * reference, unread)["zero_mae"][0] == known


def figures_of(estimate: np.ndarray, reference: np.ndarray) -> dict[str, np.ndarray]:
    """Over all samples, of contacts that the undamaged sensor tells."""
    return figures_by_contact(estimate, None, reference, norm(pushed(2)), PERIOD)["all"]


def test_skill_by_the_luck_of_one_contact_is_not_certain() -> None:
    """Nine contacts are estimated wrong by their own size and more, one is right."""
    reference = pushed(10)
    factor = np.repeat([1.0] + [-0.02] * 9 + [0], 300)[: len(reference), None]
    figures = figures_by_contact(factor * reference, None, reference, norm(reference), PERIOD)
    assert figures["contact"]["skill"][0] > 0
    assert figures["contact"]["skill_low"][0] < 0


@pytest.mark.parametrize(("count", "told"), [(2, []), (3, ["mae_low", "mae_high", "skill_low"])])
def test_three_contacts_tell_an_interval(count: int, told: list[str]) -> None:
    reference = pushed(count)
    assert [*resampled_figures(0.9 * reference, reference, norm(reference))] == told


def rows_of(estimate: np.ndarray, reference: np.ndarray) -> list[ContactError]:
    """Errors of an estimated force by contact and component."""
    time = PERIOD * np.arange(len(reference))
    return [*contact_errors("F", Stated(estimate), reference, norm(reference), time)]


@given(st.floats(0.1, 2.0))
def test_peak_and_impulse_of_a_scaled_estimate(scale: float) -> None:
    reference = pushed(4)[:, :3]
    rows = rows_of(scale * reference, reference)
    assert [row.contact for row in rows] == [number for number in range(1, 5) for _ in range(4)]
    for row in rows[::4] + rows[3::4]:  # along x, and norm
        assert row.peak == pytest.approx(20, abs=0.5)
        assert row.peak_error == pytest.approx((scale - 1) * row.peak)
        assert row.impulse == pytest.approx(10, abs=0.5)
        assert row.impulse_error == pytest.approx((scale - 1) * row.impulse)


def test_the_largest_force_is_that_before_it_is_averaged() -> None:
    """With its band along its direction; without a band or a force, there is none."""
    reference = pushed(1)[:, :3]
    sharp = 1.1 * np.roll(reference, 1, axis=1)  # along y
    std = np.tile([1.0, 2.0, 3.0, 0.0, 0.0, 0.0], (len(reference), 1))
    time, force = PERIOD * np.arange(len(reference)), norm(reference)
    stated = Stated(0.5 * pushed(1), std, None, sharp)
    (*_, whole) = contact_errors("F", stated, reference, force, time)
    assert whole.largest == pytest.approx(1.1 * whole.peak)
    assert whole.largest_band == pytest.approx(2.0 * NORMAL95)
    assert whole.peak_error == pytest.approx(-0.5 * whole.peak)
    (*_, plain) = rows_of(0.5 * reference, reference)
    assert (plain.largest, plain.largest_band) == (pytest.approx(0.5 * plain.peak), None)
    (*_, unknown) = rows_of(np.nan * reference, reference)
    assert unknown.largest is None


def test_errors_have_the_same_sign_whatever_the_pushs() -> None:
    reference = -pushed(1)[:, :3]
    (x, *_, whole) = rows_of(0.5 * reference, reference)
    assert x.peak_error == whole.peak_error < 0
    assert x.impulse_error == whole.impulse_error < 0


@pytest.mark.parametrize("late", [-20, 0, 30])
def test_the_onset_of_a_late_estimate(late: int) -> None:
    reference = pushed(3)[:, :3]
    rows = rows_of(np.roll(reference, late, axis=0), reference)
    onsets = [row.onset_error_s for row in rows if row.component == "norm"]
    np.testing.assert_allclose(onsets, late * PERIOD)


def test_an_estimate_that_feels_nothing_has_no_onset() -> None:
    reference = pushed(1)[:, :3]
    (*_, whole) = rows_of(np.zeros_like(reference), reference)
    assert whole.onset_error_s is None
    assert whole.peak_error == -whole.peak


def test_an_estimate_unknown_in_part_of_a_contact_is_not_called_too_weak() -> None:
    reference = pushed(2)[:, :3]
    estimate = reference.copy()
    estimate[230] = np.nan
    rows = [row for row in rows_of(estimate, reference) if row.component == "Fx"]
    assert [np.isnan(row.peak_error) for row in rows] == [True, False]
    assert [row.impulse > 0 for row in rows] == [True, True]


def test_a_saturated_sensor_is_no_truth() -> None:
    """It reads at most 12 N of pushes of 20 N, which the estimate shows."""
    true = pushed(3)
    limited = true.clip(max=12.0)
    force, at_limit = norm(limited), limited[:, 0] == 12.0
    reference = np.where(at_limit[:, None], np.nan, limited)
    time = PERIOD * np.arange(len(force))
    rows = contact_errors("F", Stated(true), reference[:, :3], force, time)
    for row in rows:
        assert np.isnan(row.peak_error)
        assert np.isnan(row.impulse_error)
        assert row.mae is None or row.mae == 0
        assert row.onset_error_s is None or row.onset_error_s == 0
    figures = figures_by_contact(true, None, reference, force, PERIOD)["contact"]
    assert figures["mae"][0] == figures["max"][0] == figures["mae_high"][0] == 0
    assert figures["slope"][0] == pytest.approx(1.0)


def test_a_dip_divides_contacts_and_noise_makes_none() -> None:
    force = np.array([0, 6, 1.9, 6, 0, 2.5, 0, 4, np.nan])
    assert contacts(force) == [(1, 2), (3, 4), (7, 8)]
    assert contacts(force, 5.0) == [(1, 2), (3, 4)]


def test_an_interval_of_many_contacts_is_the_normal_one() -> None:
    """Of forty contacts: 1.96 standard errors of their mean on both sides; skill from below."""
    reference = pushed(40)
    each = np.repeat(np.random.default_rng(5).uniform(0, 0.4, 41), 300)[: len(reference), None]
    touched = norm(reference) > 5
    figures = resampled_figures((1 - each) * reference, reference, norm(reference))
    errors = (each * reference)[touched, 0].reshape(40, -1).mean(axis=1)
    half = 1.96 * errors.std(ddof=1) / np.sqrt(40)
    assert figures["mae_high"][0] - figures["mae_low"][0] == pytest.approx(2 * half, rel=0.1)
    zero = reference[touched, 0].mean()
    assert figures["skill_low"][0] == pytest.approx(1 - (errors.mean() + half) / zero, rel=0.02)


def test_figures_of_a_known_error() -> None:
    """Half a newton too much throughout, of pushes up to 20 N."""
    reference = pushed(3)
    force = norm(reference)
    std = np.full_like(reference, 1.0)
    figures = figures_by_contact(reference + 0.5, std, reference, force, PERIOD)["all"]
    for name, value in {
        "mae": 0.5,
        "max": 0.5,
        "zero_mae": force.mean(),
        "mean_force": force.mean(),
        "zero_max": force.max(),
        "correlation": 1.0,
        "coverage50": 1.0,
        "coverage80": 1.0,
        "coverage95": 1.0,
        "interval_score95": 2 * NORMAL95,  # the width of the band, which holds all
        "width95": 2 * NORMAL95,
    }.items():
        assert figures[name][0] == pytest.approx(value), name
    narrow = figures_by_contact(reference + 0.5, 0.5 * std, reference, force, PERIOD)["all"]
    assert [narrow[f"coverage{stated}"][0] for stated in (50, 80, 95)] == [0, 1, 1]


def test_a_component_is_determined_where_its_skill_in_contact_is_above_zero() -> None:
    """By the lower end of its interval, where contacts tell one; in the rows of all periods."""
    mae, skill = np.ones(6), np.array([0.9, 0.5, 0.2, 0.1, 0.0, -0.3])
    figures = {
        "all": {"mae": mae, "skill": -skill},
        "contact": {"mae": 2 * mae, "skill": skill},
    }
    for low in (skill, skill - 0.15):
        figures["contact"]["skill_low"] = low
        rows = [*force_errors("compensated", "Fmap", figures)]
        assert [row.mae for row in rows] == [1.0] * 6 + [2.0] * 6
        assert [bool(row.determined) for row in rows] == 2 * (low > 0).tolist()


def test_a_gain_of_hardly_any_force_is_none() -> None:
    """From a mean of 1 N, or 0.1 Nm, on: of an estimate twice as large throughout."""
    mean = np.array([0.99, 1.01, 20.0, 0.099, 0.101, 2.0])
    reference = np.random.default_rng(1).choice([-1.0, 1.0], (500, 6)) * mean
    figures = error_figures(2 * reference, None, reference)
    np.testing.assert_allclose(figures["slope"], [np.nan, 2, 2, np.nan, 2, 2])
    np.testing.assert_allclose(figures["skill"], 0, atol=1e-9)
    forces = error_figures(2 * reference[:, :3], None, reference[:, :3])["slope"]
    np.testing.assert_allclose(forces, [np.nan, 2, 2])


def test_a_contact_is_named_by_its_first_and_last_sample() -> None:
    """It begins above 2 N and ends there, if it reaches 5 N."""
    reference = pushed(2)[:, :3]
    time = PERIOD * np.arange(len(reference))
    rows = rows_of(reference, reference)
    above = np.flatnonzero(reference[:, 0] > 2)
    first = above[above < 300]
    assert rows[0].start_s == time[first[0]]
    assert rows[0].end_s == time[first[-1]]
    assert rows[0].impulse == pytest.approx(PERIOD * reference[first, 0].sum())
    assert rows_of(0.24 * reference, 0.24 * reference) == []
    one = 6.0 * (np.arange(9) == 4)[:, None] * np.eye(3)[0]  # of a single sample: no duration
    assert rows_of(one, one)[0].impulse == 0.0


def test_bands_that_hold_zero_on_every_axis_at_once_are_counted_and_their_factor_told() -> None:
    """Pushes along one axis after the other: each band holds zero most of the time, all never."""
    force = np.eye(3)[np.arange(300) % 3] * 10.0
    figures = error_figures(force + 1.0, np.full((300, 3), 1.0), force)
    np.testing.assert_allclose(figures["zero_in_band95"], 0.0)
    np.testing.assert_allclose(figures["band_factor95"], 1 / 1.96)
    wide = error_figures(force, np.full((300, 3), 10.0), force)
    np.testing.assert_allclose(wide["zero_in_band95"], 1.0)


def test_the_error_in_contact_is_split_into_its_parts() -> None:
    """One push is missed, of another the alarm comes late, and half of the force is shown."""
    force = np.zeros((400, 3))
    force[50:150, 0] = force[250:350, 0] = 20.0
    estimate = np.zeros_like(force)
    estimate[270:350] = [10.0, 0.0, 1.0]  # 1 N of friction along z
    parts = mean_parts(error_parts(estimate, force, np.linalg.norm(force, axis=1)))
    whole = parts.pop("mae")
    assert parts["mae_missed"][0] == pytest.approx(10.0)
    assert parts["mae_shut"][0] == pytest.approx(2.0)
    assert parts["mae_gain"][0] == pytest.approx(4.0)
    assert sum(parts.values())[0] == pytest.approx(whole[0])
    assert whole[0] == pytest.approx(np.abs(force - estimate)[force[:, 0] > 5][:, 0].mean())
    assert parts["mae_gain"][2] == 0.0
    _, second = (row for row in rows_of(estimate, force) if row.component == "norm")
    assert second.mae == pytest.approx((4.0 + 8.0 + 0.8) / 3)  # shut, gain along x, friction
    assert second.mae_shut == pytest.approx(4.0 / 3)
    assert second.mae_gain == pytest.approx(8.0 / 3)
