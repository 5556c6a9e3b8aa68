"""From motion to current: known maps come back, and say how well; the real arms' are judged."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from tests.current_study import (
    CONSTANT,
    FRICTION,
    OFFSET,
    coefficients,
    cut,
    make_noise,
    make_record,
    noisy,
    prior,
    smooth,
    with_noise,
)
from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.identification.current_regression import (
    DOUBTFUL_DEVIATIONS,
    LEAST_ERRORS,
    UNSEEN_ERRORS,
    expected_fit,
    fit_currents,
    fit_without_each_path,
    unseen_error,
)
from ur5lib.identification.currents import (
    DAY_TO_DAY_STD,
    RUN_TO_RUN_STD,
    band,
    breakaway_torque,
    dry_friction,
    friction_current,
    load_loss,
    mixed_at_rest,
    parameters,
    predict,
    torque_constants,
    unseen_difference,
)
from ur5lib.identification.estimation import estimate_together, physical_values, with_fuller_errors
from ur5lib.identification.joint_regression import left_out_residuals
from ur5lib.identification.prior import Typical
from ur5lib.identification.regression import (
    Normal,
    block_sums,
    draw_blocks,
    draw_units,
    half_width,
    regress,
    spread,
    standard_error,
)
from ur5lib.identification.samples import (
    INDEPENDENT_STEP,
    CurrentSamples,
    MotionState,
    apart_from,
    joint_samples,
    motion_states,
    record_paths,
)
from ur5lib.identification.validation import (
    baseline_current,
    coefficients_of_constants,
    fitted_on_tested_on,
    least_squares_coefficients,
    score,
)
from ur5lib.records.friction import CoefficientEstimate, CurrentFit, Friction, LeftOut
from ur5lib.records.motion import Motion
from ur5lib.robots.friction import BASE_TERMS, rest_factor
from ur5lib.steps.fit_friction import fitted_friction
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import DEAD_ZONE

RUNS = 200
STUDY = 10  # recordings


@pytest.fixture(scope="module")
def study() -> list[CurrentSamples]:
    return noisy(range(STUDY))


@pytest.fixture(scope="module")
def fitted(study: list[CurrentSamples]) -> CurrentFit:
    return fit_currents(study, smooth, prior())


def constants_of(fit: CurrentFit) -> dict[tuple[int, str], float]:
    return {(row.joint, row.name): row.value for row in parameters(fit)}


# Known maps


def test_a_map_without_noise_comes_back() -> None:
    records = [make_record(seed) for seed in range(3)]
    samples = joint_samples(records, smooth)
    estimates, _ = estimate_together(samples, prior())
    for joint, estimate in enumerate(estimates):
        true = [*coefficients(joint), 0.0]  # without a root of velocity
        np.testing.assert_allclose(estimate.coefficients, true, rtol=1e-3, atol=1e-4)


def test_draws_are_of_whole_units_or_of_blocks_within_them() -> None:
    """Each unit is drawn as often as it has blocks; what is of no unit never is."""
    unit = np.array([0, 0, 0, -1, 1, 1, 2])
    generator = np.random.default_rng(0)
    whole, within = draw_units(unit, generator), draw_blocks(unit, generator)
    for counts in (whole, within):
        assert counts.shape == (500, 7)
        assert (counts[:, 3] == 0).all()
        np.testing.assert_allclose(counts[:, unit >= 0].mean(axis=0), 1, atol=0.15)
    assert (whole[:, :3] == whole[:, :1]).all()
    assert (whole[:, [0, 4, 6]].sum(axis=1) == 3).all()
    for one in range(3):
        assert (within[:, unit == one].sum(axis=1) == (unit == one).sum()).all()
    assert (within[:, 0] != within[:, 1]).any()


def test_what_does_not_determine_a_constant_leaves_it_to_the_prior(fitted: CurrentFit) -> None:
    rows = {row.joint: row for row in parameters(fitted) if row.name == "torque_constant"}
    assert not rows[6].determined
    assert rows[6].prior_share > 0.99
    assert rows[6].value == pytest.approx(CONSTANT[5], rel=0.02)
    assert rows[6].std_error / rows[6].value == pytest.approx(0.1, rel=0.2)
    assert rows[2].prior_share < 0.01


def test_shares_of_knowledge_are_those_of_prior_days_and_recordings() -> None:
    """Joint 6 carries nothing; a second day tells as much as what is recorded on it."""
    records = noisy(range(3))
    days = [replace(record, day=str(day)) for record, day in zip(records, (1, 1, 2), strict=True)]
    for own, others in ((records, 0.0), (days, 0.2)):
        rows = parameters(fit_currents(own, smooth, prior()))
        shares = np.array([(r.prior_share, r.arm_share, r.day_share, r.run_share) for r in rows])
        np.testing.assert_allclose(shares.sum(axis=1), 1, atol=1e-9)
        coulomb = shares[[row.name == "coulomb" for row in rows]]
        assert (coulomb[:, 0] < 0.01).all()
        assert (coulomb[:, 3] > 1 / 3).all()
        assert coulomb[:, 1].max() >= others
        assert (coulomb[:, 1].max() > 0) == (others > 0)


def test_intervals_hold_what_they_promise() -> None:
    """200 studies; constants as the prior says, noise as real residuals."""
    samples = joint_samples([make_record(seed) for seed in range(STUDY)], smooth)
    samples = [own.where(own.moving) for own in samples]
    known = prior()
    inside, determined = [], []
    for run in range(RUNS):
        random = np.random.default_rng(run)
        truth = [np.append(coefficients(joint), 0.0) for joint in range(6)]
        for joint in range(6):
            truth[joint][0] *= 1 + 0.1 * random.standard_normal()
            truth[joint][4] = 0.1 * random.standard_normal() / CONSTANT[joint]
        noise = [make_noise(random, 400, INDEPENDENT_STEP) for _ in range(STUDY)]
        drawn = []
        for joint, own in enumerate(samples):
            place = np.concatenate([np.arange(np.sum(own.record == one)) for one in range(STUDY)])
            residual = np.stack(noise)[own.record, place, joint]
            drawn.append(replace(own, current=own.columns @ truth[joint] + residual))
        estimates, units = estimate_together(drawn, known, seed=run)
        pairs = zip(estimates, truth, strict=True)
        off = [
            np.abs(physical_values(own.coefficients) - physical_values(true)) for own, true in pairs
        ]
        half = [half_width(own.std_error, units, own.prior_share) for own in estimates]
        inside.append(np.concatenate(off) < np.concatenate(half))
        determined.append(np.concatenate([e.prior_share < 0.5 for e in estimates]))
    always = np.all(determined, axis=0)
    unloaded = [-6, -2]  # the constant and the load friction of joint 6, which carries nothing
    assert not np.any(determined, axis=0)[unloaded].any()
    assert always.sum() == len(always) - len(unloaded)
    coverage = np.where(always, np.mean(inside, axis=0), np.nan)
    assert np.nanmean(coverage) == pytest.approx(0.95, abs=0.02)
    assert np.nanmin(coverage) >= 0.90
    # of 200 studies, that of one coefficient may be all by chance
    assert np.nanmean(coverage.reshape(6, 6), axis=0).max() <= 0.99


def test_standard_errors_hold_what_a_further_term_changes() -> None:
    """k = 10 Nm/A under both; the offset, -2 Nm, would be -5 Nm with the term."""
    nothing = np.empty(0)
    own = CoefficientEstimate(np.array([0.1, 0.2]), nothing, nothing, np.array([1.0, 1.0]))
    fuller = CoefficientEstimate(
        np.array([0.1, 0.5, 0.3]), nothing, nothing, np.array([3.0, 4.0, 9.0])
    )
    wider = with_fuller_errors(own, fuller)
    np.testing.assert_allclose(wider.std_error, [3.0, 5.0])
    np.testing.assert_array_equal(wider.coefficients, own.coefficients)


def test_friction_is_no_surer_than_days_and_recordings_differ() -> None:
    """Recordings told half of the 2 Nm of Coulomb friction; four days leave half the difference."""
    told = CoefficientEstimate(
        np.array([0.1, 0.2, 0.2]), np.array([[0.0, 0.0, 0.5]]), np.empty(0), np.zeros(3)
    )
    day = np.hypot(DAY_TO_DAY_STD, RUN_TO_RUN_STD)
    np.testing.assert_allclose(unseen_difference(told, 1, 1, 1), [0.0, 0.0, day])
    np.testing.assert_allclose(unseen_difference(told, 4, 4, 4), [0.0, 0.0, day / 2])
    # what paths that are drawn have shown is not counted twice
    assert DAY_TO_DAY_STD / 2 < unseen_difference(told, 1, 8, 8)[2] < DAY_TO_DAY_STD
    np.testing.assert_array_equal(unseen_difference(told, 8, 8, 8), 0.0)


# What hurts


def test_a_push_does_not_decide(study: list[CurrentSamples]) -> None:
    """A twentieth of the samples is off by 3 A: least squares would move offsets by 1.6 Nm."""
    pushed = [replace(record, current=record.current.copy()) for record in study]
    for record in pushed:
        record.current[100:160] += 3.0
    plain, moved = (
        estimate_together(joint_samples(records, smooth), prior())[0] for records in (study, pushed)
    )
    for before, after in zip(plain, moved, strict=True):
        np.testing.assert_allclose(
            physical_values(after.coefficients)[:5],
            physical_values(before.coefficients)[:5],
            rtol=0.1,
            atol=0.4,
        )


def test_nothing_runs_across_a_gap(study: list[CurrentSamples]) -> None:
    record = replace(study[0], segment=np.where(np.arange(len(study[0].q)) < 600, 0, 1))
    halves = [cut(record, record.segment == half) for half in (0, 1)]
    (split, *_), (whole, *_) = (joint_samples(records, smooth) for records in (halves, [record]))
    np.testing.assert_allclose(split.columns, whole.columns)
    assert len(np.unique(split.block)) == len(np.unique(whole.block))


def test_rows_that_were_not_received_are_left_out(study: list[CurrentSamples]) -> None:
    holed = [replace(record, current=record.current.copy()) for record in study[:5]]
    for record in holed:
        record.current[300:320] = np.nan
    values = constants_of(fit_currents(holed, smooth, prior()))
    assert np.isfinite(list(values.values())).all()
    assert values[2, "torque_constant"] == pytest.approx(CONSTANT[1], rel=0.02)


# What has not seen a path


def changed(record: CurrentSamples) -> CurrentSamples:
    """The recording with a current that no other would make one expect."""
    return replace(record, current=2 * record.current + 1)


def equal(one: CurrentFit, other: CurrentFit) -> bool:
    return all(
        a.terms == b.terms
        and a.held == b.held
        and np.array_equal(a.estimate.coefficients, b.estimate.coefficients)
        for a, b in zip(one.joints, other.joints, strict=True)
    )


@pytest.fixture(scope="module")
def twice(study: list[CurrentSamples]) -> list[CurrentSamples]:
    """Four recordings along three paths: the last repeats the first."""
    again = replace(with_noise(make_record(0), 77), name="again")
    return [*study[:3], again]


@pytest.fixture(scope="module")
def folds(twice: list[CurrentSamples]) -> dict[str, CurrentFit]:
    """Of each recording, the fit that has not seen its path."""
    fits = fit_without_each_path(twice, smooth, prior())
    return {name: fit for names, fit in fits for name in names}


@pytest.mark.parametrize("mutated", [1, 3])
def test_a_fit_has_not_seen_what_it_is_judged_on(
    twice: list[CurrentSamples], folds: dict[str, CurrentFit], mutated: int
) -> None:
    """Whatever its current were, the fit that predicts it is the same; the others are not.

    Recordings of one path are left out together.
    """
    records = [
        changed(record) if index == mutated else record for index, record in enumerate(twice)
    ]
    assert record_paths(twice).tolist() == [0, 1, 2, 0]
    fits = fit_without_each_path(records, smooth, prior())
    one, other, third, again = (record.name for record in twice)
    assert [names for names, _ in fits] == [[one, again], [other], [third]]
    for names, fit in fits:
        assert equal(fit, folds[names[0]]) == (twice[mutated].name in names)


def test_one_path_has_no_fit_that_has_not_seen_it(twice: list[CurrentSamples]) -> None:
    assert fit_without_each_path([twice[0], twice[3]], smooth, prior()) == []


def test_of_many_paths_several_are_left_out_together(
    study: list[CurrentSamples], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ur5lib.identification.current_regression.MAX_FOLDS", 3)
    fits = fit_without_each_path([cut(own, slice(200)) for own in study[:5]], smooth, prior())
    names = [record.name for record in study]
    assert [out for out, _ in fits] == [[names[0], names[3]], [names[1], names[4]], [names[2]]]


def dated(records: list[CurrentSamples], days: str) -> list[CurrentSamples]:
    """Their first 10 s, each with a letter for its day."""
    return [cut(own, slice(1250), day=day) for own, day in zip(records, days, strict=True)]


@pytest.mark.parametrize(
    ("days", "seen"),
    [
        ("aabbbc", "bbbc"),
        ("aaabbb", "bbb"),
        ("aaaabb", "aaabb"),  # of other days, two paths would remain
        ("aaaaaa", "aaaaa"),
    ],
)
def test_a_day_is_left_out_where_others_have_enough_paths(days: str, seen: str) -> None:
    path = np.arange(len(days))
    kept = apart_from(path == 0, path, np.array([ord(day) for day in days]))
    assert not kept[0]
    assert "".join(np.array([*days])[kept]) == seen


def test_a_fit_has_not_seen_the_day_that_it_is_judged_on(study: list[CurrentSamples]) -> None:
    """Whatever the currents of that day were, the fit is the same; the others are not."""
    records = dated(study[:6], "aabbbc")
    fits = fit_without_each_path(records, smooth, prior())
    assert [len(names) for names, _ in fits] == [2, 3, 1]
    first = [changed(own) if own.day == "a" else own for own in records]
    again = fit_without_each_path(first, smooth, prior())
    same = [equal(one, other) for (_, one), (_, other) in zip(fits, again, strict=True)]
    assert same == [True, False, False]


@pytest.mark.parametrize("dated_alike", [False, True], ids=["path", "day"])
def test_a_left_out_residual_has_not_seen_its_path_nor_its_day(
    study: list[CurrentSamples], twice: list[CurrentSamples], dated_alike: bool
) -> None:
    """Of joint 2, with another current in a further run: bands are of other paths and days."""
    records, index = (dated(study[:6], "aabbbc"), 1) if dated_alike else (twice, 3)
    mutated = [*records[:index], changed(records[index]), *records[index + 1 :]]
    before, after = (joint_samples(own, smooth)[1] for own in (records, mutated))
    known = prior().of_joint(1)
    old, new = left_out_residuals(before, known), left_out_residuals(after, known)
    own = before.record == 0
    np.testing.assert_array_equal(new[own], old[own])
    other = before.record > 1 if dated_alike else np.isin(before.record, [1, 2])
    assert not np.isclose(new[other], old[other]).all()


def test_the_fit_for_a_recording_is_the_one_that_has_not_seen_it(
    twice: list[CurrentSamples], folds: dict[str, CurrentFit], tmp_path: Path
) -> None:
    """By way of friction.json; a recording that no fit has seen has the fit of all."""
    whole = fit_currents(twice, smooth, prior())
    left_out = [LeftOut([name], fit) for name, fit in folds.items()]
    write_json(Friction(fit=whole, left_out=left_out), tmp_path / "friction.json")
    friction = read_record(Friction, tmp_path / "friction.json")
    for record in twice:
        assert equal(friction.fit_for(record.name), folds[record.name])
        assert not equal(friction.fit_for(record.name), whole)
    assert equal(friction.fit_for("another"), whole)
    assert equal(replace(friction, left_out=[]).fit_for(twice[0].name), whole)


def test_breakaway_is_the_friction_that_turns_with_direction(fitted: CurrentFit) -> None:
    """Of the made-up arm: Coulomb friction, and never less than a tenth of a newton metre."""
    torque = breakaway_torque(fitted)
    np.testing.assert_allclose(torque, [own[0] for own in FRICTION], rtol=0.3)
    first = fitted.joints[0]
    slippery = replace(
        first.estimate, coefficients=first.estimate.coefficients * [1, 1, 0, 0, 0, 0]
    )
    fit = replace(fitted, joints=(replace(first, estimate=slippery),))
    np.testing.assert_allclose(breakaway_torque(fit), 0.1)


def test_a_joint_that_turns_with_a_coupled_motor_has_its_dry_friction_too() -> None:
    """Own dry friction that noise makes negative takes nothing away from it."""
    values = np.array([1.0, 0.0, -0.5, 7.0, 7.0, -2.0, 7.0, 7.0])
    assert dry_friction((*BASE_TERMS, "coupled"), values) == 2.0
    values[2] = 3.0
    assert dry_friction((*BASE_TERMS, "coupled"), values) == 5.0
    assert dry_friction(BASE_TERMS, values[:5]) == 3.0


def test_a_load_costs_its_torque_times_the_loss(fitted: CurrentFit) -> None:
    """In currents of friction, with the load and without."""
    record = make_record(50)
    free = replace(record, torque=0 * record.torque)
    added = friction_current(fitted, record) - friction_current(fitted, free)
    lost = load_loss(fitted, record) * np.abs(record.torque)
    np.testing.assert_allclose(torque_constants(fitted) * added, lost, atol=1e-9)
    assert np.abs(lost).max() > 1.0


# Too little


def test_one_recording_is_fitted_and_says_what_is_missing(study: list[CurrentSamples]) -> None:
    fit = fit_currents(study[:1], smooth, prior())
    assert all(joint.remarks[0].code == "one path" for joint in fit.joints)
    assert constants_of(fit)[2, "torque_constant"] == pytest.approx(CONSTANT[1], rel=0.06)
    assert all(np.isfinite(row.std_error) and row.std_error > 0 for row in parameters(fit))


def test_a_standstill_leaves_the_prior_and_says_so(study: list[CurrentSamples]) -> None:
    still = [replace(record, q=0 * record.q, qd=0 * record.qd) for record in study[:3]]
    fit = fit_currents(still, smooth, prior())
    assert all(joint.remarks[0].code == "no motion" for joint in fit.joints)
    assert not any(row.determined for row in parameters(fit))
    np.testing.assert_allclose(
        [constants_of(fit)[joint, "torque_constant"] for joint in range(1, 7)], CONSTANT
    )
    assert np.isfinite(predict(fit, still[0])).all()


def test_a_joint_that_keeps_still_does_not_spoil_the_others(study: list[CurrentSamples]) -> None:
    moves = np.array([1, 1, 1, 0, 1, 1])
    stopped = [replace(own, q=own.q * moves, qd=own.qd * moves) for own in study[:5]]
    fit = fit_currents(stopped, smooth, prior())
    rows = parameters(fit)
    assert fit.joints[3].remarks[0].code == "no motion"
    assert not any(row.determined for row in rows if row.joint == 4)
    assert all(row.determined for row in rows if row.joint in (1, 2, 3))


def test_a_constant_of_unknown_sign_is_undetermined(study: list[CurrentSamples]) -> None:
    """Whatever the share of the prior: 100 ± 120 Nm/A tells nothing."""
    fit = fit_currents(study[:3], smooth, prior())
    third = fit.joints[2]
    unsure = replace(
        third.estimate, std_error=0.5 * np.abs(physical_values(third.estimate.coefficients))
    )
    joints = (*fit.joints[:2], replace(third, estimate=unsure), *fit.joints[3:])
    rows = [row for row in parameters(replace(fit, joints=joints)) if row.joint == 3]
    assert [row.determined for row in rows if row.name == "torque_constant"] == [False]
    assert all(row.determined for row in rows if row.name == "coulomb")


@pytest.mark.parametrize("measured", [CURRENT, TORQUE])
@pytest.mark.parametrize(("place", "name"), [(2, "coulomb"), (3, "viscous")])
def test_friction_that_drives_is_undetermined(
    study: list[CurrentSamples], measured: Effort, place: int, name: str
) -> None:
    """However sure the fit is of it: something else is taken for it."""
    fit = fit_currents(study[:3], smooth, prior())
    estimate = fit.joints[2].estimate
    turned = np.where(np.arange(len(estimate.coefficients)) == place, -1.0, 1.0)
    driven = replace(estimate, coefficients=turned * estimate.coefficients)
    joints = (*fit.joints[:2], replace(fit.joints[2], estimate=driven), *fit.joints[3:])
    rows = [row for row in parameters(replace(fit, joints=joints), measured) if row.name == name]
    assert [row.determined for row in rows if row.value < 0] == [False]
    assert any(row.determined for row in rows)


UNLIKELY = "unlikely constant"
OF_MOTION = "q", "qd", "qdd", "q_std", "qd_std", "qdd_std", "motor_qd"


@pytest.mark.parametrize(("ratio", "doubted"), [(1.4, False), (1.6, True), (0.6, True)])
def test_a_constant_unlike_what_was_known_is_remarked(
    study: list[CurrentSamples], ratio: float, doubted: bool
) -> None:
    """Beyond what gears lose in right recordings."""
    wrong = prior()
    inverse = Normal(ratio * wrong.inverse_constant.mean, 4 * wrong.inverse_constant.precision)
    fit = fit_currents(study[:5], smooth, replace(wrong, inverse_constant=inverse))
    remarks = {one.code: one for one in fit.joints[1].remarks}
    assert (UNLIKELY in remarks) == doubted
    if doubted:
        told = re.search(r", ([\d.]+) instead of ([\d.]+) ± ([\d.]+) ", remarks[UNLIKELY].text)
        assert told is not None
        fitted, known, known_std = map(float, told.groups())
        assert abs(1 / fitted - 1 / known) * known**2 > DOUBTFUL_DEVIATIONS * known_std


# Judging


def test_the_baseline_is_equations_6_4_and_6_6(study: list[CurrentSamples]) -> None:
    """And its constants are found by least squares; joint 6 carries nothing that shows its own."""
    coulomb, viscous = np.random.default_rng(0).uniform(1, 9, (2, 6))
    constants = coefficients_of_constants(CONSTANT, OFFSET, coulomb, viscous)
    qd = study[0].qd
    torque = CONSTANT * baseline_current(study[0], constants) + OFFSET - study[0].torque
    expected = viscous * qd + coulomb * np.sign(qd) * (np.abs(qd) > DEAD_ZONE)
    np.testing.assert_allclose(torque, expected, atol=1e-12)
    exact = [replace(record, current=baseline_current(record, constants)) for record in study]
    found = least_squares_coefficients(exact)
    np.testing.assert_allclose(found[:5], constants[:5], atol=1e-12)
    np.testing.assert_allclose(found[5, 1:], constants[5, 1:], atol=1e-12)


def halved(values: Array, _: CurrentSamples) -> Array:
    """Stands for a low-pass: of errors it leaves a half."""
    return values / 2


def test_scores_are_means_over_what_is_known() -> None:
    record = make_record(0, seconds=2.0)
    error = np.tile([0.4, -0.2], 50)[:, None] * np.arange(1.0, 7.0)
    error[:10, 1] = np.nan
    error[:, 5] = np.nan
    half_band = np.full_like(error, 0.15)
    half_band[50:, 2] = np.nan
    scores = score(record, record.current - error, halved, half_band)
    known = np.arange(1.0, 6.0)
    np.testing.assert_allclose(scores.rmse[:5], known * np.sqrt(0.1))
    np.testing.assert_allclose(scores.rmse_lowpassed[:5], known * np.sqrt(0.1) / 2)
    np.testing.assert_allclose(scores.mae[:5], known * 0.15)
    variance = (record.current[:, :5] / 2).var(axis=0)
    np.testing.assert_allclose(scores.r2[:5], 1 - 0.025 * known**2 / variance)
    np.testing.assert_allclose(scores.zero_rmse_lowpassed[:5], np.sqrt(variance))
    np.testing.assert_allclose(scores.coverage, [0.5, 0, 0, 0, 0, np.nan])
    for values in (scores.rmse, scores.mae, scores.r2):
        assert np.isnan(values[5])


def test_the_edge_of_a_band_is_inside() -> None:
    record = make_record(0, seconds=1.0)
    error = np.full_like(record.current, 0.5)
    for half, share in ((0.25, 1.0), (0.2499, 0.0)):
        scores = score(record, record.current - error, halved, np.full_like(error, half))
        np.testing.assert_allclose(scores.coverage, share)


def test_a_fit_is_tested_where_both_recordings_move() -> None:
    """Of an exact map without noise nothing is left; a joint that rests has no score."""
    records = [make_record(seed) for seed in range(2)]
    resting = replace(
        records[1],
        q=records[1].q * [1, 1, 1, 1, 0, 1],
        qd=records[1].qd * [1, 1, 1, 1, 0, 1],
    )
    table = fitted_on_tested_on([records[0], resting], smooth, prior())
    assert np.isnan(table[:, 1, 4]).all()
    assert np.isnan(table[1, :, 4]).all()
    assert table[0, 0, 4] < 0.01
    assert np.nanmax(table[:, :, :4]) < 0.02


def test_a_fit_is_tested_on_each_sample_of_the_other_recording() -> None:
    """One has 0.3 A more for 2 s and 0.3 A less for 2 s, in turn, which no term explains."""
    plain, changed = make_record(0), make_record(1)
    wave = np.where(np.arange(len(changed.q)) // 100 % 2, 0.3, -0.3)
    changed = replace(changed, current=changed.current + wave[:, None])
    table = fitted_on_tested_on([plain, changed], smooth, prior())
    np.testing.assert_allclose(table[0, 1], 0.3, rtol=0.1)
    assert (table[1, 0] < 0.2).all()


def test_the_baseline_is_fitted_to_the_samples_that_are_whole() -> None:
    """A cell that is missing takes its sample along, and no other."""
    record = make_record(0)
    lacking = replace(record, torque=record.torque.copy(), current=record.current.copy())
    lacking.torque[:50, 2] = np.nan
    lacking.current[100:150, 4] = np.nan
    whole = np.ones(len(record.q), bool)
    whole[:50] = whole[100:150] = False
    parts = {name: getattr(record, name)[whole] for name in ("torque", "qd", "current")}
    np.testing.assert_allclose(
        least_squares_coefficients([lacking]),
        least_squares_coefficients([replace(record, **parts)]),
        atol=1e-9,
    )


def test_a_band_covers_a_recording_left_out(
    study: list[CurrentSamples], fitted: CurrentFit
) -> None:
    other = with_noise(make_record(99), 99)
    half = band(fitted, other, smooth)
    scores = score(other, predict(fitted, other), smooth, half)
    assert (scores.coverage > 0.9).all()
    assert (scores.rmse_lowpassed < scores.rmse).all()
    assert (scores.r2 > 0.9).all()
    baseline = baseline_current(other, least_squares_coefficients(study))
    none = np.zeros_like(baseline)
    assert scores.rmse_lowpassed[2] < score(other, baseline, smooth, none).rmse_lowpassed[2]


def test_a_band_covers_another_day(fitted: CurrentFit) -> None:
    """Friction 17 % higher than in all recordings of a fit that leaves hardly anything."""
    fit, other = with_bands(fitted, 0.01), make_record(99)
    friction = friction_current(fit, other)
    warm = replace(other, current=predict(fit, other) + 0.17 * friction)
    half = band(fit, warm, smooth)
    assert score(warm, predict(fit, warm), smooth, half).coverage.min() == 1.0
    within = np.full_like(friction, 0.01)
    assert score(warm, predict(fit, warm), smooth, within).coverage.max() < 0.5


def with_bands(fit: CurrentFit, half: float) -> CurrentFit:
    """A fit whose bands are of a width [A], the same in every state."""
    states = "moving", "reversing", "standing", "unknown"
    bands = {f"band_{state}": half for state in states}
    return replace(fit, joints=tuple(replace(joint, **bands) for joint in fit.joints))


@pytest.mark.parametrize(
    ("day", "std"),
    [("2020-01-17", 0.006), ("2020-01-12", 0.0197), ("2020-03-01", 0.0424), ("", 0.0996)],
)
def test_a_band_widens_with_the_days_from_the_nearest_recording(
    fitted: CurrentFit, day: str, std: float
) -> None:
    """Dates of the fit are 17 January and 5 February; a recording without one is a season apart,
    unless it follows another one.
    """
    dates = ("2020-01-17", "2020-02-05")
    fit = replace(with_bands(fitted, 0.0), dates=dates)
    other = replace(make_record(99), day=day)
    friction = np.abs(smooth(friction_current(fit, other), other))
    np.testing.assert_allclose(
        band(fit, other, smooth), NORMAL95 * std * friction, rtol=5e-3, atol=1e-9
    )
    undated_fit, undated = replace(fit, dates=()), replace(other, day="")
    np.testing.assert_allclose(
        band(undated_fit, undated, smooth), NORMAL95 * 0.0996 * friction, rtol=5e-3, atol=1e-9
    )
    states = dict.fromkeys(OF_MOTION, np.tile(other.q[0], (2, 1)))
    before = Motion(time=other.period * np.arange(2), segment=np.zeros(2, dtype=int), **states)
    following = replace(undated, before=[before])
    friction = np.abs(smooth(friction_current(fit, following), following))
    np.testing.assert_allclose(
        band(undated_fit, following, smooth), NORMAL95 * 0.006 * friction, rtol=5e-3, atol=1e-9
    )


def test_a_fit_knows_the_dates_of_its_recordings(study: list[CurrentSamples]) -> None:
    days = ["2020-02-05", "", "2020-01-17", *[""] * len(study)]
    dated = [replace(record, day=day) for record, day in zip(study, days, strict=False)]
    assert fit_currents(dated[:3], smooth, prior()).dates == ("2020-01-17", "2020-02-05")


def test_what_errs_where_a_joint_turns_widens_that_band(study: list[CurrentSamples]) -> None:
    turns = [motion_states(own, smooth) == MotionState.REVERSING for own in study]
    turning = [
        replace(own, current=own.current + 0.3 * rows)
        for own, rows in zip(study, turns, strict=True)
    ]
    plain, shaken = (fit_currents(records, smooth, prior()).joints for records in (study, turning))
    for before, after in zip(plain, shaken, strict=True):
        widened = after.band_reversing / before.band_reversing
        assert widened > 1.3 * after.band_moving / before.band_moving


def test_one_short_recording_is_as_certain_as_its_blocks() -> None:
    """Of 10 s there is one stretch: it alone tells nothing of how certain a result is."""
    inside, width = [], []
    for seed in range(10):
        fit = fit_currents(noisy([seed], seconds=10.0), smooth, prior())
        for row in parameters(fit):
            if row.name == "coulomb":
                low, high = row.interval
                inside.append(low <= FRICTION[row.joint - 1][0] <= high)
                width.append((high - low) / FRICTION[row.joint - 1][0])
    assert np.mean(inside) > 0.9
    assert np.median(width) < 3


def test_a_band_of_short_recordings_is_of_all_together() -> None:
    """None of 1.8 s alone is long enough; a joint without a band has no coverage either."""
    fit = fit_currents(noisy(range(12), seconds=1.8), smooth, prior())
    assert all(0.01 < joint.band_moving < 1.0 for joint in fit.joints)
    other = with_noise(make_record(99), 99)
    unknown = np.full_like(other.current, np.nan)
    assert np.isnan(score(other, predict(fit, other), smooth, unknown).coverage).all()


def test_bands_are_of_paths_left_out_and_usual_where_there_are_none(
    study: list[CurrentSamples], fitted: CurrentFit
) -> None:
    one = fit_currents(study[:1], smooth, prior())
    for alone, joint, true in zip(one.joints, fitted.joints, FRICTION, strict=True):
        coulomb = alone.estimate.coefficients[2]
        in_motion, turning, standing, unknown = NORMAL95 * np.array(UNSEEN_ERRORS) * coulomb
        assert 1 <= alone.band_moving / in_motion < 1.5
        assert 1 <= alone.band_reversing / turning < 1.5
        assert alone.band_standing >= standing
        assert alone.band_unknown >= 0.999 * unknown
        least = NORMAL95 * LEAST_ERRORS[2] * joint.estimate.coefficients[2]
        assert joint.band_standing >= 0.999 * least
        assert 0.01 < joint.band_moving * CONSTANT[0] < 2 * true[0]
        assert alone.doubt is not None
        assert joint.doubt is None


def test_a_band_of_one_path_holds_the_noise_of_another() -> None:
    """Slow noise of 0.8 of Coulomb friction, as of a UR3, which the fit itself tells."""
    first, other = (
        replace(own, current=own.current + 0.8 * wander(own, seed))
        for seed, own in enumerate((make_record(1), make_record(99)))
    )
    fit = fit_currents([first], smooth, prior())
    held = score(other, predict(fit, other), smooth, band(fit, other, smooth)).coverage
    assert held.min() > 0.9


def wander(record: CurrentSamples, seed: int) -> Array:
    """Return noise (N, 6) [A] below the low-pass, with each joint's Coulomb friction as its RMS."""
    drawn = np.random.default_rng(seed).standard_normal(record.current.shape)
    noise = np.nan_to_num(smooth(drawn, record))
    coulomb = np.array([own[0] for own in FRICTION]) / np.array(CONSTANT)
    return noise / np.sqrt(np.mean(noise**2, axis=0)) * coulomb


def test_errors_along_few_paths_count_with_a_usual_error() -> None:
    residual, once = np.full(200, 0.3 * NORMAL95), np.zeros(200, int)
    few, many = (unseen_error(residual, np.arange(200) % paths, once, 0.8) for paths in (2, 100))
    assert few == pytest.approx(np.hypot(0.3, 0.8 / np.sqrt(2)))
    assert 0.3 < many < 0.305
    assert unseen_error(residual[:5], np.arange(5), once[:5], 0.8) == 0.8


def test_student_s_t_of_dates_replaces_a_usual_error_that_is_larger() -> None:
    """Of twelve paths on three dates, t is 4.303 / 1.96; of those of one date, 2.201 / 1.96."""
    residual, path = np.full(240, 0.3 * NORMAL95), np.arange(240) % 12
    for days, t in ((3, 4.303), (1, 2.201)):
        known = residual, path, path % days
        assert unseen_error(*known, 9.0) == pytest.approx(0.3 * t / NORMAL95, rel=1e-3)
        assert unseen_error(*known, 0.1) == pytest.approx(np.hypot(0.3, 0.1 / np.sqrt(12)))


def test_what_holds_a_joint_to_either_side_is_in_the_band_whole() -> None:
    """Where one path in eight errs by 1, its root mean square alone would leave it out."""
    path = np.arange(800) % 80
    held = np.where(path % 8 == 0, 1.0, 0.1)
    assert NORMAL95 * unseen_error(held, path, 0 * path, 0.0) == pytest.approx(1.0)
    assert NORMAL95 * np.sqrt(np.mean(held**2)) < 0.8


def test_without_a_recording_no_band_is_narrower_than_with_one(study: list[CurrentSamples]) -> None:
    friction = np.array(FRICTION).T
    typical = {
        name: Typical(value, 0.25 * value + 0.01)
        for name, value in zip(BASE_TERMS, friction, strict=True)
    }
    known = replace(prior(), typical=typical | {"offset": Typical(OFFSET, 0 * OFFSET + 0.5)})
    other = with_noise(make_record(99), 99)
    none, one = expected_fit(known), fit_currents(study[:1], smooth, known)
    wide, narrow = (np.nanmean(band(fit, other, smooth), axis=0) for fit in (none, one))
    assert (wide >= narrow).all()


def test_after_one_path_a_rest_is_mostly_the_usual_one(study: list[CurrentSamples]) -> None:
    """Its external torque lies between those of both fits, that of motion is the fit's."""
    friction = np.array(FRICTION).T
    typical = {
        name: Typical(1.3 * value, 0.25 * value + 0.01)
        for name, value in zip(BASE_TERMS, friction, strict=True)
    }
    known = replace(prior(), typical=typical | {"offset": Typical(OFFSET, 0 * OFFSET + 0.5)})
    one, two = (fitted_friction(study[:paths], known, smooth) for paths in (1, 2))
    assert two.usual is None
    assert fitted_friction(study[:1], prior(), smooth).usual is None
    assert one.usual is not None
    other = make_record(99)
    current, constant = mixed_at_rest(one.fit, one.usual, other)
    own, usual = (
        torque_constants(fit) * (predict(fit, other) - other.current)
        for fit in (one.fit, one.usual)
    )
    mixed, still = constant * (current - other.current), rest_factor(other.qd)
    moves, rests = still < 1e-9, still > 0.999
    assert rests.any(axis=0).all()
    np.testing.assert_allclose(mixed[moves], own[moves], atol=1e-9)
    share = torque_constants(one.fit) / torque_constants(one.usual)
    share = 0.75 * share / (0.75 * share + 0.25)  # of currents over their constants
    np.testing.assert_allclose(mixed[rests], ((1 - share) * own + share * usual)[rests], rtol=1e-2)


def test_without_a_recording_a_band_is_of_dry_friction_and_nothing_else() -> None:
    """As docs/methods.md says: 0.25 of it in motion, 0.5 where it reverses, 1.25 at rest."""
    friction = np.array(FRICTION).T
    typical = {
        name: Typical(value, 1e-6 * value + 1e-9)
        for name, value in zip(BASE_TERMS, friction, strict=True)
    }
    known = replace(prior(), typical=typical | {"offset": Typical(OFFSET, 1e-9 + 0 * OFFSET)})
    for joint in expected_fit(known).joints:
        coulomb = joint.estimate.coefficients[2]
        bands = np.array(joint.bands) / (1.96 * coulomb)
        np.testing.assert_allclose(bands, [0.25, 0.5, 1.25, 1.25], rtol=1e-3)


def test_hubers_regression_with_a_prior_is_ridge_regression_without_outliers() -> None:
    random = np.random.default_rng(0)
    columns, truth = random.normal(size=(300, 3)), np.array([1.0, -2.0, 0.5])
    target, block = columns @ truth, np.arange(300)
    loose = Normal(np.zeros(3), 1e-9 * np.eye(3))
    np.testing.assert_allclose(
        regress(columns, target, block, loose).coefficients, truth, rtol=1e-5
    )
    tight = Normal(np.ones(3), 1e15 * np.eye(3))
    np.testing.assert_allclose(regress(columns, target, block, tight).coefficients, 1.0, rtol=1e-3)


# The bootstrap, over recordings and over blocks within them


def test_blocks_add_up_to_the_normal_equations() -> None:
    random = np.random.default_rng(0)
    columns, (curvature, pull) = random.normal(size=(30, 4)), random.normal(size=(2, 30))
    block = random.integers(0, 3, 30)
    sums = block_sums(columns, curvature, pull, block, 4)
    for one in range(4):
        own = block == one
        matrix = columns[own].T @ (columns[own] * curvature[own, None])
        np.testing.assert_allclose(sums[one, :, :4], matrix, atol=1e-12)
        np.testing.assert_allclose(sums[one, :, 4], columns[own].T @ pull[own], atol=1e-12)


def test_a_mean_over_units_has_the_error_of_its_units() -> None:
    """Of twelve recordings of ten blocks each that differ from one another, not within."""
    random = np.random.default_rng(1)
    unit = np.repeat(np.arange(12), 10)
    value = random.normal(size=12)[unit]
    counts = draw_units(unit, np.random.default_rng(2))
    means = (counts @ value / counts.sum(axis=1))[:, None]
    error = standard_error(means, 0 * means, 12)
    assert error[0] == pytest.approx(np.std(value[::10], ddof=1) / np.sqrt(12), rel=0.1)


def test_the_larger_spread_counts_and_few_units_widen_theirs() -> None:
    normal = np.random.default_rng(3).normal(size=(20_000, 1))
    for units, factor in ((1, 1.0), (2, np.sqrt(2)), (5, np.sqrt(5 / 4))):
        assert standard_error(normal, 0 * normal, units)[0] == pytest.approx(factor, rel=0.02)
    assert standard_error(normal, 3 * normal, 2)[0] == pytest.approx(3.0, rel=0.02)


def test_a_spread_is_a_standard_deviation_without_the_tails() -> None:
    values = np.random.default_rng(4).normal(0, [1.0, 5.0], (20_000, 2))
    np.testing.assert_allclose(spread(values), [1, 5], rtol=0.03)
    values[:1000] = 1e6
    np.testing.assert_allclose(spread(values), [1, 5], rtol=0.15)


@pytest.mark.parametrize(("units", "freedom"), [(1, 1), (2, 1), (3, 2), (30, 29)])
def test_an_interval_is_by_students_t(units: int, freedom: int) -> None:
    """One unit counts as two."""
    half = half_width(np.array([1.0, 2.0]), units)
    np.testing.assert_allclose(half, stats.t.ppf(0.975, freedom) * np.array([1.0, 2.0]))
