"""The smallest push by motion and axis: what may be stated of it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from tests.made_tables import gathered
from tests.tried_pushes import COUNT, detected_above, is_resting
from ur5lib.force.smallest_pushes import (
    MIN_TRIALS_OF_A_LIMIT,
    detectable,
    needed,
    pushes_of_arm,
    smallest_pushes,
)
from ur5lib.force.trial_contacts import PUSH_DURATION, Trials
from ur5lib.records import verdicts
from ur5lib.records.friction import Friction
from ur5lib.records.pushes import Reason, SmallestPush
from ur5lib.timeseries.arrays import Array, Mask

AXES = ["x", "y", "z"]


def stated(trials: Trials) -> list[SmallestPush]:
    return [*smallest_pushes(trials, "unseen", paths=2)]


def tried(force: Sequence[float], found: Sequence[bool], speed: float = 0.6) -> Trials:
    """Pushes along x."""
    count = len(force)
    axis = np.zeros(count, dtype=np.int64)
    return Trials(
        np.array(force), axis, np.full(count, speed), np.array(found, bool), np.ones(count)
    )


def test_the_table_has_each_motion_and_axis(tmp_path: Path) -> None:
    """At rest 40 N, in fast motion 10 N; nothing moves slowly."""
    limits = np.where(is_resting(), 40.0, 10.0)
    trials = Trials.joined([detected_above(limits, seed=seed) for seed in range(4)])
    table = gathered(SmallestPush, stated(trials), tmp_path)
    assert {*table["robot"]} == {"ur5"}
    assert [*table["motion"]] == ["at rest"] * 3 + ["fast"] * 3
    assert [*table["axis"]] == AXES * 2
    assert table["value"].to_numpy() == pytest.approx([40.0] * 3 + [10.0] * 3, rel=0.6)
    assert (table["low"] > 0).all()
    assert ((table["low"] < table["value"]) & (table["value"] < table["high"])).all()
    assert (table["std_error"] > 0).all()
    assert table["trials"].sum() == len(trials.force)
    assert table["largest_tried"].to_numpy() == pytest.approx(trials.force.max())
    assert {*table["seconds"]} == {PUSH_DURATION} == {1.0}
    assert {*table["basis"]} == {"unseen"}
    assert table[["bound", "reason"]].isna().all(axis=None)


@pytest.mark.parametrize(("limits", "typical"), [(150.0, 15.0), (100.0, 15.0), (8000.0, 883.0)])
def test_a_push_beyond_the_trials_is_the_largest_one_and_said_to_be_beyond(
    limits: float, typical: float
) -> None:
    """Before, the files had 10,355 N, or nothing where none was found; the report, above 100 N."""
    pushes = stated(detected_above(np.full(COUNT, limits), typical))
    assert len(pushes) > 1
    for row in pushes:
        assert (row.bound, row.value) == (">", pytest.approx(7 * typical))
        assert (row.std_error, row.low, row.high) == (None, None, None)


def test_a_strong_arm_is_pushed_harder() -> None:
    """Before, each push of a KR300, which carries 300 kg, was beyond 100 N."""
    rounds = [detected_above(np.full(COUNT, 900.0), 883.0, seed) for seed in range(4)]
    pushes = stated(Trials.joined(rounds))
    assert {row.bound for row in pushes} == {""}
    for row in pushes:
        assert row.value is not None
        assert 450.0 < row.value < 3000.0
        assert row.largest_tried == pytest.approx(7 * 883.0)


def test_no_push_is_stated_whose_error_exceeds_it() -> None:
    """Before, "0.07 ± 142 N": all pushes were found, so that none shows from which on."""
    force = np.geomspace(5.0, 100.0, 40)
    (row,) = stated(tried(force, force > 0))
    assert (row.value, row.std_error, row.low, row.high) == (None, None, None, None)
    assert (row.bound, row.reason, row.trials) == ("", "undetermined", 40)


def test_poses_without_a_lever_count_apart() -> None:
    """Half of the places need a hundred times the force, which no curve of both would show."""
    force = np.tile(np.geomspace(2.0, 100.0, 60), 2)
    unit = np.repeat([1.0, 100.0], 60)
    trials = replace(tried(force, force > 8 * unit), unit=unit)
    (row,) = stated(trials)
    assert (row.trials, row.blind) == (120, 60)
    assert row.value == pytest.approx(8.0, rel=0.5)


def test_a_push_of_the_stated_size_is_found_at_95_of_100_places() -> None:
    """Poses of other levers; as a detector with a logistic curve finds pushes."""
    random = np.random.default_rng(0)
    unit = np.exp(random.normal(0.0, 0.5, 400))

    def found(force: Array) -> Mask:
        return np.asarray(random.random(400) < 1 / (1 + (force / (5 * unit)) ** -5))

    force = random.permutation(np.geomspace(1.0, 100.0, 400))
    (row,) = stated(replace(tried(force, found(force)), unit=unit))
    assert row.value is not None
    again = [found(np.full(400, row.value)).mean() for _ in range(20)]
    assert 0.92 < np.mean(again) < 0.98


def test_few_trials_determine_nothing() -> None:
    few = MIN_TRIALS_OF_A_LIMIT - 1
    force = np.geomspace(5.0, 100.0, few)
    (row,) = stated(tried(force, force > 20))
    assert (row.value, row.reason, row.trials) == (None, "undetermined", few)


def test_whatever_is_found_a_stated_push_exceeds_its_error() -> None:
    random = np.random.default_rng(0)
    force = np.geomspace(5.0, 100.0, 30)
    for middle in np.geomspace(1.0, 1000.0, 100):
        found = random.random(30) < 1 / (1 + (force / middle) ** -3)
        limit = detectable(tried(force, found), 100.0)
        if limit.value is not None:
            assert limit.value <= 100.0
            assert limit.bound == ">" or (limit.low or 0.0) > 0


def test_one_path_states_no_push() -> None:
    """None was left out to show its errors, so that smaller pushes stand out; what not even so is
    found stays said.
    """
    limits = np.where(is_resting(), 150.0, 10.0)
    rows = [*smallest_pushes(detected_above(limits), "fit", paths=1)]
    assert {row.reason for row in rows} == {"one_path"}
    assert {row.value for row in rows} == {None}
    assert {(row.motion, row.bound) for row in rows} == {("at rest", ">"), ("fast", "")}


def test_its_reasons_are_those_of_verdicts() -> None:
    assert {*get_args(Reason)} <= {*get_args(verdicts.Reason)}


def test_pushes_without_a_fit_say_so() -> None:
    trials = {"unseen": detected_above(np.full(COUNT, 40.0))}
    for paths, reason in ((0, "uncalibrated"), (2, "")):
        assert {row.reason for row in pushes_of_arm(trials, Friction(paths=paths))} == {reason}


def test_pushes_on_fit_recordings_alone_say_so() -> None:
    trials = detected_above(np.full(COUNT, 40.0))
    rows = [*smallest_pushes(trials, "fit", paths=2)]
    assert {(row.basis, row.reason) for row in rows} == {("fit", "fitted")}
    unseen = stated(trials)
    assert [row.value for row in rows] == [row.value for row in unseen]
    assert {(row.basis, row.reason) for row in unseen} == {("unseen", "")}


def test_the_needed_units_are_those_of_a_detector_by_units() -> None:
    random = np.random.default_rng(0)
    unit = np.exp(random.normal(0.0, 0.5, 600))
    force = random.permutation(np.geomspace(1.0, 100.0, 600))
    trials = replace(tried(force, force > 5 * unit), unit=unit, axis=np.arange(600) % 3)
    ((motion, (units, std)),) = needed(trials)
    assert motion == "fast"
    assert units == pytest.approx(5.0, rel=0.4)
    assert 0 < std < units
