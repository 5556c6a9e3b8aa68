"""The smallest push by speed, and the speeds at which friction is predicted."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.live_arm import friction, robot
from tests.made_records import motion_of, stretch
from tests.made_tables import gathered, record
from tests.made_up_torques import MODEL
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import Gears
from ur5lib.force.trial_contacts import (
    MIN_LARGEST_PUSH,
    MIN_TRIAL_FORCE,
    PAUSE_DURATION,
    PUSH_DURATION,
    Trials,
    Untouched,
    felt_push,
    smallest_force,
    try_each_place,
)
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.validation import (
    MIN_SAMPLES,
    SPEED_BINS,
    ShareBySpeed,
    share_by_speed,
)
from ur5lib.records.currents import Currents
from ur5lib.records.friction import CurrentFit
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.observability.figure import observability_figure
from ur5lib.topics.observability.measure_observability import Judged, at_rest, judged, observability
from ur5lib.topics.observability.rows import LARGEST_PUSH, Observed

PERIOD, COUNT = 0.01, 30_000  # s, samples: five minutes
NOWHERE = (np.nan, np.nan)
EYE = np.broadcast_to(np.eye(6), (COUNT, 6, 6))


def detected_above(limit: Array, most: float = MIN_LARGEST_PUSH) -> Trials:
    """Return trials, of up to a push [N], of a detector whose odds turn where a torque exceeds a
    limit (N,) [Nm].
    """

    def log_odds_of(torque: Array) -> Array:
        return 10 * (np.abs(torque).max(axis=1) - limit)

    speed = np.where(np.arange(COUNT) < COUNT / 2, 0.0, 0.6)
    run = Untouched(EYE, speed, PERIOD, [(0, 3000)])
    return try_each_place(log_odds_of, run, 0.0, np.random.default_rng(0), most)


def test_a_push_is_found_from_the_limit_of_its_place_on() -> None:
    """At rest from 40 N on, in motion from 10 N on; none is tried during the recording's alarm."""
    trials = detected_above(np.where(np.arange(COUNT) < COUNT / 2, 40.0, 10.0))
    assert (len(trials.force), trials.force.min(), trials.force.max()) == (
        89,
        pytest.approx(MIN_TRIAL_FORCE),
        pytest.approx(MIN_LARGEST_PUSH),
    )
    for low, high, limit in ((0.0, 0.1, 40.0), (0.5, 1.0, 10.0)):
        part = trials.within(low, high)
        assert len(part.force) > 30
        np.testing.assert_array_equal(part.found, part.force > limit)
        assert smallest_force(part.force, part.found)[0] == pytest.approx(limit, rel=0.4)


@pytest.mark.parametrize("state", [JointState.MOVING, JointState.STILL])
def test_dry_friction_and_gears_bear_their_part_of_a_push(state: int) -> None:
    """In motion what load friction takes, at rest at most the share of the breakaway torque."""
    torque = np.tile([0.5, -2.0, 8.0, -30.0, 1.0, 0.0], (2000, 1))
    gears = Gears(*(np.full_like(torque, value) for value in (50.0, 0.2, 0.0)))
    time, most = np.arange(2000) * (PUSH_DURATION + PAUSE_DURATION), 0.45 * MODEL.breakaway
    known = np.full(torque.shape, state, np.int8), gears, most, np.random.default_rng(0)
    felt = felt_push(torque, time, *known)
    if state == JointState.MOVING:
        np.testing.assert_allclose(gears.contact_torque(felt)[0], torque)
    else:
        bears = np.sign(torque) * (torque - felt)
        assert (bears >= 0).all()
        assert (bears <= np.minimum(most, np.abs(torque))).all()
        assert bears[:, 3].mean() == pytest.approx(most[3] / 2, rel=0.03)
        twice = felt_push(torque, time // 2, *known)  # two samples of each push
        np.testing.assert_array_equal(twice[::2], twice[1::2])


@pytest.mark.parametrize(("limits", "most"), [(150.0, 100.0), (95.0, 100.0), (4000.0, 2943.0)])
def test_a_push_beyond_the_trials_is_the_largest_one_and_said_to_be_beyond(
    limits: float, most: float
) -> None:
    """Before, the files had 10,355 N, or nothing where none was found; the report, above 100 N."""
    trials = detected_above(np.full(COUNT, limits), most)
    pushes = [
        row for row in observability([trials], []) if row.quantity.startswith("smallest_push_95_")
    ]
    assert len(pushes) > 1
    for row in pushes:
        assert (row.bound, row.value) == (">", pytest.approx(most))
        assert np.isnan(row.std_error)


def test_a_strong_arm_is_pushed_harder() -> None:
    """Before, each push of a KR300, which carries 300 kg, was beyond 100 N."""
    found = [*observability([detected_above(np.full(COUNT, 400.0), 2943.0)], [])]
    pushes = [row for row in found if row.quantity.startswith("smallest_push_95_")]
    assert {row.bound for row in pushes} == {""}
    assert all(200.0 < row.value < 1500.0 for row in pushes)
    assert [row.value for row in found if row.quantity == LARGEST_PUSH] == [pytest.approx(2943.0)]


def test_the_worth_of_the_band_at_rest() -> None:
    """Of a joint, 95 % of the errors at rest lie within half of its band, and all in it."""
    speed = np.tile([0.0, 0.3], 1000)[:, None]
    of_band = np.where(speed == 0.0, np.linspace(0.0, 0.5 / 0.95, 2000)[:, None], 3.0)
    found = [*observability([], [Judged(speed, of_band)])]
    assert [r.value for r in found if r.quantity == "friction_in_band" and r.speed_low == 0] == [1]
    (factor,) = (row for row in found if row.quantity == "rest_band_factor")
    assert factor.value == pytest.approx(0.5, abs=0.001)
    assert factor.samples == 1000
    moving = Judged(speed[1::2], of_band[1::2])
    assert not any(row.quantity.startswith("rest_") for row in observability([], [moving]))


def test_without_a_place_nothing_is_tried() -> None:
    run = Untouched(EYE[:50], np.zeros(50), PERIOD, [])
    random = np.random.default_rng(0)
    trials = try_each_place(lambda torque: -np.ones(len(torque)), run, 0.0, random)
    assert len(trials.force) == len(trials.found) == 0


def test_shares_of_each_range_of_speeds() -> None:
    speed = np.repeat([0.03, 0.3], 100)
    inside = np.arange(200) % 4 > 0
    found = share_by_speed(speed, inside)
    assert found.samples.sum() == 200
    np.testing.assert_allclose(found.share[np.isfinite(found.share)], [0.75, 0.75])
    few = share_by_speed(np.full(MIN_SAMPLES - 1, 0.3), np.ones(MIN_SAMPLES - 1, bool))
    assert np.isnan(few.suffices()).all()


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        ([0.2, 0.5, 0.6, 0.7, 0.95, 0.99, 0.98, 0.97, 0.96], (0.05, np.inf)),
        ([0.2, 0.5, 0.6, 0.7, 0.95, 0.99, 0.98, 0.97, 0.80], (0.05, 1.0)),
        ([0.2, np.nan, 0.6, 0.7, 0.95, np.nan, 0.98, np.nan, np.nan], (0.05, np.inf)),
        ([0.95, 0.2, 0.2, 0.2, 0.2, 0.95, 0.95, 0.95, 0.2], (0.1, 1.0)),
        ([0.1] * 9, NOWHERE),
        ([np.nan] * 9, NOWHERE),
    ],
)
def test_the_range_that_suffices(share: list[float], expected: tuple[float, float]) -> None:
    found = ShareBySpeed(np.array(share), np.full(9, 100.0)).suffices()
    np.testing.assert_array_equal(found, expected)


def test_the_table_has_each_joint_and_push(tmp_path: Path) -> None:
    """Joint 3 is predicted from 0.2 rad/s on, the others at every speed."""
    trials = detected_above(np.full(COUNT, 10.0))
    speed = np.tile(np.repeat(SPEED_BINS[:-1] + 1e-4, 50)[:, None], 6)
    inside = np.ones_like(speed)
    inside[speed[:, 2] < 0.2, 2] = 0.0
    found = observability([trials], [Judged(speed, 2 - inside)])
    table = gathered(Observed, [*found], tmp_path)
    assert {*table["robot"]} == {"ur5"}
    least = table[table["quantity"] == "least_velocity"].set_index("joint")["value"]
    assert least.to_dict() == {1: 0.0, 2: 0.0, 3: 0.2, 4: 0.0, 5: 0.0, 6: 0.0}
    assert (table["quantity"] == "friction_in_band").sum() == 6 * 9
    along = pushes = table[table["quantity"].str.startswith("smallest_push_95_")]
    assert [*along["quantity"].str[-1]] == [*"xyzxyz"]
    assert [*along["speed_low"]] == [0.0] * 3 + [0.25] * 3
    assert along["value"].to_numpy() == pytest.approx(10.0, rel=0.5)
    assert (along["std_error"] > 0).all()
    assert along["samples"].sum() == len(trials.force)
    assert len(observability_figure(table, 0.9, MIN_LARGEST_PUSH).data) == 6 + 6 * 9
    left, _ = observability_figure(table, 0.9, MIN_LARGEST_PUSH).figure.axes
    assert len(left.containers) == 6  # with intervals; none is beyond
    shares = table[table["quantity"] == "friction_in_band"]
    for pushed in (pushes[:0], pushes[:1].assign(speed_high=np.nan)):
        drawing = observability_figure(pd.concat([pushed, shares]), 0.9, MIN_LARGEST_PUSH)
        assert len(drawing.data) == len(pushed) + 6 * 9
        assert len(drawing.figure.axes) == 1 + len(pushed)
        assert ("std_error" in drawing.data) == (len(pushed) == 1)  # so that the caption names them
    assert "bound" not in drawing.data
    beyond = pd.concat([pushes.assign(bound=">"), shares])
    drawing = observability_figure(beyond, 0.9, MIN_LARGEST_PUSH)
    assert "bound" in drawing.data  # so that the caption names the arrows


def test_errors_are_within_the_band_that_is_stated_at_their_speed() -> None:
    """Not within that of motion, 0.1 A, at rest, where a wider one is stated."""
    fit = friction(robot()).fit
    time = 0.1 * np.arange(100)
    resting = (time < 5)[:, None] * np.ones(6)
    own = Currents(
        **stretch(time),
        current_band=0.1 + 0.4 * resting,
        external_torque=0.3 * torque_constants(fit) * np.ones((100, 6)),
    )
    found = judged(motion_of(time, 0 * resting, 1 - resting), own, fit)
    np.testing.assert_array_equal(found.of_band <= 1, resting)
    np.testing.assert_array_equal(found.speed, 1 - resting)


def test_the_band_at_rest_is_told_beside_that_of_motion() -> None:
    joints = [{"band_moving": 0.1, "band_standing": wide} for wide in (0.4, 0.2)]
    found = [*at_rest(record(CurrentFit, {"joints": joints}))]
    assert [(row.joint, row.value) for row in found] == [(1, 4.0), (2, 2.0)]


def test_nothing_is_drawn_of_recordings_that_tell_nothing(tmp_path: Path) -> None:
    table = gathered(Observed, [*observability([], [])], tmp_path)
    assert observability_figure(table, 0.9, MIN_LARGEST_PUSH).data.empty
