"""Medians over windows and their intervals, which arm is closer, and where the flange is."""

import numpy as np
import pytest

from ur5lib.robots.description import load_robot, robot_path
from ur5lib.topics.rollout.errors import (
    deviations,
    median_interval,
    rows_of,
    shares,
    sizes,
    why,
)
from ur5lib.topics.rollout.models import IDENTIFIED, STILL
from ur5lib.topics.rollout.windows import HORIZONS

RANDOM = np.random.default_rng(8)


def test_the_interval_of_a_median_holds_it_in_95_percent_of_samples() -> None:
    """At least, as values of the sample end it; of any distribution."""
    for size, most in ((6, 0.99), (25, 0.97), (100, 0.975)):
        low, high = median_interval(RANDOM.exponential(size=(size, 20_000)))
        held = np.mean((low <= np.log(2)) & (np.log(2) <= high))
        assert 0.945 <= held <= most


def test_half_of_the_windows_decide_nothing() -> None:
    assert shares(30, 60)["beaten"] == "open"
    assert shares(45, 60)["beaten"] == "yes"
    assert shares(15, 60)["beaten"] == "no"
    assert shares(6, 6)["closer_high"] == 1.0
    assert shares(0, 6) == {"closer": 0.0, "closer_low": 0.0, "closer_high": pytest.approx(0.459, abs=1e-3), "beaten": "no"}  # fmt: skip # noqa: E501


def test_an_arm_that_stands_still_is_off_by_what_it_would_have_moved() -> None:
    """By joint, and at the flange: the last joint turns it, and does not move it."""
    arm, start = load_robot(robot_path("ur5e")), RANDOM.uniform(-1, 1, (7, 1, 6))
    reached = start + np.array([0, 0, 0, 0, 0, 0.5])
    own = sizes(deviations(arm, start + 0 * reached, reached))
    np.testing.assert_allclose(own[..., 5], np.degrees(0.5))
    np.testing.assert_allclose(own[..., [0, 1, 2, 3, 4, 6]], 0, atol=1e-9)
    about_base = start + np.array([np.pi, 0, 0, 0, 0, 0])
    assert (sizes(deviations(arm, start, about_base))[..., 6] > 100).all()


def test_a_row_compares_each_model_with_the_identified_arm_on_the_same_windows() -> None:
    own = RANDOM.uniform(1, 2, (40, len(HORIZONS), 5))
    noise = RANDOM.normal(size=own.shape)
    found = {IDENTIFIED: own, "worse": 2 * own, "alike": own + 0.01 * noise, STILL: own + noise}
    rows = [*rows_of(found, 0.5 * own[:10], 4)]
    assert len(rows) == 4 * 3 * len(HORIZONS)
    flange = [row for row in rows if row.joint is None and row.horizon_s == HORIZONS[-1]]
    assert [row.model for row in flange] == [*found]
    first, worse, alike, still = flange
    size = np.linalg.norm(own[:, -1, -3:], axis=1)
    assert first.error == pytest.approx(np.median(size))
    assert first.floor == pytest.approx(0.5 * np.median(size[:10]) / np.sqrt(2))
    assert (first.unit, first.windows, first.repeats, first.recordings) == ("mm", 40, 10, 4)
    assert first.beaten is None
    assert (worse.closer, worse.beaten, worse.why, worse.floor) == (1.0, "yes", None, None)
    assert worse.apart == pytest.approx(first.error)
    assert (alike.beaten, alike.why) == ("open", "alike")
    assert still.beaten == "open"
    assert next(rows_of(found, own[:3], 4)).floor is None, "too few repeats"


def test_why_an_arm_is_not_beaten() -> None:
    nan = float("nan")
    assert why("yes", 0.1, 0.9) is None
    assert why("no", 0.1, nan) == "alike"
    assert why("open", 1.0, 0.6) == "repeats"
    assert why("open", 1.0, nan) == "few"
    assert why("no", 1.0, 0.1) == "worse"
