"""The sensors' devices, beside doubles with known readings and faults."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import PROJECT
from ur5lab.doubles.device_double import DeviceClock, DeviceDouble
from ur5lab.doubles.net_ft_double import NetFTDouble
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.doubles.xsens_double import XsensDouble
from ur5lab.recorder.device import DeviceLost
from ur5lab.recorder.net_ft import SATURATION_BIT, NetFT
from ur5lab.recorder.xsens import Xsens
from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

WRENCH = np.array([10.0, -20.0, 30.0, 0.5, -1.0, 2.0])
READING = np.array([0.5, -1.0, 9.75, 0.25, 0.0, -0.125, 0.5, 0.25, -0.75])
BORN = time.monotonic()

Opened = AbstractContextManager[tuple[DeviceDouble, NetFT | Xsens]]


@contextmanager
def net_ft(
    reading: Array | None = WRENCH, bias: bool = False, **options: Any
) -> Iterator[tuple[DeviceDouble, NetFT | Xsens]]:
    """The double of a box, and the device that records it.

    reading: None for the host's time [s] since these tests began.
    """
    with NetFTDouble(lambda now: _read(reading, now, 6), **options) as box:
        sensor = device_of(box, bias)
        yield box, sensor
        sensor.close()


@contextmanager
def xsens(
    reading: Array | None = READING, **options: Any
) -> Iterator[tuple[DeviceDouble, NetFT | Xsens]]:
    """The same for a tracker."""
    with XsensDouble(lambda now: _read(reading, now, 9), **options) as tracker:
        imu = device_of(tracker)
        yield tracker, imu
        imu.close()


def device_of(double: DeviceDouble, bias: bool = False) -> NetFT | Xsens:
    """A device that records a double."""
    if isinstance(double, NetFTDouble):
        return NetFT("127.0.0.1", bias, double.port, double.http_port)
    assert isinstance(double, XsensDouble)
    return Xsens(double.path, rate_hz=256)


def _read(reading: Array | None, now: float, count: int) -> Array:
    return np.full(count, now - BORN) if reading is None else reading


def record(device: NetFT | Xsens, seconds: float) -> tuple[Array, Array, int]:
    """Times of arrival, values and the number of lost samples of a recording."""
    until = time.monotonic() + seconds
    parts = []
    while time.monotonic() < until:
        parts.append(device.read())
    received = np.concatenate([part.received for part in parts])
    return received, np.vstack([p.values for p in parts]), sum(part.lost for part in parts)


# Both


def test_force_and_torque_arrive_with_their_counters() -> None:
    with net_ft() as (_, sensor):
        received, values, lost = record(sensor, 2.0)
    entry = sensor.identity
    assert (entry.serial_number, entry.rate_hz, entry.bias) == ("FT00001", 1000, False)
    assert (entry.units["ft_fz"], entry.units["ft_tz"]) == ("N", "Nm")
    assert values.shape == (len(received), len(sensor.columns))
    assert (values[0, 0], values[-1, 0]) == (1, len(values) + lost)
    np.testing.assert_array_equal(np.diff(values[:, 1]), 7 * np.diff(values[:, 0]))
    np.testing.assert_allclose(values[:, 3:], np.tile(WRENCH, (len(values), 1)), atol=1e-6)
    assert (np.diff(received) >= 0).all()
    assert np.ptp(values[:, 0]) / np.ptp(received) == pytest.approx(1000, rel=0.05)


@pytest.mark.parametrize("is_legacy", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_samples_of_a_tracker_arrive_with_their_counters(is_legacy: bool) -> None:
    with xsens(is_legacy=is_legacy) as (_, imu):
        received, values, lost = record(imu, 2.0)
    entry = imu.identity
    assert entry.rate_hz == 256
    assert entry.message == ("MTData" if is_legacy else "MTData2")
    assert (entry.model, entry.firmware) == ("MTi-30-2A5G4", "1.8.2")
    assert entry.serial_number == "07700ABC"
    assert (entry.units["imu_az"], entry.units["imu_gx"]) == ("m/s2", "rad/s")
    assert values.shape == (len(received), len(imu.columns))
    assert np.ptp(values[:, 0]) == len(values) + lost - 1
    np.testing.assert_array_equal(values[:, 2:], np.tile(READING, (len(values), 1)))
    assert np.ptp(values[:, 0]) / np.ptp(received) == pytest.approx(256, rel=0.05)
    assert np.isnan(values[:, 1]).all() == is_legacy


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("opened", "column", "per_sample", "faults"),
    [
        # A late datagram is discarded, because later ones have come: it counts as lost.
        (net_ft, 1, 7, TransmissionFaults(lost=0.02, late=0.01, repeated=0.02, seed=3)),
        (xsens, 0, 1, TransmissionFaults(lost=0.03, late=0.02, split=0.2, repeated=0.03, seed=5)),
    ],
)
def test_lost_samples_are_counted_as_the_device_lost_them(
    opened: Callable[..., Opened], column: int, per_sample: int, faults: TransmissionFaults
) -> None:
    with opened(faults=faults) as (double, device):
        _, values, lost = record(device, 2.0)
    numbers = values[:, column] / per_sample
    assert (np.diff(numbers) > 0).all()
    gone = set(range(int(numbers[0]), int(numbers[-1]))) - set(numbers.astype(int))
    assert len(gone) == lost
    assert len(double.delivery.lost) > 10
    assert bool(double.delivery.late) == (opened is net_ft)  # a serial line keeps the order
    hit = {*double.delivery.lost, *double.delivery.late}
    arrived = numbers[-1] - 25  # later ones may still be in transmission
    assert {k for k in gone if k < arrived} == {k for k in hit if numbers[0] < k < arrived}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("opened", "clock", "ticks", "error"),
    [
        (net_ft, DeviceClock(offset_s=5.0, drift_ppm=20_000), 7000, 1e-4),
        (xsens, DeviceClock(offset_s=100.0, drift_ppm=-20_000), 10_000, 1e-3),
    ],
)
def test_a_device_s_clock_drifts(
    opened: Callable[..., Opened], clock: DeviceClock, ticks: int, error: float
) -> None:
    """In 2 s of its own clock, 2 s and 2 % more or less pass here."""
    with opened(None, clock=clock) as (_, device):
        received, values, _ = record(device, 2.0)
    own, taken = values[:, 1] / ticks, BORN + values[:, 3]
    assert own[0] >= clock.offset_s
    assert np.polyfit(own, taken, 1)[0] == pytest.approx(clock.scale, abs=error)
    assert -error < (received - taken).min() < 0.01


@pytest.mark.thorough
@pytest.mark.parametrize("opened", [net_ft, xsens])
def test_a_device_that_dies_is_lost_and_comes_back(opened: Callable[..., Opened]) -> None:
    with opened(faults=TransmissionFaults(dies_at=0.3, back_at=1.8)) as (double, device):
        with pytest.raises(DeviceLost, match=r"sent nothing for 1 s"):
            record(device, 10.0)
        device.close()
        while not double.is_powered():
            time.sleep(0.05)
        again = device_of(double)
        assert again.identity == device.identity
        _, values, _ = record(again, 0.3)
        again.close()
    assert len(values) > 10
    if isinstance(again, NetFT):
        assert values[0, 0] == 1  # it counts anew


# The force sensor


@pytest.mark.parametrize(
    ("force_unit", "torque_unit", "force", "torque"),
    [("N", "N-m", 1.0, 1.0), ("kN", "Nmm", 1e-3, 1e3), ("lbf", "lbf-in", 0.2248089, 8.8507458)],
)
def test_units_of_the_box_become_newtons(
    force_unit: str, torque_unit: str, force: float, torque: float
) -> None:
    reading = WRENCH * np.repeat([force, torque], 3)
    with net_ft(reading, force_unit=force_unit, torque_unit=torque_unit) as (_, sensor):
        _, values, _ = record(sensor, 0.1)
    np.testing.assert_allclose(values[-1, 3:], WRENCH, rtol=1e-3)


def test_a_bias_is_set_and_recorded() -> None:
    with net_ft(bias=True) as (_, sensor):
        _, values, _ = record(sensor, 0.2)
    assert sensor.identity.bias is True
    np.testing.assert_allclose(values[:, 3:], 0, atol=1e-6)


def test_saturation_is_in_the_status() -> None:
    with net_ft(saturation=25.0) as (_, sensor):
        _, values, _ = record(sensor, 0.1)
    assert (values[:, 5] == 25).all()
    assert (values[:, 2].astype(int) & SATURATION_BIT != 0).all()


def test_a_box_that_is_not_there() -> None:
    with pytest.raises(InputError, match=r"no Net F/T box answers at http://127.0.0.1:9/.*cable"):
        NetFT("127.0.0.1", http_port=9)


def test_a_box_that_does_not_stream() -> None:
    with (
        NetFTDouble(lambda _: WRENCH) as box,
        pytest.raises(InputError, match=r"no records from UDP port 9; enable RDT"),
    ):
        NetFT("127.0.0.1", port=9, http_port=box.http_port)


LAUGHS = b"".join(
    b'<!ENTITY a%d "%s">' % (level, b"&a%d;" % (level - 1) * 10) for level in range(1, 12)
)
BOMB = b'<!DOCTYPE x [<!ENTITY a0 "ha">' + LAUGHS + b"]><netft><cfgcpf>&a11;</cfgcpf></netft>"
NO_COUNTS = b"<netft><scfgfu>N</scfgfu><scfgtu>Nm</scfgtu><cfgcpf>0</cfgcpf></netft>"
ODD_UNITS = NO_COUNTS.replace(b"0</cfgcpf>", b"1</cfgcpf><cfgcpt>1</cfgcpt>").replace(b"Nm", b"oz")


@pytest.mark.parametrize(
    ("page", "words"),
    [
        (b"<html><p>a printer</html>", "not the page of a Net F/T box"),
        (BOMB, "not the page of a Net F/T box"),
        (NO_COUNTS, "no counts per force and torque"),
        (ODD_UNITS, "unknown units “n” and “oz”"),
    ],
)
def test_a_page_of_something_else(page: bytes, words: str) -> None:
    box = NetFTDouble(lambda _: WRENCH)
    box._page = page
    with box, pytest.raises(InputError, match=words):
        device_of(box)


# The tracker


@pytest.mark.thorough
def test_the_counter_wraps_around() -> None:
    """It starts half a second before the end of its 16 bits."""
    with xsens(clock=DeviceClock(offset_s=2**16 / 256 - 0.5)) as (_, imu):
        _, values, lost = record(imu, 1.5)
    assert np.diff(values[:, 0]).sum() == len(values) + lost - 1
    assert values[0, 0] < 2**16 < values[-1, 0]


@pytest.mark.thorough
def test_a_program_that_is_kept_busy_for_two_seconds_misses_nothing() -> None:
    with xsens() as (_, imu):
        record(imu, 0.1)
        time.sleep(2.0)
        _, values, lost = record(imu, 0.1)
    assert lost == 0
    assert len(values) > 512


def test_a_cable_that_is_pulled() -> None:
    with XsensDouble(lambda _: READING) as tracker:
        imu = Xsens(tracker.path, rate_hz=256)
        record(imu, 0.1)
    with pytest.raises(DeviceLost, match=f"serial port {tracker.path} of the IMU has gone"):
        record(imu, 5.0)
    imu.close()


@pytest.mark.parametrize("is_legacy", [False, True])
def test_a_rate_that_the_tracker_does_not_offer(is_legacy: bool) -> None:
    """The first generation refuses it; later ones choose the nearest."""
    with XsensDouble(lambda _: READING, is_legacy=is_legacy) as tracker:
        if is_legacy:
            with pytest.raises(InputError, match=r"does not accept 100 Hz; choose"):
                Xsens(tracker.path, rate_hz=100)
        else:
            imu = Xsens(tracker.path, rate_hz=100)
            assert imu.identity.rate_hz == 256
            imu.close()


def test_a_port_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ttyUSB7 cannot be opened; check the cable"):
        Xsens(str(tmp_path / "ttyUSB7"))


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
            Xsens(os.ttyname(slave))
    finally:
        stopped.set()
        if source:
            source.join()
        os.close(master)
        os.close(slave)


def test_the_serial_library_is_loaded_when_a_port_is_opened() -> None:
    program = "import sys, ur5lab.recorder.xsens; sys.exit('serial' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=True)
