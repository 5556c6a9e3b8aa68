"""What a verdict must not say: each a way in which right numbers misled."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_study import (
    DOUBTED,
    constant,
    finding,
    judged_anew,
    predicted,
    push,
    rates,
    sensed,
    state,
    study,
    torques,
    touched,
    verdicts_of,
)
from tests.typeset_page import headline_of, page_of, plain, tables_of
from ur5lib.force.estimators import UNGATED
from ur5lib.judging.contacts import upper_limit
from ur5lib.records.codes import Found
from ur5lib.report.found import findings
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.steps.judge_study import judged

TOUCHED = finding("error", Found.TOUCHED, device="force", detail="the sensor reads up to 33 N")
"""The finding that a sensor reads contacts on `seen`, whose role is validate."""


def card_of(results: Results, question: str) -> str:
    """The text of a card of the first screen, with its evidence."""
    (card,) = page_of(results).xpath(f"//article[@data-question='{question}']")
    return plain(card.text_content())


def test_1_real_contacts_lead_and_trials_are_compared_with_them() -> None:
    """All real pushes from 22 N were found, although trials ask for 93 N."""
    contacts = sensed((30.0, "found"), (22.0, "found"), (21.0, "missed"), (25.0, "merged"))
    trials = [push("at rest", "z", 93.0), push("fast", "x", 20.0)]
    results = study({"pushed": None}, contact_errors=contacts, pushes=trials)
    found, from_, *_ = verdicts_of(results, "contacts")
    assert (found.count, found.of, found.basis) == (2, 4, "real")
    assert (from_.value, from_.count) == (22.0, 3)
    hardest = verdicts_of(results, "pushes")[0]
    assert (hardest.value, hardest.motion, hardest.basis) == (93.0, "at rest", "trial")
    assert hardest.rival_value == 22.0
    told = headline_of(page_of(results))
    assert "2 of 4 contacts" in told
    assert "93" not in told
    assert "1 of 4 contacts missed, the largest: 21.0 N" in card_of(results, "contacts")
    pushed = card_of(results, "pushes")
    assert "93 N" in pushed
    assert "No real contact at rest missed from: 22.0 N" in pushed


def test_1_no_number_whose_error_exceeds_it_and_none_of_fits_without_the_word() -> None:
    unknown = [push("slow", "x", None, reason="undetermined")]
    (row,) = verdicts_of(study(pushes=unknown), "pushes")
    assert (row.value, row.reason) == (None, "undetermined")
    fitted = [push("slow", "x", 30.0, basis="fit", reason="fitted")]
    assert verdicts_of(study(pushes=fitted), "pushes")[0].basis == "fit"
    assert headline_of(page_of(study(pushes=fitted))) == ""
    assert "on fit recordings" in card_of(study(pushes=fitted), "pushes")
    alone = study(contact_errors=sensed((30.0, "found"), recording="fitted"))
    assert verdicts_of(alone, "contacts")[0].basis == "fit"
    assert "contacts" not in headline_of(page_of(alone))
    assert "on fit recordings" in card_of(alone, "contacts")


def test_2_a_sensor_beats_a_role() -> None:
    """A validate recording that is touched tests no currents, and its alarms are not false."""
    rows = predicted(1.3)
    searched = [rates("seen", 2.0, contacts=1, force_class_n=5.0)]
    tables = {"current_rmse": rows, "detection": searched, "friction": [constant(1, 10.0)]}
    results = study(quality=[TOUCHED], contact_errors=sensed((33.0, "missed")), **tables)
    assert state(study(**tables), "currents")[0] == "do not use"
    assert state(results, "currents") == ("not determined", "touched")
    assert [row.role for row in judged(results).false_alarms] == []
    use = {
        row.purpose: (row.use, row.reason)
        for row in judged(results).uses
        if row.recording == "seen"
    }
    assert use["currents"] == ("no", "touched")
    assert use["contacts"] == ("yes", "")
    assert "fit" not in use
    assert state(results, "recordings") == ("usable", "error")
    assert next_steps(results)[0].sentence.startswith("Give “seen” the role contact")


def test_3_no_limit_of_finding_doubts_what_was_found() -> None:
    """Ten of twelve alarms that a sensor confirms were called doubtful."""
    alarm = {"recording": "pushed", "estimate": "Fmap", "kind": "contact", "peak_s": 1.0}
    results = study(contacts=[alarm], pushes=[push("slow", "x", 90.0)])
    assert not [one for one in findings(results) if "doubt" in one]
    assert "doubt" not in plain(page_of(results).text_content()).replace("no doubt", "")


def test_4_the_total_of_friction_is_what_is_judged() -> None:
    """Coulomb is up to 52 % above friction at v → 0, and terms do not add up to a total."""
    total = {"robot": "ur5", "value": 5.0, "use": "yes", "load": 1.0}
    rows = [
        total
        | {"joint": joint, "parameter": f"total_{speed}", "low": 5 - half, "high": 5 + half}
        | {"state": "good" if joint == 1 else "usable"}
        for joint, half in ((1, 1.0), (2, 6.0))
        for speed in ("0", "0.1", "0.5", "1")
    ]
    widest, known, sure = verdicts_of(study(friction=rows), "friction")
    assert (widest.value, widest.joint, widest.motion) == (20.0, 1, "at 0 rad/s")
    assert (known.count, known.of, known.reason) == (4, 8, "undetermined")
    assert (sure.count, sure.of) == (4, 8)
    rows[4] |= {"use": "no", "determined": "no"}
    first, second = tables_of(study(friction=[*rows, constant(1, 10.0)]))["friction-totals"]
    assert (first["at 0+ rad/s"], second["at 0+ rad/s"]) == ("5 (4 to 6)", "undetermined")


def test_5_gains_of_unknown_links_are_not_known() -> None:
    rows = [constant(1, 1.0, parameter="gain", use="no", reason="unknown_links")]
    results = study(friction=rows)
    assert state(results, "constants") == ("not determined", "unknown_links")
    assert [row.value for row in verdicts_of(results, "constants")] == [None] * 2  # no width
    assert "95 %" not in card_of(results, "constants")


def test_6_a_floor_is_compared_with_the_error_of_the_same_repeats() -> None:
    """An error of 1 A of another motion is no ten floors of 0.1 A."""
    floor = {"robot": "ur5", "quantity": "current", "joint": 1, "floor": 0.1}
    near, far = ([floor | {"error": error}] for error in (0.25, 0.35))
    rows = predicted(0.4)
    assert state(study(current_rmse=rows, repetition=near), "currents") == ("good", "")
    found = study(current_rmse=rows, repetition=far)
    assert state(found, "currents") == ("usable", "far_above_floor")
    assert judged(found).judged_errors[0].in_floors == pytest.approx(3.5)


def test_7_the_worst_number_is_shown_where_another_decides() -> None:
    rows = predicted(0.2) + [row | {"model": "least_squares"} for row in predicted(0.5)]
    rows[3] |= {"rmse_lowpassed": 0.4}
    rows[10] |= {"rmse_lowpassed": 0.2}
    first, worst, *_ = verdicts_of(study(current_rmse=rows), "currents")
    assert (first.joint, first.reason, first.state) == (5, "rival_equal", "usable")
    assert (worst.joint, worst.value, worst.rank) == (4, 0.4, 2)
    told = plain(page_of(study(current_rmse=rows)).get_element_by_id("currents").text_content())
    assert "RMSE below 2 Hz, relatively the largest: 0.400 A, joint 4" in told
    assert "Joint 5 decides: simple method equal." in told


def test_7_the_largest_error_is_of_all_states() -> None:
    """Joint 1 rests on `seen`, and errs most there."""
    rows = predicted(0.2)
    more = [row | {"recording": "pushed"} for row in predicted(0.2)]
    more[0] |= {"rmse_lowpassed": 0.9}
    results = study({"pushed": "2 3 4 5 6"}, current_rmse=rows + more)
    entries = [one | {"role": "validate"} for one in results.study["recordings"]]
    both = replace(results, study={**results.study, "recordings": entries})
    most = next(row for row in verdicts_of(both, "currents") if row.rank == 3)
    assert (most.value, most.joint, most.recording) == (0.9, 1, "pushed")


def test_8_only_what_may_be_used_is_counted() -> None:
    rows = [constant(1, 10.0), constant(2, 10.0, use="no", reason="unproven")]
    first = verdicts_of(study(friction=rows), "constants")[0]
    assert (first.count, first.of) == (1, 2)


def test_9_without_a_contact_the_page_says_what_would_have_been_seen() -> None:
    trials = [push("at rest", "x", None, bound=">", largest_tried=2943.0), push("fast", "y", 182.0)]
    results = study(pushes=trials)
    hardest, easier, easiest = verdicts_of(results, "pushes")
    assert (hardest.rank, hardest.value) == (1, 2943.0)
    assert hardest.quantity == "trial push of 1 s not found"
    assert (easier.value, easiest.value, easiest.motion) == (182.0, 182.0, "fast")
    both = [*trials, push("at rest", "y", None, bound=">", largest_tried=2000.0)]
    assert verdicts_of(study(pushes=both), "pushes")[0].axis == "x and y"
    assert hardest.axis == "x"
    told = card_of(results, "pushes")
    assert "2943 N" in told
    assert "Trial push of 1 s not found, along x, at rest" in told
    assert "along an axis, best motion 182 N on" in told


def test_10_nothing_is_judged_by_next_to_nothing() -> None:
    """A torque of 1 mNm, a zero of 0 Nm."""
    rows = [row | {"mae_2hz": 0.0005, "zero_mae_2hz": 0.001} for row in torques({"A": 1.0})]
    assert state(study(torque_mae=rows), "links") == ("not determined", "too_small")
    assert {one.reason for one in judged(study(torque_mae=rows)).judged_errors} == {"too_small"}
    rows[0] |= {"mae_2hz": 0.2, "zero_mae_2hz": 1.0}
    assert {row.joint for row in verdicts_of(study(torque_mae=rows), "links")} == {1, None}


def test_11_found_merged_and_missed_are_all_on_every_page() -> None:
    contacts = sensed((30.0, "found"), (8.0, "missed"), (25.0, "merged"), (4.0, "missed"))
    contacts[0] |= {"peak_error": -3.0}
    searched = [rates("pushed", contacts=3, force_class_n=5.0)]
    results = study(contact_errors=contacts, detection=searched)
    rows = {row.quantity: row for row in verdicts_of(results, "contacts")}
    (noticed,) = judged(results).noticed
    assert noticed.found + noticed.merged + noticed.missed == noticed.contacts == 3  # from 5 N on
    assert rows["contacts found"].of == 3
    assert rows["contacts missed, the largest"].count == noticed.missed
    assert rows["mean signed error of found peaks"].value == pytest.approx(-10.0)
    assert noticed.peak_bias == pytest.approx(-0.1)
    (line,) = tables_of(results)["noticed"]
    assert (line["found"], line["missed at [s]"], line["merged at [s]"]) == (
        *("1 of 3", "10.0", "20.0"),
    )
    assert "1 of 3" in card_of(results, "contacts")


@pytest.mark.parametrize("blind", [0.4, 0.93])
def test_12_a_wide_band_is_usable(blind: float) -> None:
    """32 of 35 studies of the stand were condemned for one resting recording."""
    rows = [row | {"zero_in_band95": blind, "band_factor95": 0.3} for row in touched(2.0)]
    results = study(force_mae=rows)
    assert state(results, "force") == (("usable", "blind") if blind > 0.5 else ("good", ""))
    bands = {row.quantity.partition(",")[0]: row for row in verdicts_of(results, "bands")}
    shown = bands["time in contact in which the 95 % band contains zero on all axes"]
    assert shown.value == pytest.approx(100 * blind)


def test_13_the_rival_is_judged_by_the_same_sum_with_its_own_worst_place() -> None:
    """Where we err most, it errs less: a ripple; elsewhere, it errs by 18 N."""
    ours = touched(2.0) + touched(3.5, "seen")
    theirs = [row | {"estimate": UNGATED} for row in touched(18.0) + touched(2.5, "seen")]
    results = study(force_mae=ours + theirs)
    assert state(results, "force") == ("good", "")
    first, worst, *_ = verdicts_of(results, "force")
    assert (first.value, first.rival_value) == (2.75, 10.25)
    assert (worst.value, worst.rival_value) == (3.5, 18.0)
    assert "least squares without a detector at its worst: 18.0 N" in card_of(results, "force")
    better = study(force_mae=ours + [row | {"mae": 1.0} for row in theirs])
    assert state(better, "force") == ("usable", "rival_better")


def test_14_a_contact_off_the_flange_that_is_found_is_no_false_alarm() -> None:
    alarm = {"recording": "pushed", "estimate": "Fmap", "kind": "off_flange", "peak_s": 1.0}
    contacts = sensed((30.0, "found"))
    searched = [rates("pushed", 5.0, contacts=1, force_class_n=5.0, false_alarms_per_min=0.0)]
    results = study(contacts=[alarm] * 5, contact_errors=contacts, detection=searched)
    (noticed,) = judged(results).noticed
    assert (noticed.alarms, noticed.false_alarms) == (5, 0)
    assert all(not row.count for row in verdicts_of(results, "alarms"))


def test_the_upper_limit_of_alarms_is_that_of_poisson() -> None:
    assert [upper_limit(count) for count in (0, 2)] == pytest.approx([2.996, 6.296], abs=1e-3)
    found = judged(study(detection=[rates("seen", 2.0)])).false_alarms
    assert [(row.role, row.days, row.alarms, row.minutes) for row in found] == [
        ("validate", "all", 2, 1.0)
    ]


def test_alarms_on_days_without_a_fit_are_counted_by_themselves() -> None:
    results = study(detection=[rates("seen", 2.0)])
    for day, expected in (
        ("2026-03-01", {"all"}),
        ("2026-03-02", {"all", "without fit", "farthest"}),
    ):
        dates = {"fitted": "2026-03-01", "seen": day}
        entries = [one | {"date": dates.get(one["name"])} for one in results.study["recordings"]]
        dated = judged_anew(results, study={**results.study, "recordings": entries})
        assert {row.days for row in judged(dated).false_alarms} == expected


def test_the_parts_of_an_error_add_up() -> None:
    parts = {"mae_missed": 1.0, "mae_shut": 0.5, "mae_gain": 0.25}
    stds = {"drift_std_x": 0.1, "drift_std_y": 0.4, "drift_std_z": 0.6}
    sensor = {"recording": "pushed", "contacts": 1, "drift_x": 0.3, "drift_y": -0.2, "drift_z": 5.0}
    results = study(force_mae=touched(2.0, **parts, **DOUBTED), sensed=[sensor | stds])
    (row,) = judged(results).error_parts
    assert row.error == row.missed + row.late_alarms + row.gain + row.friction == 2.0
    assert (row.drift_x, row.drift_y, row.drift_z, row.drift_std) == (0.3, -0.2, None, 0.4)
    assert not np.isnan(row.friction)
