"""A force sensor that is mounted otherwise than its readings are read."""

import numpy as np
import pytest

from tests.library.test_force_sensor import GRAVITY, PERIOD, orientations, pushed
from ur5lib.errors import Remark, remark
from ur5lib.force.sensor import fit_offset, mounting_doubt, opposite_axes, wrench_of_environment
from ur5lib.report.findings import in_words

ROTATION = orientations(60, turning=0.8)
TURNED = {"x": [1, -1, -1], "y": [-1, 1, -1], "z": [-1, -1, 1], "sign": [-1, -1, -1]}


def told(signs: list[int], unread: int = 0) -> tuple[list[str], Remark | None]:
    """Of a sensor whose axes have these signs, beside an estimate that errs."""
    reading, wrench = pushed(ROTATION, seed=0)
    offset = fit_offset(reading * [*signs, *signs], GRAVITY @ ROTATION, PERIOD)
    free = reading * [*signs, *signs] - offset.reading(GRAVITY @ ROTATION)
    sensor = wrench_of_environment(free, ROTATION)[:, :3]
    estimate = 0.7 * wrench[:, :3] + np.random.default_rng(1).normal(0, 2, (len(wrench), 3))
    sensor[:unread] = estimate[unread : 2 * unread] = np.nan
    opposite = opposite_axes(sensor, estimate, ROTATION)
    return opposite, mounting_doubt(offset, opposite)


def test_a_sensor_as_mounted_is_not_doubted() -> None:
    assert told([1, 1, 1]) == ([], None)


@pytest.mark.parametrize("signs", TURNED.values(), ids=TURNED)
def test_a_sensor_upside_down_is_doubted(signs: list[int]) -> None:
    opposite, doubt = told(signs)
    assert opposite == [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
    assert doubt is not None
    assert remark("opposite force", axes=opposite) in doubt.values["reasons"]


def test_what_was_not_read_hides_nothing() -> None:
    assert told(TURNED["x"], unread=100) == told(TURNED["x"])


def test_a_tool_that_pulls_upwards_is_told() -> None:
    doubt = told(TURNED["sign"])[1]
    assert doubt is not None
    assert "the weight of the sensor's tool points upwards (-0.3 ±" in in_words(doubt)


@pytest.mark.parametrize(("size", "told"), [(0.95, False), (1.05, True)])
def test_an_axis_is_judged_from_one_newton_on(size: float, told: bool) -> None:
    """Of root mean square, and a twentieth of all that is squared."""
    upright = np.tile(np.eye(3), (200, 1, 1))
    force = size * np.sign(np.sin(np.arange(200)))[:, None] * [0, 1, 0]
    assert opposite_axes(force, -force, upright) == ["y"] * told
    for other, judged in ((4.3 * size, told), (4.4 * size, False)):
        both = force + other * np.array([1, 0, 0])
        assert ("y" in opposite_axes(both, -both, upright)) == judged


def test_without_contact_nothing_is_said() -> None:
    noise = np.random.default_rng(0).normal(0, 0.3, (2, len(ROTATION), 3))
    assert opposite_axes(noise[0], -noise[0], ROTATION) == []
    assert opposite_axes(noise[0], np.full_like(noise[0], np.nan), ROTATION) == []
