"""External torque, joint states, and what is learned of the torque without contact."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import signal, stats

from ur5lib.errors import RefusalError
from ur5lib.force.external_torque import (
    JointState,
    external_torque,
    is_still,
    joint_states,
)
from ur5lib.force.residual_model import (
    MIN_STD_SHARE,
    ResidualModel,
    Residuals,
    TorqueStretch,
    few_paths,
    fit_residual_model,
)
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.current_samples import prior_of
from ur5lib.robots.description import Robot
from ur5lib.steps.fit_residuals import usual_model
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.segments import unbroken, without_ends

PERIOD = 0.02
BREAKAWAY = np.array([6.0, 6, 4, 2, 2, 2])


def drift(
    count: int, std: np.ndarray, time_constant: float, seed: int, period: float = PERIOD
) -> np.ndarray:
    """An Ornstein-Uhlenbeck process (count, 6)."""
    memory = np.exp(-period / time_constant)
    steps = np.random.default_rng(seed).normal(size=(count + 2000, 6)) * np.sqrt(1 - memory**2)
    return std * signal.lfilter([1], [1, -memory], steps, axis=0)[2000:]


def test_less_current_than_modelled_is_help_from_outside() -> None:
    """tau_ext = J^T F: the environment lifts, the motor needs less."""
    k = np.arange(1.0, 7)
    torque = external_torque(k, np.zeros((2, 6)), np.ones((2, 6)))
    np.testing.assert_array_equal(torque, [k, k])


def test_gaps_divide_and_edges_are_unknown() -> None:
    segment = np.array([0] * 10 + [1] * 5 + [2] * 3)
    assert unbroken(segment) == [slice(0, 10), slice(10, 15), slice(15, 18)]
    left = without_ends(np.ones((18, 6)), segment, 0.1, 2.5)[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(left)), [2, 3, 4, 5, 6, 7, 12])


def moving_stretch(torque: np.ndarray, period: float = PERIOD) -> TorqueStretch:
    return TorqueStretch(torque, np.full(torque.shape, JointState.MOVING), period)


def fitted(*stretches: TorqueStretch) -> ResidualModel:
    return fit_residual_model(stretches, 2.0, BREAKAWAY)


# The states of a joint


def states_of(qd: np.ndarray, period: float = PERIOD) -> np.ndarray:
    return joint_states(qd, np.zeros(len(qd), int), period, cutoff=2.0)


def test_an_arm_is_still_once_all_joints_rest() -> None:
    time = np.arange(0, 8, PERIOD)
    qd = np.zeros((len(time), 6))
    qd[time < 2, 0] = 1.0
    states = states_of(qd)
    assert (states[time < 2.95, 1:] == JointState.RESTING).all()
    assert (states[time > 3.05] == JointState.STILL).all()
    np.testing.assert_array_equal(is_still(states), (states == JointState.STILL).all(axis=1))


@pytest.mark.parametrize(
    ("speed", "state"),
    [(0.029, JointState.STILL), (0.03, JointState.MOVING), (0.031, JointState.MOVING)],
)
def test_a_joint_is_slow_below_0_03_rad_per_s(speed: float, state: int) -> None:
    """Either way."""
    for qd in (speed, -speed):
        assert (states_of(np.full((300, 6), qd)) == state).all()


@pytest.mark.parametrize("rate", [20, 100, 500])
@pytest.mark.parametrize(("seconds", "stops"), [(0.1, False), (0.35, False), (0.4, True)])
def test_a_joint_that_is_slow_for_0_4_s_has_stopped(rate: int, seconds: float, stops: bool) -> None:
    """It reverses or settles from a quarter of a second before to one after."""
    samples = round(seconds * rate)
    qd = np.ones((6 * rate, 6))
    qd[2 * rate : 2 * rate + samples, 2] = 0.0
    states = states_of(qd, 1 / rate)
    expected = np.full(6 * rate, JointState.MOVING)
    around = round(rate / 4 - 0.01)
    expected[2 * rate - around : 2 * rate + samples + around] = (
        JointState.SETTLING if stops else JointState.REVERSING
    )
    np.testing.assert_array_equal(states[:, 2], expected)
    assert (states[:, [0, 1, 3, 4, 5]] == JointState.MOVING).all()


@pytest.mark.parametrize("rate", [20, 100, 500])
def test_friction_relaxes_for_a_second_at_both_ends_of_a_rest(rate: int) -> None:
    """What settles is spread by a quarter second more, into the rest as into the motion."""
    time = np.arange(10 * rate)
    qd = np.ones((10 * rate, 6))
    qd[2 * rate : 8 * rate, 2] = 0.0
    around = round(rate / 4 - 0.01)
    inside = (time >= 2 * rate - around) & (time < 8 * rate + around)
    resting = (time >= 3 * rate) & (time < 7 * rate)
    expected = np.where(
        resting, JointState.RESTING, np.where(inside, JointState.SETTLING, JointState.MOVING)
    )
    np.testing.assert_array_equal(states_of(qd, 1 / rate)[:, 2], expected)


def test_a_gap_wakes_no_joint() -> None:
    qd = np.zeros((100, 6))
    qd[:50] = 1.0
    states = joint_states(qd, np.repeat([0, 1], 50), PERIOD, cutoff=2.0)
    assert (states[:50] == JointState.MOVING).all()
    assert (states[50:] == JointState.STILL).all()


# The model of what is left without contact


def test_spread_change_and_rate_of_a_known_process() -> None:
    """An Ornstein-Uhlenbeck process grows by 1 - exp(-h / time constant) over a lag h."""
    std, time_constant = np.array([3.0, 4, 2, 1, 0.5, 0.7]), 4.0
    model = fitted(moving_stretch(drift(60000, std, time_constant, seed=3)))
    np.testing.assert_allclose(model.spread[JointState.MOVING], std, rtol=0.15)
    change = std * np.sqrt(1 - np.exp(-0.5 / time_constant))
    np.testing.assert_allclose(model.change[JointState.MOVING], change, rtol=0.15)
    assert 0.1 < model.rate[JointState.MOVING] < 0.35
    assert model.independent == 0.25
    np.testing.assert_array_equal(model.breakaway, BREAKAWAY)


def test_a_joint_that_stops_draws_its_friction_anew() -> None:
    """Within a second, though the torque drifts slowly otherwise and stops are rare."""
    torque = drift(6000, np.ones(6), 20.0, seed=5)
    states = np.full(torque.shape, JointState.MOVING)
    states[3000:3300] = JointState.SETTLING
    states[3300:3500] = JointState.RESTING
    states[3500:4500] = JointState.STILL
    rate = fitted(TorqueStretch(torque, states, PERIOD)).rate
    assert (rate[[JointState.SETTLING, JointState.RESTING]] >= 1.0).all()
    assert (rate[[JointState.MOVING, JointState.STILL]] < 0.3).all()


def test_what_stays_renews_itself_in_half_a_minute() -> None:
    """No slower, so that no offset is believed for ever."""
    model = fitted(moving_stretch(5.0 + drift(3000, np.full(6, 0.01), 1.0, seed=11)))
    np.testing.assert_allclose(model.rate, [1 / 30, 1 / 30, 1, 1, 1 / 30])


def test_recordings_of_several_rates_tell_the_same() -> None:
    """One process, sampled at 50 and at 500 Hz: lags are in seconds, not in samples."""
    std, time_constant = np.array([3.0, 4, 2, 1, 0.5, 0.7]), 1.0
    often = drift(400000, std, time_constant, seed=3, period=0.002)
    seldom = moving_stretch(often[::10])
    alone, mixed = fitted(seldom), fitted(seldom, moving_stretch(often, 0.002))
    for name in ("spread", "change", "rate"):
        np.testing.assert_allclose(
            getattr(mixed, name)[JointState.MOVING],
            getattr(alone, name)[JointState.MOVING],
            rtol=0.02,
        )


def test_each_second_counts_once_whatever_the_rate() -> None:
    """Of a quiet recording and a wild one of the same length, at different rates: the mean."""
    quiet = drift(40000, np.full(6, 1.0), 0.1, seed=4, period=0.002)
    wild = drift(4000, np.full(6, 3.0), 0.1, seed=5)
    model = fitted(moving_stretch(quiet, 0.002), moving_stretch(wild))
    np.testing.assert_allclose(model.spread[JointState.MOVING] ** 2, (1 + 9) / 2, rtol=0.2)


def test_each_state_has_its_own() -> None:
    count = 20000
    torque = drift(count, np.ones(6), 0.1, seed=4)
    states = np.repeat([JointState.MOVING, JointState.RESTING], count // 2)[:, None] * np.ones(
        6, int
    )
    torque[count // 2 :] *= 5
    model = fitted(TorqueStretch(torque, states, PERIOD))
    np.testing.assert_allclose(
        model.spread[JointState.RESTING] / model.spread[JointState.MOVING], 5, rtol=0.1
    )
    variance = model.variance(model.spread, states[[0, -1]])
    np.testing.assert_allclose(np.sqrt(variance[1] / variance[0]), 5, rtol=0.1)


def test_a_state_never_seen_is_the_least_certain() -> None:
    model = fitted(moving_stretch(drift(2000, np.ones(6), 1.0, seed=5)))
    for state in (JointState.REVERSING, JointState.SETTLING, JointState.RESTING, JointState.STILL):
        np.testing.assert_array_equal(model.spread[state], model.spread[JointState.MOVING])


def test_no_joint_repeats_without_any_error() -> None:
    """A recording without noise leaves a numerical floor, and no zero to divide by."""
    model = fitted(moving_stretch(1e-9 * drift(2000, np.ones(6), 1.0, seed=5)))
    assert (model.spread >= MIN_STD_SHARE * BREAKAWAY).all()
    assert (model.change >= MIN_STD_SHARE * BREAKAWAY).all()
    assert np.isfinite(model.rate).all()


def test_no_difference_is_taken_across_a_gap() -> None:
    """Two quiet stretches far apart are quiet, not a jump."""
    quiet = drift(500, np.full(6, 0.1), 1.0, seed=6)
    model = fitted(moving_stretch(quiet), moving_stretch(quiet + 50))
    assert (model.change[JointState.MOVING] < 0.2).all()


def test_unknown_torques_tell_nothing() -> None:
    torque = drift(4000, np.ones(6), 1.0, seed=8)
    holes = torque.copy()
    holes[1000:1200] = np.nan
    np.testing.assert_allclose(
        fitted(moving_stretch(holes)).spread[JointState.MOVING],
        fitted(moving_stretch(torque)).spread[JointState.MOVING],
        rtol=0.1,
    )


def test_samples_a_second_apart_are_the_shorter_lag() -> None:
    """Of half a second."""
    torque = drift(400, np.ones(6), 1.0, seed=8, period=1.0)
    model = fitted(moving_stretch(torque, 1.0))
    np.testing.assert_allclose(model.change[JointState.MOVING], 1.0, atol=0.3)


def test_too_short_recordings_are_refused() -> None:
    with pytest.raises(RefusalError) as refusal:
        fitted(moving_stretch(np.zeros((20, 6))))
    assert refusal.value.remark.code == "short recordings"
    assert "has 2 s without a gap" in refusal.value.remark.text


def test_a_joint_that_never_moves_is_refused() -> None:
    """What its motor needs in motion is unknown, and an arm that rests all along shows none."""
    torque = drift(2000, np.ones(6), 1.0, seed=9)
    states = np.full(torque.shape, JointState.MOVING)
    states[:, [2, 4]] = JointState.RESTING
    with pytest.raises(RefusalError) as refusal:
        fitted(TorqueStretch(torque, states, PERIOD))
    assert "moves joint 3, 5:" in refusal.value.remark.text
    other = states.copy()
    other[:, [2, 4]] = JointState.MOVING
    fitted(TorqueStretch(torque, states, PERIOD), TorqueStretch(torque, other, PERIOD))
    with pytest.raises(RefusalError) as refusal:
        fitted(TorqueStretch(torque, np.full(torque.shape, JointState.STILL), PERIOD))
    assert "moves joint 1, 2, 3, 4, 5, 6:" in refusal.value.remark.text


# Few paths


@pytest.mark.parametrize("paths", [1, 2, 3, 5, 9])
def test_few_paths_leave_the_gate_open(paths: int) -> None:
    """Bands grow by all of Student's t, what a contact has to exceed by that of five paths."""
    model = fitted(moving_stretch(drift(2000, np.ones(6), 1.0, seed=7)))
    few = model.of_few_paths(paths)
    inside = few.change / model.change
    np.testing.assert_allclose(few.spread / model.spread, inside)
    np.testing.assert_allclose(inside * few.doubt, few_paths(paths))
    assert inside.max() <= few_paths(5) * (1 + 1e-12)
    assert few.doubt == 1 or paths < 5


@pytest.mark.parametrize("share", [0.0, 1 / 3, 1.0])
def test_what_few_paths_do_not_show_is_as_usual(share: float) -> None:
    """Between what they show and what is usual, by the share; never less than they show."""
    shown = fitted(moving_stretch(drift(2000, np.ones(6), 1.0, seed=7)))
    usual = replace(shown, spread=3 * shown.spread, change=shown.change / 3)
    model = shown.at_least(usual, share)
    np.testing.assert_allclose(model.spread**2, (1 + 8 * share) * shown.spread**2)
    np.testing.assert_array_equal(model.change, shown.change)


@pytest.mark.parametrize("paths", [1, 2, 3, 5, 10, 100])
def test_few_paths_widen_a_band_as_students_t_does(paths: int) -> None:
    """One path counts as two; each shows the errors of two joints."""
    expected = stats.t.ppf(0.975, 2 * (max(paths, 2) - 1)) / stats.norm.ppf(0.975)
    assert few_paths(paths) == pytest.approx(expected)


@pytest.mark.parametrize("seconds", [0.0, 10.0, 1000.0])
def test_rest_that_is_hardly_shown_is_as_usual(seconds: float) -> None:
    """Deviations there mix with the usual ones, by how long the arm rests; in motion, none does."""
    moving = moving_stretch(drift(4000, 0.1 * BREAKAWAY, 1.0, seed=9))
    count = round(seconds / PERIOD)
    still = np.full((count, 6), JointState.STILL, np.int8)
    resting = TorqueStretch(drift(count, 0.02 * BREAKAWAY, 1.0, seed=10), still, PERIOD)
    stretches = [moving, resting] if count else [moving]
    shown = fitted(*stretches)
    model, of_all = shown.with_usual_rest(stretches), 10 / (10 + seconds)
    np.testing.assert_array_equal(model.spread[JointState.MOVING], shown.spread[JointState.MOVING])
    own = shown.spread[JointState.STILL] ** 2
    usual = np.maximum(own, (0.3 * BREAKAWAY) ** 2)
    mixed = np.sqrt(own + of_all * (usual - own))
    np.testing.assert_allclose(model.spread[JointState.STILL], mixed)
    half = np.sqrt(np.mean(own / BREAKAWAY**2)) / 2
    assert model.stiction == pytest.approx(of_all * 0.4 + (1 - of_all) * half)
    rubs = np.sqrt(np.mean((shown.spread[JointState.MOVING] / BREAKAWAY) ** 2))
    assert model.rubbing == pytest.approx(1.25 * rubs)


def test_a_model_survives_json(tmp_path: Path) -> None:
    model = fitted(moving_stretch(drift(2000, np.ones(6), 1.0, seed=7)))
    write_json(Residuals(tau_ext=model.of_few_paths(2)), tmp_path / "residuals.json")
    again = read_record(Residuals, tmp_path / "residuals.json")
    for name, value in vars(model.of_few_paths(2)).items():
        np.testing.assert_array_equal(getattr(again.tau_ext, name), value)


def test_usual_residuals_of_a_fit_with_further_terms_are_those_of_its_base(ur5: Robot) -> None:
    """The doubt of a root of velocity, of one recording along one path, stopped the study."""
    fit = expected_fit(prior_of(ur5, []))
    assert all(own.doubt is not None for own in fit.joints)
    further = [replace(own, doubt=np.pad(own.doubt, (0, 1))) for own in fit.joints]
    wider = usual_model(replace(fit, joints=tuple(further)), 2.0)
    np.testing.assert_allclose(wider.spread, usual_model(fit, 2.0).spread)
