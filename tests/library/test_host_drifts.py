"""The drift that devices of one host share."""

from typing import Any

import numpy as np
import pytest

from ur5lib.signals.clocks import UNKNOWN_DRIFT, Clock
from ur5lib.signals.host_drifts import HostDrift, pool, pool_drifts, settle_clocks

HOSTS = {"pc": ["force", "imu"]}
STAMPS: dict[str, Any] = {
    "offset": -0.006,
    "offset_std": 0.006,
    "drift": None,
    "drift_std": None,
    "method": "start stamps",
    "warning": None,
}
SECONDS = 34.0


def by_motion(drift: float, std: float = 1e-4) -> dict[str, Any]:
    return STAMPS | {"drift": drift, "drift_std": std, "method": "angular rate"}


def test_what_motion_told_is_pooled_by_its_error() -> None:
    clocks = {
        "a": {"imu": by_motion(-0.0033, 1e-4)},
        "b": {"imu": by_motion(-0.0034, 2e-4), "force": STAMPS},
        "another run's": {"imu": STAMPS | {"warning": "of another run"}},
        "without": {},
    }
    found = pool_drifts(clocks, HOSTS)["pc"]
    assert found.recordings == ["a", "b"]
    assert found.drift == pytest.approx(-0.00332)
    assert found.std_error == pytest.approx(1e-4 / np.sqrt(1.25))
    assert found.spread == 0


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


def settled(own: dict[str, Any], hosts: dict[str, HostDrift]) -> Any:
    return settle_clocks({"force": own}, hosts, SECONDS)["force"]


def test_start_stamps_take_the_drift_of_their_host() -> None:
    host = HostDrift(["force", "imu"], -0.0033, 3e-5, 4e-5, ["a", "b"])
    clock = settled(STAMPS, {"pc": host})
    assert clock["method"] == "start stamps, drift of its host"
    assert (clock["offset"], clock["drift"]) == (-0.006, -0.0033)
    assert clock["drift_std"] == pytest.approx(np.sqrt(25e-10 + (0.004 / SECONDS) ** 2))
    assert clock["end_std"] == pytest.approx(np.hypot(0.006, SECONDS * clock["drift_std"]))
    assert settled(STAMPS, {"laptop": HostDrift(["imu"], 0.1, 1.0, 1.0, [])})["drift"] is None


def test_a_clock_that_motion_told_stays() -> None:
    host = HostDrift(["force", "imu"], -0.0033, 3e-5, 4e-5, ["a", "b"])
    clock = settled(by_motion(-0.0031), {"pc": host})
    assert (clock["method"], clock["drift"], clock["drift_std"]) == ("angular rate", -0.0031, 1e-4)


def test_an_unknown_drift_is_in_the_error_at_the_end() -> None:
    clock = settled(STAMPS, {})
    assert clock["drift"] is None
    assert clock["end_std"] == pytest.approx(np.hypot(0.006, UNKNOWN_DRIFT * SECONDS))
    assert Clock(0.0, 0.006, 0.0, 0.0, "").end_std(SECONDS) == 0.006
