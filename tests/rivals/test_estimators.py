"""The estimators of the benchmark, by identity: on an arm whose external torque is known."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.harness import page
from tests.conftest import PROJECT
from tests.rivals.synthetic_run import COUNT, PERIOD, STIFFNESS, synthetic_run
from ur5lib.errors import InputError
from ur5lib.force.external_torque import FITTED_STATE_COUNT
from ur5lib.force.residual_model import ResidualModel
from ur5lib.timeseries.arrays import Array
from ur5rivals import tuning
from ur5rivals.estimator import Learned
from ur5rivals.estimators import all_estimators, long_short_term_memory
from ur5rivals.estimators.adaptive_extended_kalman_filter import AdaptiveExtendedKalman
from ur5rivals.estimators.adaptive_kalman_filter import AdaptiveKalman
from ur5rivals.estimators.disturbance_kalman_filter import DisturbanceKalman
from ur5rivals.estimators.extended_state_observer import ExtendedState
from ur5rivals.estimators.least_squares import LowPassed
from ur5rivals.estimators.long_short_term_memory import (
    SEQUENCE_LENGTH,
    SEQUENCE_STEP,
    motion,
    train,
)
from ur5rivals.estimators.momentum_observer import FirstOrder
from ur5rivals.estimators.ours import OURS
from ur5rivals.estimators.ours_live import OURS_LIVE
from ur5rivals.estimators.position_error import PositionError, fitted_loops
from ur5rivals.estimators.recursive_least_squares import ForgettingLeastSquares, forgotten
from ur5rivals.estimators.sliding_mode_observer import SlidingMode
from ur5rivals.estimators.variance_aware_kalman_filter import VarianceAware
from ur5rivals.learned_residual import samples, standardised
from ur5rivals.momentum import LinearObserver
from ur5rivals.outside import check
from ur5rivals.run import Estimate, Run
from ur5rivals.scores import free_rows, sensed_rows


def even(run: Run) -> Array:
    """Return a residual's mean 0 and variance 1, (N, 12) [Nm, Nm²]."""
    return np.repeat(np.broadcast_to([[0.0, 1.0]], (len(run.q), 2)), 6, axis=1)


CAUSAL = {
    "low-pass": LowPassed(0.04).torque,
    "first order": FirstOrder(20.0).torque,
    "extended state": ExtendedState(50.0).torque,
    "sliding mode": SlidingMode(1.0, 40.0, np.ones(6)).torque,
    "disturbance Kalman": DisturbanceKalman(3.0, 1.0).torque,
    "adaptive Kalman": AdaptiveKalman(3.0, 5.0, np.full(6, 0.1)).torque,
    "adaptive EKF": AdaptiveExtendedKalman(20.0, 0.003, np.ones(6)).torque,
    "variance-aware Kalman": VarianceAware(3.0, np.ones(6), even).torque,
    "position error": PositionError(np.full(6, STIFFNESS), np.zeros(6)).torque,
}
TORQUES = CAUSAL | {"smoothed Kalman": DisturbanceKalman(3.0, 1.0).smoothed}
LATER = COUNT // 2  # sample from which on something is changed
LEARNT = [own for own in all_estimators() if own.source not in ("ours", "baseline")]
NAMES = [own.name for own in LEARNT if not own.name.startswith(("controller", "thesis"))]
NAMES.remove("least squares behind our gate")
NAMES.remove("position error")  # no trial push moves the arm

each_torque = pytest.mark.parametrize("torque", TORQUES.values(), ids=TORQUES)


def free_runs() -> list[Run]:
    """Two paths of ten seconds without contact."""
    return [synthetic_run(seed, noise=0.3).part(slice(LATER)) for seed in (1, 2)]


@pytest.fixture(scope="module", autouse=True)
def few_rounds() -> Iterator[None]:
    """A network that has learnt little is as causal as one that has learnt much."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(long_short_term_memory, "MAX_STEPS", 10)
        yield


@pytest.fixture(scope="module")
def learned() -> dict[str, Learned]:
    """All but what needs a controller's own samples (test_live.py)."""
    return {own.name: own.learn(free_runs()) for own in all_estimators() if own.name != OURS_LIVE}


@each_torque
def test_a_constant_torque_is_found(torque: Callable[[Run], Array]) -> None:
    push = np.array([10.0, -8.0, 5.0, 3.0, -2.0, 1.0])
    second = round(1 / PERIOD)
    assert torque(synthetic_run(push=push))[second:-second] == pytest.approx(
        np.broadcast_to(push, (COUNT - 2 * second, 6)), rel=0.02, abs=0.02
    )


@each_torque
def test_without_noise_and_contact_there_is_no_torque(torque: Callable[[Run], Array]) -> None:
    assert np.abs(torque(synthetic_run())).max() < 0.02


@each_torque
def test_an_observer_starts_anew_after_a_gap(torque: Callable[[Run], Array]) -> None:
    run = synthetic_run(push=5.0)
    halves = replace(run, segment=(np.arange(COUNT) >= LATER).astype(int))
    alone = run.part(slice(LATER, None))
    assert torque(halves)[LATER:] == pytest.approx(torque(alone), abs=1e-6)


@each_torque
def test_what_is_unknown_stays_unknown(torque: Callable[[Run], Array]) -> None:
    run = synthetic_run()
    assert run.position_error is not None
    for values in (run.torque, run.momentum, run.position_error):
        values[100:110] = np.nan
    unknown = np.isnan(torque(run)).any(axis=1)
    assert np.flatnonzero(unknown).tolist() == [*range(100, 110)]


@pytest.mark.parametrize(
    "observer", [FirstOrder(20.0), ExtendedState(40.0), DisturbanceKalman(5.0, 1.0)]
)
def test_the_filter_of_a_linear_observer_is_its_recursion(observer: LinearObserver) -> None:
    added = np.cumsum(np.random.default_rng(0).normal(size=(200, 6)), axis=0)
    a, b = observer.gains(0.008)
    momentum, torque, found = added[0], np.zeros(6), []
    for measured in added:
        error = measured - (momentum + 0.008 * torque)
        momentum, torque = momentum + 0.008 * torque + a * error, torque + b * error
        found.append(torque)
    np.testing.assert_allclose(observer.follow(added, 0.008), found, rtol=1e-9, atol=1e-9)


def test_friction_and_torque_constant_that_are_off_are_learnt() -> None:
    """With friction a fifth higher than predicted and the constant a tenth lower, less and less of
    it is taken for an external torque; the filter that does not adapt keeps its error.
    """
    run = synthetic_run()
    motor = (run.model + 1.2 * run.friction) / 0.9
    run = replace(run, torque=run.model + run.friction - motor)
    adaptive = AdaptiveExtendedKalman(1.0, 0.01, np.ones(6))
    fixed = AdaptiveExtendedKalman(1.0, 0.0, np.ones(6))
    late = slice(LATER, None)
    left, kept = (np.abs(own.torque(run)[late]).mean() for own in (adaptive, fixed))
    assert left < 0.5 * kept
    states = adaptive.follow(motor, run.model, run.friction, run.period)[-1]
    assert np.exp(states[:, 1]) == pytest.approx(1.2, rel=0.1)
    assert np.exp(states[:, 2]) == pytest.approx(0.9, rel=0.1)


def test_a_recursion_that_forgets_is_a_weighted_mean() -> None:
    values = np.random.default_rng(0).normal(size=(50, 2, 3))
    weights = 0.9 ** np.arange(50)[::-1]
    found = forgotten(values, 0.9)
    assert found[0] == pytest.approx(values[0])
    assert found[-1] == pytest.approx(np.average(values, axis=0, weights=weights))


def test_a_lasting_force_is_that_of_least_squares() -> None:
    """What is forgotten does not matter, then."""
    push = np.array([10.0, -20.0, 5.0, 0, 0, 0])
    run = synthetic_run()
    run = run.pushed(run.jacobian.mT @ push)
    found = ForgettingLeastSquares(60.0, 0.02, unsure(1.0)).estimate(run).wrench[-1]
    assert found == pytest.approx(push, abs=0.05)


def test_the_gains_of_a_position_loop_are_found() -> None:
    found = fitted_loops([synthetic_run(seed, noise=0.3) for seed in (1, 2)])
    assert found.gain == pytest.approx(np.full(6, STIFFNESS), rel=0.01)
    assert np.abs(found.constant).max() < 0.1


def test_the_last_states_are_read_in_the_order_of_time_and_not_across_a_gap() -> None:
    run = replace(synthetic_run(), segment=(np.arange(COUNT) >= LATER).astype(int))
    seen = motion(run, with_error=False).inputs.reshape(COUNT, SEQUENCE_LENGTH, 12)
    back = round(SEQUENCE_STEP / PERIOD)
    assert np.array_equal(
        seen[LATER - 1, :, 0], run.q[LATER - 1 - back * np.arange(SEQUENCE_LENGTH)[::-1], 0]
    )
    assert np.array_equal(seen[LATER + back, -2:, 6:], run.qd[[LATER, LATER + back]])
    assert (seen[LATER + back, :-1, 6:] == run.qd[LATER]).all()


def test_a_network_learns_the_torque_of_an_arm_that_it_knows_nothing_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Trained on a path, it is tried on the same one."""
    monkeypatch.setattr(long_short_term_memory, "MAX_STEPS", 200)
    run = synthetic_run(noise=0.3)
    known = samples([run], 0.04, partial(motion, with_error=False))
    error = standardised(train, known, known)(known.inputs) - known.torque
    assert (error.std(axis=0) < 0.2 * known.torque.std(axis=0) + 0.3).all()


@pytest.mark.parametrize("name", ["LSTM, NEXT", "position error"])
def test_what_needs_target_angles_states_nothing_without(
    name: str, learned: dict[str, Learned]
) -> None:
    blind = replace(synthetic_run(1), position_error=None)
    assert learned[name].method(blind) is None
    (own,) = (own for own in all_estimators() if own.name == name)
    with pytest.raises(InputError, match="target_q"):
        own.learn([blind])


def test_a_first_order_lag_has_its_time_constant_as_latency() -> None:
    run = synthetic_run()
    assert tuning.latency(LowPassed(5 * PERIOD).torque, [run]) == pytest.approx(5 * PERIOD)
    assert tuning.latency(lambda own: 0 * own.torque, [run]) == np.inf


def test_the_least_false_force_is_chosen_among_the_prompt() -> None:
    runs = [synthetic_run(seed, noise=0.3) for seed in (1, 2)]
    chosen = tuning.tuned([LowPassed(own) for own in (0.01, 0.04, 0.2)], runs)
    assert chosen.constants == {"time_constant": 0.04}
    with pytest.raises(InputError, match="no candidate has a latency of at most 50 ms"):
        tuning.tuned([LowPassed(0.2)], runs)


def test_latencies_are_at_most_50_ms(learned: dict[str, Learned]) -> None:
    known = [own.latency for own in learned.values() if own.latency is not None]
    assert len(known) >= 8
    assert max(known) <= tuning.MAX_LATENCY + 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_what_an_estimator_from_outside_is_refused_for_no_rival_does(
    name: str, learned: dict[str, Learned]
) -> None:
    run = synthetic_run(3)
    run.torque[100:110] = np.nan
    check(learned[name].method(run), run, name)


@pytest.mark.parametrize("name", NAMES)
def test_a_push_is_shown_in_newton_with_a_band(name: str, learned: dict[str, Learned]) -> None:
    run, push = synthetic_run(3), np.array([10.0, -20.0, 5.0, 0, 0, 0])
    pushed = run.pushed(run.jacobian.mT @ push)
    estimates = [learned[name].method(own) for own in (run, pushed)]
    free, found = (own for own in estimates if own is not None)
    middle = slice(round(1 / PERIOD), -round(1 / PERIOD))
    difference = (found.wrench - free.wrench)[middle]
    assert difference == pytest.approx(np.broadcast_to(push, difference.shape), abs=0.5)
    assert found.std is not None
    assert (found.std[:, :3] > 0).all()


@pytest.mark.parametrize(
    "name",
    [own.name for own in all_estimators() if own.causal and own.name in NAMES],
)
def test_the_future_does_not_change_the_past(name: str, learned: dict[str, Learned]) -> None:
    run = synthetic_run(4, noise=0.3)
    push = np.zeros((COUNT, 6))
    push[LATER:] = 20.0
    before, after = (learned[name].method(own) for own in (run, run.pushed(push)))
    assert before is not None
    assert after is not None
    assert np.array_equal(before.wrench[:LATER], after.wrench[:LATER])
    assert not np.allclose(before.wrench[LATER:], after.wrench[LATER:])


def unsure(spread: float) -> ResidualModel:
    """Return a residual model with one standard deviation [Nm] for all joints and states."""
    deviation = np.full((FITTED_STATE_COUNT, 6), spread)
    return ResidualModel(deviation, deviation, np.ones(FITTED_STATE_COUNT), 0.1, np.zeros(6))


def test_the_same_data_give_the_same_numbers(learned: dict[str, Learned]) -> None:
    tested = synthetic_run(5, noise=0.3)
    for own in all_estimators():
        if own.name.startswith(("least squares +", "LSTM")):
            first, second = (
                one.method(tested) for one in (learned[own.name], own.learn(free_runs()))
            )
            assert first is not None
            assert second is not None
            assert np.array_equal(first.wrench, second.wrench)


def scored() -> pd.DataFrame:
    """Contacts of 10 to 14 N; ours errs by 2 N on each axis, a rival by 1 N, another by 3 N."""
    run = synthetic_run()
    time = np.arange(COUNT) * PERIOD
    contact = np.where(time % 4 > 2, 10.0 + time // 4, 0.0)
    run = replace(run, sensor=np.column_stack([contact, *np.zeros((5, COUNT))]))
    band = np.full((COUNT, 6), 2.0)
    errors = {OURS: 2.0, "better": 1.0, "worse": 3.0}
    found = {name: Estimate(run.sensor + error, band) for name, error in errors.items()}
    rows: list[dict[str, Any]] = [*sensed_rows(run, found, OURS)]
    return pd.DataFrame(rows).assign(robot="ur5", causal="no", latency_s=None)


def test_differences_from_ours_have_their_interval() -> None:
    table = scored().set_index(["component", "during", "estimator"]).sort_index()
    vector, along = table.loc["norm", "contact"], table.loc["Fx", "contact"]
    assert vector["rmse"].to_dict() == pytest.approx(
        {name: error * np.sqrt(3) for name, error in ((OURS, 2), ("better", 1), ("worse", 3))}
    )
    for end in ("rmse_more", "rmse_more_low", "rmse_more_high"):
        assert vector.loc["better", end] == pytest.approx(-np.sqrt(3))
    assert along.loc["worse", "mae_more"] == pytest.approx(1.0)
    assert vector.loc[OURS, "rmse_more"] == 0


def test_the_page_says_who_is_better() -> None:
    table = scored()
    sentence = page.findings(table)[0]
    assert sentence.endswith("(RMSE): better by −1.7 (−1.7 to −1.7) N.")
    told = " ".join(page.opening(table))
    assert "3 estimators, 0 of them causal, on 1 recordings of 1 arms" in told
    assert "Of 10 comparisons" in told  # two rivals, by five figures; all bands hold
    assert "better beyond chance in 4 and worse in 4." in told


PAGE = """# Page

## Simulated arms

{simulated}

## Add

end
"""


def test_what_was_not_measured_again_stays_on_the_page() -> None:
    """And of the estimators, the section names those that did not run on the seeds."""
    old = PAGE.format(simulated="| old | 1 |\n| ours | 2 |")
    new = PAGE.format(simulated="Not measured yet.")
    kept = page.with_kept(new, old, False, ["ours", "rival"])
    shown = f"| old | 1 |\n| ours | 2 |\n\n{page.ABSENT} rival."
    assert kept == PAGE.format(simulated=shown)
    assert page.with_kept(new, kept, False, ["ours", "rival"]) == kept
    assert page.with_kept(old, new, True, ["ours"]) == old


def test_the_committed_page_states_the_rule_of_the_code() -> None:
    text = (PROJECT / "docs" / "benchmark.md").read_text()
    assert [number for number in page.rule().values() if number not in text] == []
    assert "built-in" not in text


def test_without_a_better_one_the_page_says_nothing() -> None:
    table = scored()
    assert page.findings(table[table["estimator"] != "better"]) == []


def test_a_free_arm_shows_false_force() -> None:
    run = synthetic_run()
    shown = np.zeros((COUNT, 6))
    shown[:, 0] = 3.0
    (row,) = free_rows(run, {"offset": Estimate(shown, np.full((COUNT, 6), 1.0))})
    assert row["median"] == row["largest95"] == 3.0
    assert row["coverage95"] == pytest.approx(2 / 3)
