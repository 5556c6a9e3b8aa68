"""The thesis's line between current and torque: what it finds, and where it errs."""

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PROJECT
from tests.made_records import signals_of, torques_of
from ur5lib.records.dynamics import Torques
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis import rows
from ur5lib.topics.thesis.current_based import current_on_torque, friction_torque, torque_on_current
from ur5lib.topics.thesis.figure import printed_friction
from ur5lib.topics.thesis.reference import read_reference
from ur5lib.topics.thesis.torque_lines import (
    PublishedConstants,
    current_torque,
    published_constants,
)

COUNT, PERIOD = 4000, 0.008
BLOCK = np.arange(COUNT) // 250
K, B = np.array([9.0, 11.0, 10.0, 7.0, 8.0, 8.5]), np.array([0.1, 0.5, -0.2, 0.3, 0.2, 0.0])


def samples(mean: float, noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Currents and torques on the line (K, B), and noise in the currents."""
    random = np.random.default_rng(seed)
    torque = mean + 10 * random.standard_normal((COUNT, 6))
    return (torque - B) / K + noise * random.standard_normal((COUNT, 6)), torque


@pytest.mark.parametrize("mean", [44.0, -44.0])
def test_noise_of_the_current_moves_the_offset_towards_the_mean_torque(mean: float) -> None:
    """Of the torque on the current; that of the current on the torque finds the truth."""
    current, torque = samples(mean, 0.8)
    forward, reverse = (
        line(current, torque, BLOCK) for line in (torque_on_current, current_on_torque)
    )
    shrunk = 10**2 / (10**2 + (0.8 * K) ** 2)  # of the slope, var(τ) / (var(τ) + var(noise))
    np.testing.assert_allclose(forward.torque_constant, K * shrunk, rtol=0.05)
    np.testing.assert_allclose(forward.offset, mean * (1 - shrunk) + B * shrunk, rtol=0.1)
    assert (np.abs(reverse.torque_constant - K) < 4 * reverse.torque_constant_std).all()
    assert (np.abs(reverse.offset - B) < 4 * reverse.offset_std).all()


def test_standard_errors_are_the_scatter_over_repetitions() -> None:
    lines = [torque_on_current(*samples(5, 0.5, seed), BLOCK) for seed in range(40)]
    scatter = np.std([line.offset for line in lines], axis=0, ddof=1)
    stated = np.mean([line.offset_std for line in lines], axis=0)
    np.testing.assert_allclose(stated.mean(), scatter.mean(), rtol=0.2)


@pytest.fixture
def recorded(ur5: Robot) -> tuple[Signals, Torques]:
    """Currents by the printed constants; joint 6 rests, and every tenth frame was lost."""
    assert ur5.current_to_torque
    assert ur5.friction
    time = np.arange(COUNT) * PERIOD
    qd = 0.5 * np.sin(time[:, None] * np.linspace(0.5, 1.5, 6)) * [1, 1, 1, 1, 1, 0]
    rigid = 20 * np.cos(time[:, None] * np.linspace(0.3, 0.9, 6)) + 5
    constants = ur5.current_to_torque
    total = rigid + friction_torque(qd, ur5.friction)
    current = (total - constants.offset) / constants.torque_constant
    lost = np.arange(COUNT) % 10 == 7
    current[lost] = 99.0
    known = {"interpolated": lost, "target_qd": qd, "actual_current": current}
    return signals_of(time, 0 * qd, **known), torques_of(time, {"C": rigid})


def test_the_printed_constants_come_back(ur5: Robot, recorded: tuple[Signals, Torques]) -> None:
    assert ur5.current_to_torque
    found = published_constants(current_torque(ur5, *recorded))
    for line in found.lines.values():
        for name in ("torque_constant", "offset"):
            expected = np.array(getattr(ur5.current_to_torque, name))
            np.testing.assert_allclose(getattr(line, name)[:5], expected[:5], rtol=1e-6)
            assert np.isnan(getattr(line, name)[5])
    np.testing.assert_allclose(found.correlation[:5], 1)
    assert [row.joint for row in rows.torque_constants(found)] == 2 * [1, 2, 3, 4, 5]
    assert (found.correlation_without_friction[:5] < 0.999).all()


def test_the_figures_show_every_received_sample_and_the_printed_line(
    ur5: Robot, recorded: tuple[Signals, Torques]
) -> None:
    samples = current_torque(ur5, *recorded)
    rigid, total = printed_friction(samples, ur5.current_to_torque)
    assert len(rigid.data) == len(total.data) == COUNT * 9 / 10
    for axis in total.figure.axes[:5]:
        dots, line = (each.get_xydata() for each in axis.lines)
        np.testing.assert_allclose(np.interp(dots[:, 0], *line.T), dots[:, 1], atol=1e-9)
    assert all(len(axis.lines) == 1 for axis in rigid.figure.axes)


def test_an_arm_without_printed_friction_has_no_such_constants(
    ur5: Robot, recorded: tuple[Signals, Torques]
) -> None:
    other = ur5.model_copy(update={"friction": None})
    assert published_constants(current_torque(other, *recorded)).lines == {}
    assert [*rows.torque_constants(PublishedConstants())] == []
    assert all(drawn.data.empty for drawn in printed_friction(None, ur5.current_to_torque))


def test_the_reference_prints_the_constants_of_the_arm(ur5: Robot) -> None:
    """Both files quote Equation 6.6: the arm for the printed forces, the reference to compare."""
    path: Path = PROJECT / "workflow" / "studies" / "thesis_reference.yaml"
    printed = read_reference(path).printed["current_torque"]
    assert ur5.current_to_torque
    assert printed.values["k"] == ur5.current_to_torque.torque_constant
    assert printed.values["b"] == ur5.current_to_torque.offset
