"""A fit that contradicts the arm is a stop sign, and so is a recording that does."""

import re
from dataclasses import asdict, replace

import numpy as np
import pytest

from tests.current_study import (
    CONSTANT,
    FRICTION,
    make_record,
    noisy,
    prior,
    smooth,
    with_current,
    with_noise,
)
from tests.made_study import study
from tests.made_tables import record, table
from ur5lib.channels import CURRENT
from ur5lib.checks.files import quality_row
from ur5lib.errors import Remark
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.current_regression import fit_currents, fit_without_each_path
from ur5lib.identification.currents import constants_doubt, parameters, predict, torque_constants
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal
from ur5lib.identification.samples import CurrentSamples
from ur5lib.identification.validation import (
    baseline_current,
    explained_share,
    least_squares_coefficients,
)
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.fits import RemarkRow
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.models import Identification
from ur5lib.records.quality import Contradictions, Quality, contradiction
from ur5lib.report.found import findings, left_out
from ur5lib.report.results import Results
from ur5lib.steps.fit_friction import (
    ContradictionError,
    explained_by_others,
    require_known_constants,
    require_no_stop_sign,
    require_single_runs,
    with_unproven,
)
from ur5lib.steps.fit_residuals import residual_models
from ur5lib.steps.make_tables import remarks
from ur5lib.timeseries.arrays import Array

WRONG = "another arm"


@pytest.fixture(scope="module")
def records() -> list[CurrentSamples]:
    return noisy((1, 2, 3), seconds=12.0)


@pytest.fixture(scope="module")
def fit(records: list[CurrentSamples]) -> CurrentFit:
    return fit_currents(records[:2], smooth, prior())


def known(factor: float, width: float) -> Prior:
    inverse = 1 / (factor * CONSTANT)
    return Prior(Normal(inverse, np.diag((width * inverse) ** -2.0)), np.full(6, 150.0))


def test_known_constants_are_accepted(fit: CurrentFit) -> None:
    require_known_constants(fit, known(1.0, 0.1))
    require_known_constants(fit, known(1.4, 0.05))  # many deviations off, as wrists of real arms
    require_known_constants(fit, known(2.2, 0.3))  # hardly known


@pytest.mark.parametrize("factor", [2.2, 0.4])
def test_constants_of_a_larger_or_smaller_arm_are_a_stop_sign(
    records: list[CurrentSamples], fit: CurrentFit, factor: float
) -> None:
    other = known(factor, 0.1)
    if factor < 1:
        fit = fit_currents(records[:2], smooth, other)
    with pytest.raises(ContradictionError) as sign:
        require_known_constants(fit, other)
    said = sign.value.remark
    assert (said.code, said.kind) == ("contradicting constants", "constants")
    assert said.text.startswith("torque constants contradict the known values (joint 1 with ")


@pytest.mark.parametrize(("half", "stops"), [(0.01, True), (0.2, False)])
def test_constants_that_are_known_by_nothing_stop_nothing(
    fit: CurrentFit, half: float, stops: bool
) -> None:
    """As −79 and −156 Nm/A of 20 s of poor data, whose 1/k may be that of the motor."""
    lost = [
        replace(own, alone=np.full(len(own.estimate.coefficients), -1 / 78.7), alone_half=half)
        for own in fit.joints
    ]
    contradicted = replace(fit, joints=tuple(lost))
    if not stops:
        require_known_constants(contradicted, known(1.0, 0.1))
        return
    with pytest.raises(ContradictionError):
        require_known_constants(contradicted, known(1.0, 0.1))


def test_a_small_constant_of_a_large_error_stops_nothing(fit: CurrentFit) -> None:
    """Nor does one of 0.4 times the known, whose own error is as large as it."""
    vague = []
    for own in fit.joints:
        error = np.full(len(own.unseen), 1 / own.estimate.coefficients[0])
        vague.append(replace(own, estimate=replace(own.estimate, std_error=error)))
    require_known_constants(replace(fit, joints=tuple(vague)), known(2.2, 0.1))


def test_nothing_is_fitted_to_a_recording_with_a_stop_sign() -> None:
    require_no_stop_sign({"a": Contradictions()})
    with pytest.raises(ContradictionError) as sign:
        require_no_stop_sign(
            {
                "a": Contradictions(),
                "b": Contradictions([contradiction(CauseCode.EXCHANGED_JOINTS, "", "wrong")]),
            }
        )
    assert sign.value.remark.code == "contradicting recordings"
    assert "(b)" in sign.value.remark.text


def test_nothing_is_fitted_to_a_run_that_counts_twice() -> None:
    run, other = Quality(fingerprint=[*range(9)]), Quality(fingerprint=[*range(9, 18)])
    require_single_runs({"a": run, "b": other, "without currents": Quality()})
    with pytest.raises(ContradictionError) as sign:
        require_single_runs({"a": run, "b": other, "c": run})
    assert sign.value.remark.code == "copied recordings"
    assert "one run: a and c;" in sign.value.remark.text


def shares_of(records: list[CurrentSamples]) -> Array:
    """The share of the currents' variance that fits to other paths explain."""
    fits = fit_without_each_path(records, smooth, prior())
    shares = explained_by_others(records, fits, smooth)
    assert shares is not None
    return shares


def test_fits_to_other_paths_explain_the_currents_of_a_free_arm(
    records: list[CurrentSamples],
) -> None:
    assert shares_of(records).min() > 0.5
    assert explained_by_others(records[:1], [], smooth) is None


def test_hand_led_currents_are_explained_by_none(records: list[CurrentSamples]) -> None:
    """They follow the hand that leads the arm, and not its torque."""
    others = [make_record(seed, seconds=12.0) for seed in (101, 102)]
    pairs = zip(records[:2], others, strict=True)
    shares = shares_of([replace(own, current=-other.current) for own, other in pairs])
    assert (shares <= 0).sum() > 3
    found = residual_models([], Friction(explained=shares), 2.0)
    assert found == Residuals(refused=found.refused)
    assert found.refused is not None
    assert found.refused.code == "unknown torques"


def test_joints_that_other_paths_do_not_bear_out_are_told(fit: CurrentFit) -> None:
    """But for those that did not move, of which that is said already."""
    shares = np.where(np.arange(6) < 4, 0.5, -0.5)
    rested = replace(fit.joints[5], remarks=(Remark(CauseCode.NO_MOTION, "does not move"),))
    resting = replace(fit, joints=(*fit.joints[:5], rested))
    told = with_unproven(resting, shares, CURRENT)
    codes = [[one.code for one in own.remarks] for own in told.joints]
    assert ["unproven fit" in own for own in codes] == [False] * 4 + [True, False]
    assert with_unproven(fit, None, CURRENT) == fit


@pytest.mark.parametrize(
    ("known", "joints", "refused"), [(2, 6, True), (3, 6, False), (2, 2, False)]
)
def test_a_force_needs_three_joints_or_all(
    fit: CurrentFit, known: int, joints: int, refused: bool
) -> None:
    shares = np.where(np.arange(joints) < known, 0.5, -0.5)
    others = Friction(explained=shares, fit=fit, paths=2)
    told = residual_models([], others, 2.0).refused
    assert (told is not None and "joints 3, 4, 5, 6" in told.text) == refused


def test_explained_shares_are_those_of_a_constant_and_of_the_truth() -> None:
    record = make_record(1, seconds=12.0)
    measured = smooth(record.current, record)
    mean = np.broadcast_to(np.nanmean(measured, axis=0), measured.shape)
    assert explained_share([record], [mean], smooth) == pytest.approx(np.zeros(6), abs=1e-9)
    assert explained_share([record], [record.current], smooth) == pytest.approx(np.ones(6))


def results(signs: int, stopped: str | None) -> Results:
    sign = quality_row(contradiction(CauseCode.EXCHANGED_JOINTS, "", WRONG))
    rows = [{"recording": f"run_{k}"} | vars(sign) for k in range(signs)]
    key, why = ("stopped", stopped) if stopped else ("refused", "too short")
    friction = record(Friction, {key: asdict(Remark(CauseCode.OTHER_REASON, why))})
    told = remarks(Identification(), friction, Residuals())
    rows_of_arm = table(RemarkRow, {"ur5": told}).to_dict("records")
    return study(quality=rows, remarks=rows_of_arm, sensed=[{"recording": "seen", "contacts": 0}])


def test_stop_signs_are_reported_first() -> None:
    first, second, *_ = findings(results(1, "wrong constants"))
    assert first == "Stop sign on “run_0”: another arm. No forces are stated."
    assert second == "Stop sign on ur5: wrong constants. No forces are stated."
    assert left_out(results(1, "wrong constants")) == []
    assert not [one for one in findings(results(0, None)) if "Stop sign" in one]
    assert left_out(results(0, None)) == ["Friction of ur5: too short."]


def test_a_repeated_run_is_no_reason_against_forces() -> None:
    copied = results(1, None)
    copied.tables["quality"]["code"] = Found.SAME_RUN
    assert findings(copied)[0] == "Stop sign on “run_0”: another arm."


def test_of_many_stop_signs_the_first_are_reported_and_the_others_counted() -> None:
    *first, last = findings(results(9, None))
    assert [one.partition("”")[0] for one in first[:3]] == [
        f"Stop sign on “run_{k}" for k in range(3)
    ]
    assert re.fullmatch(r"\d more in quality\.csv.*\.", last)


def without_torque(record: CurrentSamples, joints: list[int]) -> CurrentSamples:
    """The record with currents of friction alone, as an arm has whose inertia they hardly show."""
    still = replace(record, torque=record.torque * ~np.isin(np.arange(6), joints))
    return replace(record, current=with_current(still).current)


def test_a_current_without_torque_keeps_the_known_constant() -> None:
    """Its friction is then right, too; the other joints are as if nothing had happened."""
    records = [with_noise(without_torque(make_record(k), [0, 4]), k) for k in (1, 2, 3)]
    fit = fit_currents(records, smooth, prior(0.3))
    lost = [joint.contradicted is not None for joint in fit.joints]
    assert lost == [True, False, False, False, True, False]
    np.testing.assert_allclose(torque_constants(fit)[[0, 4]], CONSTANT[[0, 4]], rtol=0.01)
    for joint in (0, 4):
        (doubt,) = (
            one for one in fit.joints[joint].remarks if one.code == "current against constant"
        )
        by_itself = fit.joints[joint].contradicted
        assert doubt.constants == pytest.approx((by_itself, CONSTANT[joint]))
    rows = {(row.joint, row.name): row for row in parameters(fit)}
    for joint in (1, 5):
        constant, coulomb = rows[joint, "torque_constant"], rows[joint, "coulomb"]
        assert not constant.determined
        assert constant.std_error == pytest.approx(0.3 * CONSTANT[joint - 1], rel=0.4)
        assert coulomb.interval[0] < FRICTION[joint - 1][0] < coulomb.interval[1]
    assert (constants_doubt(fit)[[0, 4]] > 0.25).all()
    assert (constants_doubt(fit)[[1, 2, 3]] < 0.1).all()
    require_known_constants(fit, prior(0.3))


def test_a_current_without_torque_is_predicted_as_well_as_by_least_squares() -> None:
    """With the known constant in it, the prediction would err by the torque that it lacks."""
    *records, other = (without_torque(make_record(k), [0, 4]) for k in (1, 2, 3, 9))
    noise = [with_noise(own, seed) for seed, own in enumerate(records)]
    fit, plain = fit_currents(noise, smooth, prior(0.3)), least_squares_coefficients(noise)
    errors = other.current - predict(fit, other), other.current - baseline_current(other, plain)
    ours, rival = (np.sqrt(np.nanmean(smooth(own, other) ** 2, axis=0)) for own in errors)
    assert (ours <= 1.05 * rival)[[0, 4]].all()


def test_four_joints_without_torque_are_a_stop_sign() -> None:
    records = [with_noise(without_torque(make_record(k), [0, 1, 2, 4]), k) for k in (1, 2)]
    fit = fit_currents(records, smooth, prior(0.3))
    assert sum(joint.contradicted is not None for joint in fit.joints) == 4
    with pytest.raises(ContradictionError):
        require_known_constants(fit, prior(0.3))
