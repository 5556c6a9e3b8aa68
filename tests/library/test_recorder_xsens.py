"""The Xsens device, beside an emulated tracker with known readings and faults."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PROJECT
from tests.library.test_recorder_net_ft import record
from ur5lib.errors import InputError
from ur5lib.recorder.device import DeviceLost
from ur5lib.recorder.xsens import Xsens
from ur5lib.stand.lab.delivery import Faults
from ur5lib.stand.lab.emulated import Clock
from ur5lib.stand.lab.xsens_device import XsensDevice
from ur5lib.timeseries.arrays import Array

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

READING = np.array([0.5, -1.0, 9.75, 0.25, 0.0, -0.125, 0.5, 0.25, -0.75])


def steady(_: float) -> Array:
    return READING


@pytest.mark.parametrize("is_legacy", [False, True])
def test_samples_arrive_with_their_counters(is_legacy: bool) -> None:
    with XsensDevice(steady, is_legacy=is_legacy) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        entry = imu.open()
        received, values, lost = record(imu, 2.0)
        imu.close()
    assert entry["rate_hz"] == 256
    assert entry["message"] == ("MTData" if is_legacy else "MTData2")
    assert (entry["model"], entry["firmware"]) == ("MTi-30-2A5G4", "1.8.2")
    assert entry["serial_number"] == "07700ABC"
    assert (entry["units"]["imu_az"], entry["units"]["imu_gx"]) == ("m/s²", "rad/s")
    assert values.shape == (len(received), len(imu.columns))
    assert np.ptp(values[:, 0]) == len(values) + lost - 1
    np.testing.assert_array_equal(values[:, 2:], np.tile(READING, (len(values), 1)))
    assert np.ptp(values[:, 0]) / np.ptp(received) == pytest.approx(256, rel=0.05)
    assert np.isnan(values[:, 1]).all() == is_legacy


def test_lost_messages_are_counted_as_the_tracker_lost_them() -> None:
    """However the others were late, split or repeated."""
    faults = Faults(lost=0.03, late=0.02, split=0.2, repeated=0.03, seed=5)
    with XsensDevice(steady, faults=faults) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        imu.open()
        _, values, lost = record(imu, 2.0)
        imu.close()
    numbers = values[:, 0]
    assert (np.diff(numbers) > 0).all()
    gone = set(range(int(numbers[0]), int(numbers[-1]))) - set(numbers.astype(int))
    assert len(gone) == lost > 3
    assert gone == {n for n in tracker.delivery.lost if numbers[0] < n < numbers[-1]}


def test_the_counter_wraps_around() -> None:
    """It starts half a second before the end of its 16 bits."""
    with XsensDevice(steady, clock=Clock(offset_s=2**16 / 256 - 0.5)) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        imu.open()
        _, values, lost = record(imu, 1.5)
        imu.close()
    assert np.diff(values[:, 0]).sum() == len(values) + lost - 1
    assert values[0, 0] < 2**16 < values[-1, 0]


def test_the_tracker_s_clock_drifts() -> None:
    def age(now: float) -> Array:
        return np.full(9, now - born)

    born = time.monotonic()
    with XsensDevice(age, clock=Clock(offset_s=100.0, drift_ppm=-20_000)) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        imu.open()
        received, values, _ = record(imu, 2.0)
        imu.close()
    own, taken = values[:, 1] * 1e-4, born + values[:, 2]
    assert own[0] >= 100
    assert np.polyfit(own, taken, 1)[0] == pytest.approx(0.98, abs=1e-3)
    assert -1e-3 < (received - taken).min() < 0.01


def test_a_tracker_that_dies_is_lost_and_comes_back() -> None:
    with XsensDevice(steady, faults=Faults(dies_at=0.8, back_at=2.8)) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        imu.open()
        with pytest.raises(DeviceLost, match=r"sent nothing for 1 s"):
            record(imu, 10.0)
        imu.close()
        while not tracker.is_powered():
            time.sleep(0.05)
        assert imu.open()["rate_hz"] == 256
        _, values, _ = record(imu, 0.3)
        imu.close()
    assert len(values) > 10


def test_a_cable_that_is_pulled() -> None:
    with XsensDevice(steady) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        imu.open()
        record(imu, 0.1)
    with pytest.raises(DeviceLost, match=f"serial port {tracker.path} of the IMU has gone"):
        record(imu, 5.0)
    imu.close()


def test_a_rate_that_the_tracker_does_not_offer() -> None:
    with (
        XsensDevice(steady, is_legacy=True) as tracker,
        pytest.raises(InputError, match=r"does not accept 100 Hz; choose"),
    ):
        Xsens(tracker.path, rate_hz=100).open()
    with XsensDevice(steady) as tracker:
        imu = Xsens(tracker.path, rate_hz=100)
        assert imu.open()["rate_hz"] == 256
        imu.close()


def test_a_port_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ttyUSB7 cannot be opened; check the cable"):
        Xsens(str(tmp_path / "ttyUSB7")).open()


def noise(master: int, stopped: threading.Event) -> None:
    while not stopped.wait(0.01):
        os.write(master, os.urandom(64))


@pytest.mark.parametrize("is_noisy", [False, True])
def test_a_port_where_no_tracker_answers(is_noisy: bool) -> None:
    master, slave = os.openpty()
    stopped = threading.Event()
    source = threading.Thread(target=noise, args=[master, stopped]) if is_noisy else None
    try:
        if source:
            source.start()
        with pytest.raises(InputError, match=r"no Xsens motion tracker answers at .*baudrate"):
            Xsens(os.ttyname(slave)).open()
    finally:
        stopped.set()
        if source:
            source.join()
        os.close(master)
        os.close(slave)


def test_a_closed_device_is_lost() -> None:
    imu = Xsens("/dev/null")
    imu.close()
    with pytest.raises(DeviceLost, match="not open"):
        imu.read()


def test_the_serial_library_is_loaded_when_a_port_is_opened() -> None:
    program = "import sys, ur5lib.recorder.xsens; sys.exit('serial' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=True)
