"""How late the clocks of one host start and how they drift, all of its devices alike."""

from dataclasses import replace

import numpy as np
import pytest

from ur5lib.signals.clock import (
    BY_MOTION,
    BY_STAMPS,
    UNKNOWN_DRIFT,
    Clock,
    HostDrift,
    OwnClock,
    SettledClock,
    pool,
    pool_drifts,
    settle_clocks,
)

HOSTS = {"pc": ["force", "imu"]}
STAMPS = OwnClock(
    offset=-0.006,
    offset_std=0.006,
    drift=None,
    drift_std=None,
    method=BY_STAMPS,
    warning=None,
    stamps=-0.006,
)
SECONDS = 34.0


def by_motion(
    drift: float, std: float = 1e-4, late: float = 0.0, stamps: float = -0.006
) -> OwnClock:
    """late: how much later than its stamps say the device's clock began [s]."""
    found = {"offset": stamps + late, "offset_std": 0.005, "stamps": stamps, "method": BY_MOTION}
    return replace(STAMPS, **found, drift=drift, drift_std=std)


def test_what_motion_told_is_pooled_by_its_error() -> None:
    clocks = {
        "a": {"imu": by_motion(-0.0033, 1e-4)},
        "b": {"imu": by_motion(-0.0034, 2e-4), "force": STAMPS},
        "another run's": {"imu": replace(STAMPS, warning="of another run")},
        "without": {},
    }
    found = pool_drifts(clocks, HOSTS)["pc"]
    assert found.recordings == ["a", "b"]
    assert found.drift == pytest.approx(-0.00332)
    assert found.std_error == pytest.approx(1e-4 / np.sqrt(1.25))
    assert found.spread == 0


def test_starts_are_pooled_by_their_distance_from_the_stamps() -> None:
    """The robot's own stamp is off alike for all devices, whatever theirs say."""
    clocks = {
        name: {"imu": by_motion(-0.0033, late=late, stamps=stamps)}
        for name, stamps, late in (("a", 0.1, -0.07), ("b", -2.0, -0.06), ("c", 0.0, -0.065))
    }
    found = pool_drifts(clocks, HOSTS)["pc"]
    assert found.start == pytest.approx(-0.065)
    assert found.start_std_error == pytest.approx(0.005 / np.sqrt(3))
    assert found.start_spread == 0


def test_a_device_on_another_host_tells_nothing() -> None:
    clocks = {"a": {"imu": by_motion(-0.0033), "force": STAMPS}}
    assert pool_drifts(clocks, {"laptop": ["force"]}) == {}


def test_the_spread_between_recordings_is_found() -> None:
    """Over many pools of eight recordings, the stated error of the mean and the spread hold."""
    random = np.random.default_rng(0)
    pooled = []
    for _ in range(400):
        std = random.uniform(5e-5, 3e-4, 8)
        value = -0.0033 + 3e-4 * random.normal(size=8) + std * random.normal(size=8)
        pooled.append(pool(value, std))
    mean, error, spread = np.array(pooled).T
    assert 0.88 < np.mean(np.abs(mean + 0.0033) < 1.96 * error) < 0.97
    assert np.median(spread) == pytest.approx(3e-4, rel=0.15)


def test_one_recording_shows_no_spread() -> None:
    assert pool(np.array([-0.0033]), np.array([1e-4])) == (-0.0033, 1e-4, 1e-4)


def settled(own: OwnClock, hosts: dict[str, HostDrift]) -> SettledClock:
    return settle_clocks({"force": own}, hosts, SECONDS)["force"]


HOST = HostDrift(["force", "imu"], -0.0033, 3e-5, 4e-5, -0.065, 0.002, 0.003, ["a", "b"])


def test_start_stamps_take_start_and_drift_of_their_host() -> None:
    clock = settled(STAMPS, {"pc": HOST})
    assert clock.method == "start stamps, start and drift of its host"
    assert clock.offset == pytest.approx(-0.006 - 0.065)
    assert clock.offset_std == pytest.approx(np.linalg.norm([0.006, 0.002, 0.003]))
    assert clock.drift == -0.0033
    assert clock.drift_std == pytest.approx(np.sqrt(25e-10 + (0.004 / SECONDS) ** 2))
    end = np.hypot(clock.offset_std, SECONDS * clock.drift_std)
    assert clock.end_std == pytest.approx(end)
    other = replace(HOST, devices=["imu"], drift=0.1)
    assert settled(STAMPS, {"laptop": other}).drift is None
    assert settled(STAMPS, {"laptop": other}).offset == STAMPS.offset


def test_a_clock_that_motion_told_stays() -> None:
    clock = settled(by_motion(-0.0031), {"pc": HOST})
    assert (clock.method, clock.drift, clock.drift_std) == ("angular rate", -0.0031, 1e-4)


def test_an_unknown_drift_is_in_the_error_at_the_end() -> None:
    clock = settled(STAMPS, {})
    assert clock.drift is None
    assert clock.end_std == pytest.approx(np.hypot(0.006, UNKNOWN_DRIFT * SECONDS))
    assert Clock(0.0, 0.006, 0.0, 0.0, "").std_after(SECONDS) == 0.006
