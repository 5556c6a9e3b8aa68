"""Turn, scale, bias and drift of a force sensor, by the weight of its tool."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.slow_noise import slow_noise
from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.audit.free_reading import (
    FreeReading,
    fit_free_reading,
    fit_sensor_errors,
    response_of,
    slow_covariance,
)
from ur5lib.topics.audit.free_reading import shifts_after_contacts as shifts

PERIOD, SECONDS = 0.01, 60.0
TIME = np.arange(0, SECONDS, PERIOD)
TOOL = Payload(mass=1.2, center_of_mass=(0.01, -0.02, 0.05))
TURN, SCALE = np.deg2rad([3.0, 0.0, 4.0]), np.array([0.97, 0.98, 1.03])
BIAS = np.array([11000.0, -15000.0, 3.0, -290.0, 0.2, 0.1])
DRIFT = np.array([0.5, -0.5, 0.2, 0.02, -0.02, 0.01])  # per minute
NOISE = np.array([0.2] * 3 + [0.006] * 3)


def turning(size: float) -> Array:
    """Gravity in the axes of a flange that turns by angles of this size [rad]."""
    angles = size * np.sin(TIME[:, None] * [0.7, 0.5, 0.9] + np.array([0, 1, 2]))
    return np.array([0, 0, -9.81]) @ Rotation.from_euler("xyz", angles).as_matrix()


def spin(seed: int = 5) -> Array:
    """Angular accelerations of a flange."""
    phases = np.random.default_rng(seed).uniform(0, 6, 3)
    return 2 * np.sin(3 * TIME[:, None] + phases)


def touched(force: float, last: float = 0.0) -> Array:
    """Three contacts of two seconds, after which `last` stays [N]."""
    wrench = np.zeros((len(TIME), 6))
    for start in (10, 25, 40):
        wrench[(start < TIME) & (start + 2 > TIME), 0] += force
        wrench[start + 1 < TIME, 0] += last
    return wrench


def read(pull: Array, contact: Array | float = 0.0, seed: int = 0) -> Array:
    """What a turned, biased and drifting sensor reads, noise included."""
    moment = TOOL.mass * np.array(TOOL.center_of_mass)
    response = response_of(np.concatenate([TURN, SCALE, [TOOL.mass], moment]))
    noise = NOISE * np.random.default_rng(seed).normal(size=(len(TIME), 6))
    return pull @ response.T + BIAS + np.outer(TIME / 60, DRIFT) + contact + noise


def explain(reading: Array, pull: Array, tool: Payload | None = TOOL) -> FreeReading:
    return fit_free_reading(reading, pull, spin(), TIME, PERIOD, tool)


def test_a_response_is_scale_times_turn_times_the_tool_s_wrench() -> None:
    pull, axes = np.array([1.0, -2.0, 3.0]), Rotation.from_rotvec(TURN).as_matrix()
    moment = TOOL.mass * np.array(TOOL.center_of_mass)
    force, torque = np.split(
        response_of(np.concatenate([TURN, SCALE, [TOOL.mass], moment])) @ pull, 2
    )
    np.testing.assert_allclose(force, SCALE * (TOOL.mass * pull @ axes))
    np.testing.assert_allclose(torque, SCALE.mean() * np.cross(moment, pull) @ axes)


@pytest.mark.parametrize("seed", range(3))
def test_turn_scale_bias_and_drift_are_found_between_contacts(seed: int) -> None:
    pull = turning(0.8)
    found = explain(read(pull, touched(15.0), seed), pull)
    tool = fit_sensor_errors(found, TOOL.mass)
    bias_std, drift_std = found.std()
    for value, truth, std in [
        (tool.turn, TURN, tool.turn_std),
        (tool.scale, SCALE, tool.scale_std),
        (tool.center, TOOL.center_of_mass, tool.center_std),
        (found.bias, BIAS, bias_std),
        (found.drift, DRIFT, drift_std),
    ]:
        np.testing.assert_array_less(np.abs(value - truth), 4 * std)
    assert found.seconds == pytest.approx(SECONDS - 3 * 2, abs=3)
    assert tool.turn_std.max() < np.deg2rad(0.2)
    assert tool.scale_std.max() < 0.01
    assert tool.mass == TOOL.mass


def test_without_a_declared_mass_the_scale_is_the_mass_s() -> None:
    pull = turning(0.8)
    tool = fit_sensor_errors(explain(read(pull), pull, None), None)
    np.testing.assert_array_equal(tool.scale, 1.0)
    assert SCALE.min() < tool.mass / TOOL.mass < SCALE.max()


def test_an_arm_that_does_not_turn_tells_no_turn_and_no_scale() -> None:
    pull = turning(0.0)
    found = explain(read(pull), pull)
    tool = fit_sensor_errors(found, TOOL.mass)
    assert tool.turn_std.max() > np.deg2rad(5)
    assert tool.scale_std.max() > 0.1
    np.testing.assert_array_less(np.abs(found.drift - DRIFT), 4 * found.std()[1])
    np.testing.assert_array_less(np.abs(found.bias - BIAS), 2 * found.std()[0])


def test_what_the_motion_does_not_tell_stays_as_uncertain_as_before() -> None:
    """Gravity along z alone: by 0.3 kg and 0.3 of the tool, or by 3 kg without one."""
    pull = turning(0.0)
    for tool, about in [(TOOL, 0.3 + 0.3 * TOOL.mass), (None, 3.0)]:
        found = explain(read(pull), pull, tool)
        assert found.covariance.shape == (30, 30)
        untold = np.sqrt(np.diag(found.covariance))[:18].reshape(6, 3)[:, :2]
        arm = np.repeat([[1.0, 1.0], [0.2, 0.2]], 3, axis=0)  # 1, m: of forces and moments
        np.testing.assert_allclose(untold, about * arm, rtol=1e-3)


def test_a_tool_without_a_mass_has_no_centre() -> None:
    pull = turning(0.8)
    tool = fit_sensor_errors(explain(read(pull), pull), 0.0)
    assert np.isnan([tool.center, tool.center_std]).all()
    assert tool.center.shape == (3,)


def test_contacts_in_quick_succession_tell_no_shift() -> None:
    pull, contact = turning(0.8), np.zeros((len(TIME), 6))
    for start in (10, 12.8, 40):
        contact[(start < TIME) & (start + 2 > TIME), 0] = 15.0
    assert shifts(explain(read(pull, contact), pull), TIME).shape == (1, 6)


@pytest.mark.parametrize("left", [0.0, 2.0])
def test_what_contacts_leave_is_found(left: float) -> None:
    pull = turning(0.8)
    found = shifts(explain(read(pull, touched(15.0, left)), pull), TIME)
    assert found.shape == (3, 6)
    # the drift takes up a part of steps that add up
    assert found[:, 0].mean() == pytest.approx(left, abs=0.5)
    np.testing.assert_allclose(found[:, 1:3], 0, atol=0.2)


def slowly(seed: int, seconds: float) -> Array:
    """A residual of 0.05 N and 1.5 mNm whose correlation falls to 1/e in some seconds."""
    noise = slow_noise(10_000 + seed, (6, len(TIME)), np.exp(-PERIOD / seconds))
    return 0.05 * noise.T * np.array([1.0] * 3 + [0.03] * 3)


def test_intervals_of_bias_and_drift_hold_among_slow_residuals() -> None:
    """Of eight seeds, six components each; what a sensor without slow residuals would state fails.

    48 intervals that hold in 95 % of the cases hold 41 or more with a chance of 99 %.
    """
    pull, short, held = turning(0.8), list[Array](), list[Array]()
    for seed in range(8):
        found = explain(read(pull, touched(15.0), seed) + slowly(seed, 20.0), pull)
        for value, truth, std in zip(
            (found.bias, found.drift), (BIAS, DRIFT), found.std(), strict=True
        ):
            held.append(np.abs(value - truth) < 1.96 * std)
            short.append(np.abs(value - truth) < 1.96 * std / 4)
    bias, drift = np.array(held)[::2], np.array(held)[1::2]
    assert bias.sum() >= 41
    assert drift.sum() >= 41
    assert np.sum(short) < 82


@pytest.mark.parametrize("seconds", [6.0, 100.0])
def test_errors_without_a_slow_part_are_those_of_least_squares(seconds: float) -> None:
    """A polynomial of five terms through white noise; the range of slow parts adds some.

    It adds most to the constant, which a slow part resembles most.
    """
    time = np.linspace(0, seconds, 2000, endpoint=False)
    terms = np.polynomial.legendre.legvander(2 * time / seconds - 1, 4)
    plain = np.sqrt(np.diag(np.linalg.inv(terms.T @ terms)))
    stated = list[Array]()
    for seed in range(5):
        noise = np.random.default_rng(seed).standard_normal(len(time))
        left = noise - terms @ np.linalg.lstsq(terms, noise)[0]
        covariance = slow_covariance(terms, left, time, 1.0, np.zeros(5))
        stated.append(np.sqrt(np.diag(covariance)) / plain)
    assert (np.min(stated, axis=0) > 0.9).all()
    assert (np.mean(stated, axis=0) < [8, 3.5, 2.5, 2.5, 2.5]).all()
