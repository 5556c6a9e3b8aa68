"""The thesis's figures: what stands beside what, with which errors."""

import numpy as np
import pytest

from tests.made_records import signals_of
from ur5lib.records.signals import Signals
from ur5lib.topics.thesis.draw_published_filters import draw_published_filters
from ur5lib.topics.thesis.figure import older_torque_figure, tracking_figure
from ur5lib.topics.thesis.records import ClosedLoop

TIME = 0.008 * np.arange(60)


def signals() -> Signals:
    """Joints that swing, each by its own size."""
    q = np.outer(np.sin(TIME), np.arange(1.0, 7.0))
    return signals_of(TIME, q, target_q=q + 0.25, target_moment=10 * q)


def closed_loop(gains: str) -> ClosedLoop:
    own = signals()
    return ClosedLoop(time=own.time, segment=own.segment, q={gains: own.actual_q - 0.5})


def test_the_loop_stands_beside_measurement_and_target_with_their_errors() -> None:
    data = tracking_figure(signals(), closed_loop("C"), "C", "q").data
    for joint in range(1, 7):
        measured = data[f"measured, joint {joint} [rad]"]
        for line, offset in (("target", 0.25), ("closed loop, gains C", -0.5)):
            drawn = data[f"{line}, joint {joint} [rad]"]
            assert (drawn - measured).to_numpy() == pytest.approx(offset)
            error = data[f"error of {line}, joint {joint} [rad]"]
            assert error.to_numpy() == pytest.approx(-offset)


def test_gains_that_were_not_simulated_are_not_drawn() -> None:
    assert tracking_figure(signals(), closed_loop("C"), "[21]", "q").data.empty


def test_a_printed_mean_error_stands_beside_the_errors_of_what_can_be_rebuilt() -> None:
    own, printed = signals(), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    data = older_torque_figure(own, {"Model C": 8 * own.actual_q}, printed).data
    assert data["error of [21], printed mean, joint 3 [Nm]"].to_numpy() == pytest.approx(3)
    expected = 0.2 * data["controller's target_moment, joint 2 [Nm]"].to_numpy()
    assert data["error of Model C, joint 2 [Nm]"].to_numpy() == pytest.approx(expected)


def test_filters_of_the_thesis_run_one_way() -> None:
    _, *names = draw_published_filters(4, 10.0)["filters_published"].data
    assert [name.rpartition(", ")[2].removesuffix(" [1]") for name in names] == [
        "both ways",
        "one way",
        "one way",
    ]
