"""Bias, weight and sign of a force sensor, from readings with contacts in them."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from ur5lib.errors import Remark
from ur5lib.force.sensor import (
    SensorOffset,
    fit_offset,
    initial_bias,
    mounting_doubt,
    offset_doubt,
    opposite_axes,
    wrench_of_environment,
)
from ur5lib.force.sensor_drift import force_drift, slow_covariance
from ur5lib.force.trial_contacts import trial_pushes
from ur5lib.records.codes import CauseCode

PERIOD = 0.01
GRAVITY = np.array([0, 0, -9.81])
MASS, CENTER = 0.3, np.array([0.01, -0.02, 0.04])
BIAS = np.array([-5.0, 1.5, -1.0, 0.07, 0.4, -0.1])


def orientations(seconds: float, turning: float) -> np.ndarray:
    time = np.arange(0, seconds, PERIOD)[:, None]
    angles = turning * np.sin(time * np.array([0.7, 0.5, 0.9]) + np.array([0, 1, 2]))
    return Rotation.from_euler("xyz", angles).as_matrix()


def pushed(rotation: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """What a sensor reads of a tool and of pushes in turn; and the wrenches, base axes."""
    random = np.random.default_rng(seed)
    profile, places = trial_pushes(len(rotation), PERIOD)
    wrench = np.zeros((len(rotation), 6))
    for first, last in places:
        direction = random.normal(0, [10, 10, 10, 0.5, 0.5, 0.5])
        wrench[first:last] = profile[first:last, None] * direction
    return felt(wrench, rotation, random), wrench


def held(rotation: np.ndarray, share: float, steady: bool = False) -> np.ndarray:
    """What it reads where a hand presses down for a share of every six seconds, by 20 N."""
    random = np.random.default_rng(0)
    every = round(6 / PERIOD)
    touch = gaussian_filter1d(
        np.arange(len(rotation)) % every >= every * (1 - share), 5.0, output=float
    )
    varying = gaussian_filter1d(random.normal(size=(len(rotation), 6)), 0.3 / PERIOD, axis=0)
    varying *= 0 if steady else np.array([4, 4, 6, 0.3, 0.3, 0.1]) / varying.std(axis=0)
    wrench = touch[:, None] * (np.array([5, 0, -20, 0.3, 0, 0.2]) + varying)
    return felt(wrench, rotation, random)


def felt(wrench: np.ndarray, rotation: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Wrench (N, 6) and tool, base axes, as a biased, noisy sensor reads them."""
    weight = np.zeros_like(wrench)
    weight[:, :3] = MASS * GRAVITY
    weight[:, 3:] = np.cross(rotation @ CENTER, weight[:, :3])
    both = np.reshape(wrench + weight, (-1, 2, 3)) @ rotation
    noise = random.normal(0, [0.05] * 3 + [0.002] * 3, wrench.shape)
    return both.reshape(-1, 6) + BIAS + noise


def test_bias_and_tool_are_found_between_contacts() -> None:
    rotation = orientations(60, turning=0.8)
    reading, wrench = pushed(rotation, seed=0)
    reading[:50] = np.nan
    offset = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    assert 0.3 < offset.free.mean() < 0.9
    assert np.abs(wrench[offset.free, :3]).max() < 0.5
    np.testing.assert_array_less(np.abs(offset.bias - BIAS), 5 * offset.bias_std + 0.002)
    assert offset.mass == pytest.approx(MASS, abs=5 * offset.mass_std)
    assert offset.mass_std < 0.01 * MASS
    np.testing.assert_allclose(offset.center(), CENTER, atol=0.002)
    off = np.abs(offset.moment_arm - MASS * CENTER)
    np.testing.assert_array_less(off, 5 * offset.moment_arm_std + 1e-4, strict=True)
    estimate = wrench_of_environment(reading - offset.reading(GRAVITY @ rotation), rotation)
    error = np.nanmax(np.abs(estimate - wrench), axis=0)
    np.testing.assert_array_less(error, [0.3] * 3 + [0.015] * 3)


def test_a_sensor_without_moments_tells_bias_and_weight() -> None:
    rotation = orientations(60, turning=0.8)
    reading, wrench = pushed(rotation, seed=0)
    whole = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    reading[:, 3:] = np.nan
    offset = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    np.testing.assert_allclose(offset.bias[:3], whole.bias[:3], atol=0.01)
    assert offset.mass == pytest.approx(MASS, abs=5 * offset.mass_std)
    assert np.abs(wrench[offset.free, :3]).max() < 0.5
    unknown = (offset.bias[3:], offset.bias_std[3:], offset.noise[3:], offset.moment_arm)
    assert np.isnan(unknown).all()
    estimate = wrench_of_environment(reading - offset.reading(GRAVITY @ rotation), rotation)
    assert np.abs(estimate - wrench)[:, :3].max() < 0.3
    assert np.isnan(estimate[:, 3:]).all()


def test_without_turning_weight_and_bias_are_one() -> None:
    rotation = orientations(40, turning=0.0)
    reading, wrench = pushed(rotation, seed=2)
    offset = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    assert np.isnan(offset.mass)
    assert np.isnan(offset.center()).all()
    estimate = wrench_of_environment(reading - offset.reading(GRAVITY @ rotation), rotation)
    assert np.abs(estimate - wrench)[:, :3].max() < 0.3


MOUNTINGS = {"ceiling": [180, 0, 0], "wall": [0, 90, 0], "30°": [30, 0, 0], "askew": [50, -20, 70]}


@pytest.mark.parametrize("angles", MOUNTINGS.values(), ids=MOUNTINGS)
def test_a_mounting_changes_neither_tool_nor_bias(angles: list[float]) -> None:
    """The base's axes turn, and with them R_6 and gravity; the sensor reads what it read."""
    rotation = orientations(60, turning=0.8)
    reading, _ = pushed(rotation, seed=0)
    upright = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    base = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    turned = fit_offset(reading, base @ GRAVITY @ (base @ rotation), PERIOD)
    for name in ("bias", "bias_std", "mass", "mass_std", "moment_arm", "moment_arm_std", "noise"):
        np.testing.assert_allclose(getattr(turned, name), getattr(upright, name), atol=1e-8)
    np.testing.assert_allclose(
        turned.reading(base @ GRAVITY @ (base @ rotation)),
        upright.reading(GRAVITY @ rotation),
        atol=1e-8,
    )


def off_without_contact(offset: SensorOffset, rotation: np.ndarray) -> float:
    """The largest error [N] of what the sensor should read without contact."""
    untouched = felt(np.zeros((len(rotation), 6)), rotation, np.random.default_rng(1))
    error = (offset.reading(GRAVITY @ rotation) - untouched)[:, :3]
    return float(np.abs(gaussian_filter1d(error, 20, axis=0)).max())


def few_free(count: int) -> Remark:
    text = f"only {count} samples are without contact, too few for a reliable bias"
    return Remark(CauseCode.FEW_FREE_SAMPLES, text)


@pytest.mark.parametrize("turning", [0.0, 0.8])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.7, 0.8])
def test_a_hand_that_touches_most_of_the_time_is_no_bias(share: float, turning: float) -> None:
    rotation = orientations(60, turning)
    offset = fit_offset(held(rotation, share), GRAVITY @ rotation, PERIOD)
    assert off_without_contact(offset, rotation) < 0.1
    assert offset.agreeing == pytest.approx(1 - share, abs=0.05)
    assert offset.rival < 0.1
    doubt = offset_doubt(offset)
    assert (doubt is None) == (share < 0.5)
    if doubt is not None:
        assert doubt.text.startswith(f"only {offset.agreeing:.0%} of the samples agree")


def test_a_steady_push_is_told_as_a_rival() -> None:
    """As long as the free time, it cannot be told from bias."""
    rotation = orientations(60, turning=0.0)
    offset = fit_offset(held(rotation, 0.45, steady=True), GRAVITY @ rotation, PERIOD)
    assert offset.rival == pytest.approx(0.45, abs=0.05)
    shares = f"{offset.agreeing:.0%} of the samples have one bias, {offset.rival:.0%} another"
    assert offset_doubt(offset) == Remark(CauseCode.TWO_BIASES, shares)


@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value", "ignore:Degrees")
@pytest.mark.parametrize("count", [0, 5])
def test_hardly_any_reading_is_no_failure(count: int) -> None:
    rotation = orientations(5, turning=0.0)
    reading = held(rotation, 0.0)
    reading[count:] = np.nan
    offset = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    assert offset_doubt(offset) == few_free(count)
    assert np.isnan(offset.mass)


@pytest.mark.parametrize("column", [0, 4])
@pytest.mark.parametrize(("jump", "free"), [(3.9, 1.0), (5.0, 0.8)])
def test_no_sensor_is_taken_to_repeat_better_than_a_tenth_of_a_newton(
    column: int, jump: float, free: float
) -> None:
    """Nor than 0.01 Nm: a noise-free one that comes back beside its bias is still untouched."""
    reading = np.tile(BIAS, (2000, 1))
    reading[1600:, column] += jump * (0.1 if column < 3 else 0.01)
    offset = fit_offset(reading, np.tile(GRAVITY, (2000, 1)), PERIOD)
    assert offset.free.mean() == pytest.approx(free, abs=0.02)


def test_the_noise_of_a_sensor_is_measured() -> None:
    """Of ten times the usual noise: a sample in two thousand at most is beyond four of them."""
    random = np.random.default_rng(3)
    deviation = np.array([0.5] * 3 + [0.02] * 3)
    reading = BIAS + random.normal(0, deviation, (4000, 6))
    offset = fit_offset(reading, np.tile(GRAVITY, (4000, 1)), PERIOD)
    np.testing.assert_allclose(offset.noise, deviation, rtol=0.1)
    assert offset.free.mean() > 0.8
    np.testing.assert_allclose(offset.bias_std, deviation / np.sqrt(offset.free.sum()), rtol=0.15)


def test_a_noisier_sensor_in_proportion_has_the_same_offset_in_proportion() -> None:
    random = np.random.default_rng(11)
    reading = BIAS + random.normal(0, [0.5] * 3 + [0.05] * 3, (400, 6))
    pull = np.tile(GRAVITY, (400, 1))
    offset, louder = fit_offset(reading, pull, PERIOD), fit_offset(1000 * reading, pull, PERIOD)
    np.testing.assert_array_equal(louder.free, offset.free)
    for name in ("bias", "bias_std", "noise"):
        np.testing.assert_allclose(getattr(louder, name), 1000 * getattr(offset, name), rtol=1e-9)


@pytest.mark.parametrize("follows", [0.0, 0.6, 0.9])
def test_noise_that_lasts_tells_a_bias_less_well(follows: float) -> None:
    """As the variance of a mean of an autoregressive process has it: (1 + a) / (1 - a)."""
    random = np.random.default_rng(4)
    steps = random.normal(size=(20000, 6)) * np.sqrt(1 - follows**2)
    noise = 0.005 * lfilter([1], [1, -follows], steps, axis=0)
    offset = fit_offset(BIAS + noise, np.tile(GRAVITY, (20000, 1)), PERIOD)
    expected = 0.005 * np.sqrt((1 + follows) / (1 - follows) / 20000)
    np.testing.assert_allclose(offset.bias_std, expected, rtol=0.15)


def test_an_hour_takes_seconds() -> None:
    """At 500 Hz; what is thinned out for the fit is still sorted into free and in contact."""
    rotation = orientations(60, turning=0.8)
    hour = np.tile(np.repeat(np.arange(len(rotation)), 5), 60)
    reading = held(rotation, 0.7)[hour]
    start = time.process_time()
    offset = fit_offset(reading, GRAVITY @ rotation[hour], PERIOD / 5)
    assert time.process_time() - start < 20
    assert 0.15 < offset.free.mean() < 0.3
    assert off_without_contact(offset, rotation) < 0.1


def test_a_thinned_record_keeps_away_from_contacts_as_others_do() -> None:
    """Of touches that set in slowly, the first tenths of a newton would shift the bias."""
    random = np.random.default_rng(9)
    clock = PERIOD * np.arange(21_000)
    touch = 20.0 * np.clip(np.sin(2 * np.pi * clock / 3.0), 0, None) ** 2
    reading = BIAS + random.normal(0, 0.01, (len(clock), 6))
    reading[:, 2] -= touch
    offset = fit_offset(reading, GRAVITY @ upright(len(clock)), PERIOD)
    np.testing.assert_allclose(offset.bias, BIAS, atol=1e-3)
    touched = (touch > 0.5).nonzero()[0]
    assert not offset.free[touched].any()
    assert 1 / 3 < offset.free.mean() < 0.4  # half of the time, but for half a second of each


def test_a_bias_that_wanders_is_still_one() -> None:
    """By a newton each half minute: in any tenth of a second it rests."""
    clock = PERIOD * np.arange(6000)
    reading = BIAS + np.sin(2 * np.pi * clock / 30.0)[:, None] * np.eye(6)[1]
    reading += 1e-3 * np.random.default_rng(10).normal(size=reading.shape)
    offset = fit_offset(reading, GRAVITY @ upright(len(clock)), PERIOD)
    np.testing.assert_allclose(offset.bias, BIAS, atol=0.05)
    assert offset.agreeing == 1.0
    assert offset.free.all()


def upright(count: int) -> np.ndarray:
    return np.tile(np.eye(3), (count, 1, 1))


def test_what_is_free_keeps_a_quarter_second_away_from_any_contact() -> None:
    """Also from one that the record begins with; what was not measured is neither."""
    reading = BIAS + 1e-3 * np.random.default_rng(0).normal(size=(3000, 6))
    touched, unread = [slice(0, 50), slice(1000, 1100)], slice(2000, 2100)
    for part in touched:
        reading[part, 2] -= 20.0
    reading[unread] = np.nan
    offset = fit_offset(reading, GRAVITY @ upright(3000), PERIOD)
    expected = np.ones(3000, bool)
    for part in (slice(0, 75), slice(975, 1125), unread):
        expected[part] = False
    np.testing.assert_array_equal(offset.free, expected)


@pytest.mark.parametrize(("std", "weighed"), [(0.19, False), (0.21, True)])
@pytest.mark.parametrize("about", ["x", "y"])
def test_a_weight_needs_a_turn_by_a_fifth_of_gravity(about: str, std: float, weighed: bool) -> None:
    """Half of the time upright, half tilted: gravity's share of the axis across is 0 or 2 std."""
    tilted = Rotation.from_euler(about, np.arcsin(2 * std)).as_matrix()
    rotation = np.concatenate([upright(1500), np.tile(tilted, (1500, 1, 1))])
    reading = felt(np.zeros((3000, 6)), rotation, np.random.default_rng(0))
    offset = fit_offset(reading, GRAVITY @ rotation, PERIOD)
    assert np.isfinite(offset.mass) == weighed
    assert np.isfinite(offset.moment_arm).all() == weighed


@pytest.mark.parametrize(
    ("agreeing", "rival", "free", "told"),
    [
        (0.8, 0.4, 100, None),
        (
            *(0.8, 0.41, 100),
            Remark(CauseCode.TWO_BIASES, "80% of the samples have one bias, 41% another"),
        ),
        (0.5, 0.2, 100, None),
        (
            *(0.49, 0.2, 100),
            Remark(
                CauseCode.DISPUTED_BIAS,
                "only 49% of the samples agree on one bias, the others count as contact",
            ),
        ),
        (0.8, 0.4, 99, few_free(99)),
    ],
)
def test_an_offset_is_doubted_from_a_share_on(
    agreeing: float, rival: float, free: int, told: Remark | None
) -> None:
    """Of half that agree, of half as many that agree on another, of a hundred free samples."""
    known = fit_offset(np.tile(BIAS, (200, 1)), GRAVITY @ upright(200), PERIOD)
    offset = replace(known, agreeing=agreeing, rival=rival, free=np.arange(200) < free)
    assert offset_doubt(offset) == told


def test_samples_between_those_of_a_slow_sensor_are_none_of_its_own() -> None:
    """Twenty at the robot's times for each: two thousand are a hundred."""
    known = fit_offset(np.tile(BIAS, (2000, 1)), GRAVITY @ upright(2000), PERIOD)
    assert offset_doubt(known, 20.0) is None
    assert offset_doubt(known, 20.3) == few_free(99)


def test_the_first_seconds_are_the_bias() -> None:
    """From the first reading on, to the last within the window."""
    clock = np.arange(100) / 8  # s, exact in binary
    reading = clock[:, None] * np.arange(1.0, 7.0)
    reading[:10] = np.nan
    np.testing.assert_allclose(
        initial_bias(reading, clock, 0.5), np.mean(clock[10:15]) * np.arange(1.0, 7.0)
    )


def test_a_tool_that_a_hand_guides_is_weighed_where_it_is_let_go() -> None:
    """For two thirds of the time, which is too much for least absolute deviations alone."""
    rotation = orientations(60, turning=0.8)
    offset = fit_offset(held(rotation, 0.66), GRAVITY @ rotation, PERIOD)
    assert offset.mass == pytest.approx(MASS, abs=0.01)
    np.testing.assert_allclose(offset.center(), CENTER, atol=0.01)
    np.testing.assert_allclose(offset.bias, BIAS, atol=0.1)


def test_a_push_of_six_deviations_is_no_noise() -> None:
    """Nor does it count for a fifth of the time; the median deviation is that of the rest."""
    random = np.random.default_rng(7)
    reading = BIAS + random.normal(0, [0.5] * 3 + [0.02] * 3, (4000, 6))
    reading[2000:2800, 2] -= 3.2
    offset = fit_offset(reading, GRAVITY @ upright(4000), PERIOD)
    assert not offset.free[2000:2800].any()
    assert offset.free.mean() > 0.6


def test_a_sensor_that_never_comes_back_to_the_same_bias_has_one() -> None:
    """Within a tenth of a newton, though a steady push repeats better than that."""
    random = np.random.default_rng(8)
    beside = np.repeat(np.linspace(-0.15, 0.15, 35), 80)[:, None] * np.eye(6)[0]
    pushed_down = np.tile(-20.0 * np.eye(6)[2], (1200, 1))
    reading = BIAS + np.concatenate([beside, pushed_down])
    offset = fit_offset(
        reading + 1e-5 * random.normal(size=reading.shape), GRAVITY @ upright(4000), PERIOD
    )
    np.testing.assert_allclose(offset.bias, BIAS, atol=0.05)
    assert offset.agreeing == pytest.approx(0.7, abs=0.03)


# A sensor that is mounted otherwise than its readings are read


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


@pytest.mark.parametrize("size", [0.1, 1.0, 50.0])  # of the estimate beside the sensor
@pytest.mark.parametrize(("share", "opposite"), [(0.3, []), (0.9, ["x", "y", "z"])])
def test_an_axis_is_opposite_by_correlation_whatever_the_size(
    size: float, share: float, opposite: list[str]
) -> None:
    """Of -share between white forces, below -0.5 or not."""
    sensor, other = 20 * np.random.default_rng(0).normal(size=(2, 4000, 3))
    estimate = size * (np.sqrt(1 - share**2) * other - share * sensor)
    rotation = np.broadcast_to(np.eye(3), (4000, 3, 3))
    assert opposite_axes(sensor, estimate, rotation) == opposite


def test_a_sensor_as_mounted_is_not_doubted() -> None:
    assert told([1, 1, 1]) == ([], None)


@pytest.mark.parametrize("signs", TURNED.values(), ids=TURNED)
def test_a_sensor_upside_down_is_doubted(signs: list[int]) -> None:
    opposite, doubt = told(signs)
    assert opposite == [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
    assert doubt is not None
    assert f"force along {', '.join(opposite)} of frame 6 is opposite" in doubt.text


def test_what_was_not_read_hides_nothing() -> None:
    assert told(TURNED["x"], unread=100) == told(TURNED["x"])


def test_a_tool_that_pulls_upwards_is_told() -> None:
    doubt = told(TURNED["sign"])[1]
    assert doubt is not None
    told_mass = re.findall(r"tool points upwards \(−([\d.]+) ± [\d.]+ kg\)", doubt.text)
    assert [*map(float, told_mass)] == [pytest.approx(0.3, abs=0.05)]


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


# Drift


def drifting(seed: int, drift: float, correlation: float) -> tuple[np.ndarray, np.ndarray]:
    """A minute of a sensor's forces less bias and tool, with pushes and partly slow errors, and
    what pulls on its tool.
    """
    random, rotation = np.random.default_rng(seed), orientations(60, 0.6)
    minutes = np.arange(len(rotation))[:, None] * PERIOD / 60
    slow = lfilter(
        [np.sqrt(1 - correlation**2)], [1, -correlation], random.normal(size=(6000, 3)), axis=0
    )
    profile, _ = trial_pushes(len(rotation), PERIOD)
    push = np.array([0, 0, 20.0]) * (profile * (minutes[:, 0] < 0.5))[:, None]
    pull = GRAVITY @ rotation
    return push + drift * (minutes - 0.5) + 0.05 * slow + 0.01 * pull, pull


@pytest.mark.parametrize("drift", [0.0, 2.0])
@pytest.mark.parametrize("correlation", [0.0, 0.999])
def test_a_drift_lies_within_its_error(drift: float, correlation: float) -> None:
    """Beside a weight that is off, pushes, and errors that last for ten seconds."""
    found = []
    for seed in range(12):
        forces, pull = drifting(seed, drift, correlation)
        value, std = force_drift(forces, pull, PERIOD * np.arange(len(forces)), PERIOD)
        assert (std < 0.3).all()
        found.append((value - drift) / std)
    assert (np.abs(found) < 1.96).mean() > 0.85


def test_too_little_time_without_contact_tells_no_drift() -> None:
    forces, pull = drifting(0, 0.0, 0.0)
    forces[400:] = 20.0
    value, std = force_drift(forces, pull, PERIOD * np.arange(len(forces)), PERIOD)
    assert np.isnan(value).all()
    assert np.isnan(std).all()


@pytest.mark.parametrize("unit", [1e-8, 1e8])
def test_the_error_of_a_drift_changes_with_its_unit_alone(unit: float) -> None:
    """Also of terms of which one repeats another, as of a tool that keeps its posture."""
    random, time = np.random.default_rng(0), np.arange(0, 20, 0.05)
    terms = np.column_stack([9.81 + 0 * time, 1 + 0 * time, time])
    given = random.normal(size=len(time)), time, 1.0, np.zeros(3)
    own, other = (slow_covariance(factor * terms, *given) for factor in (1.0, unit))
    np.testing.assert_allclose(other * unit**2, own, rtol=1e-6, atol=1e-9 * own.max())


@pytest.mark.parametrize(("correlation", "least", "most"), [(0.0, 1.0, 40.0), (0.9, 19.0, 400.0)])
def test_slow_errors_leave_a_mean_less_sure_than_white_ones(
    correlation: float, least: float, most: float
) -> None:
    """Of N errors, its variance is theirs over N, times 19 by a correlation of 0.9, and more by
    what a hundred blocks leave open.
    """
    random, time = np.random.default_rng(0), np.arange(0, 100, 0.05)
    blocks = lfilter([np.sqrt(1 - correlation**2)], [1.0, -correlation], random.normal(size=200))
    error = np.repeat(blocks[-100:], 20) if correlation else random.normal(size=2000)
    count = 100 if correlation else 2000
    left = error - error.mean()
    (variance,) = slow_covariance(np.ones((2000, 1)), left, time, 1.0, np.zeros(1))[0]
    assert least < variance / (left.var() / count) < most


def test_a_prior_counts_by_its_precision_over_the_weight_of_samples() -> None:
    """A + B / c, where both grow by a factor of c: the fit is the same, its errors are A alone."""
    random, time = np.random.default_rng(0), np.arange(0, 20, 0.05)
    terms = np.column_stack([np.sin(time), 1 + 0 * time, time])
    given = terms, random.normal(size=len(time)), time
    prior = np.array([4.0, 1.0, 2.0])
    one, two, four = (slow_covariance(*given, 0.1 * c, prior * c) for c in (1.0, 2.0, 4.0))
    np.testing.assert_allclose(one - two, 2 * (two - four), rtol=1e-9)
    assert (np.diag(one) > np.diag(two)).all()
