"""Figures of one recording: the closed loop beside measurement and target, and late packets."""

import numpy as np
import pytest

from ur5lib.pipeline.records.closed_loop import ClosedLoop
from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.recording_figures import older_torque_figure, packet_figure, tracking_figure

COUNT, PERIOD = 200, 0.008


def signals(lost: np.ndarray | None = None) -> Signals:
    time = PERIOD * np.arange(COUNT)
    q = np.outer(np.sin(time), np.arange(1.0, 7.0))
    return Signals(
        time=time,
        segment=np.zeros(COUNT, dtype=int),
        interpolated=np.zeros(COUNT, dtype=bool) if lost is None else lost,
        actual_q=q,
        target_q=q + 0.25,
        target_moment=10 * q,
    )


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


def test_lost_frames_lengthen_the_step_to_the_next_received_one() -> None:
    lost = np.isin(np.arange(COUNT), [28, 29, 31, 32])
    data = packet_figure(signals(lost)).data
    late = data[data["step to this frame [ms]"] > 8.5]
    assert late["time [s]"].tolist() == pytest.approx([0.240, 0.264])
    assert late["step to this frame [ms]"].tolist() == pytest.approx([24, 24])
    assert len(data) == COUNT - 1 - lost.sum()


def test_a_recording_without_lost_frames_has_no_figure_of_them() -> None:
    assert packet_figure(signals()).data.empty
