"""The Net F/T device, beside an emulated box with known readings and faults."""

import http.server
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from ur5lib.errors import InputError
from ur5lib.recorder import rdt
from ur5lib.recorder.device import Device, DeviceLost
from ur5lib.recorder.net_ft import NetFT
from ur5lib.stand.lab.delivery import Faults
from ur5lib.stand.lab.emulated import Clock
from ur5lib.stand.lab.net_ft_box import NetFTBox
from ur5lib.timeseries.arrays import Array

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

WRENCH = np.array([10.0, -20.0, 30.0, 0.5, -1.0, 2.0])


def steady(_: float) -> Array:
    return WRENCH


def device(box: NetFTBox, **options: Any) -> NetFT:
    return NetFT("127.0.0.1", port=box.port, http_port=box.http_port, **options)


BORN = time.monotonic()


def age(now: float) -> Array:
    """Readings that are the host's time [s] since these tests began."""
    return np.full(6, now - BORN)


def record(recorded: Device, seconds: float) -> tuple[Array, Array, int]:
    """Times of arrival, values and the number of lost samples of a recording."""
    until = time.monotonic() + seconds
    parts = []
    while time.monotonic() < until:
        parts.append(recorded.read())
    received = np.concatenate([part.received for part in parts])
    return received, np.vstack([p.values for p in parts]), sum(part.lost for part in parts)


def test_force_and_torque_arrive_with_their_counters() -> None:
    with NetFTBox(steady) as box:
        sensor = device(box)
        entry = sensor.open()
        received, values, lost = record(sensor, 2.0)
        sensor.close()
    assert (entry["serial_number"], entry["rate_hz"], entry["bias"]) == ("FT00001", 1000, False)
    assert (entry["units"]["ft_fz"], entry["units"]["ft_tz"]) == ("N", "Nm")
    assert values.shape == (len(received), len(sensor.columns))
    assert (values[0, 0], values[-1, 0]) == (1, len(values) + lost)
    np.testing.assert_array_equal(np.diff(values[:, 1]), 7 * np.diff(values[:, 0]))
    np.testing.assert_allclose(values[:, 3:], np.tile(WRENCH, (len(values), 1)), atol=1e-6)
    assert (np.diff(received) >= 0).all()
    assert np.ptp(values[:, 0]) / np.ptp(received) == pytest.approx(1000, rel=0.05)


def test_lost_records_are_counted_as_the_box_lost_them() -> None:
    faults = Faults(lost=0.02, late=0.01, repeated=0.02, seed=3)
    with NetFTBox(steady, faults=faults) as box:
        sensor = device(box)
        sensor.open()
        _, values, lost = record(sensor, 2.0)
        sensor.close()
    # A late record is discarded, because later ones have come: it counts as lost. Nothing is late
    # where the computer let the box wait for so long that all is sent at once.
    hit = box.delivery.lost + box.delivery.late
    sampled = values[:, 1] / 7
    assert (np.diff(sampled) > 0).all()
    gone = set(range(int(sampled[0]), int(sampled[-1]))) - set(sampled.astype(int))
    assert len(box.delivery.lost) > 10
    assert box.delivery.late
    assert len(gone) == lost
    arrived = sampled[-1] - 25  # later ones may still be in transmission
    assert {k for k in gone if k < arrived} == {k for k in hit if sampled[0] < k < arrived}


def test_the_box_s_clock_drifts() -> None:
    """In 2 s of its own clock, 2 s and 2 % pass here."""
    with NetFTBox(age, clock=Clock(offset_s=5.0, drift_ppm=20_000)) as box:
        sensor = device(box)
        sensor.open()
        received, values, _ = record(sensor, 2.0)
        sensor.close()
    own, taken = values[:, 1] / 7000, BORN + values[:, 3]
    assert own[0] >= 5.0
    assert np.polyfit(own, taken, 1)[0] == pytest.approx(1.02, abs=1e-4)
    assert -1e-4 < (received - taken).min() < 0.01


@pytest.mark.parametrize(
    ("force_unit", "torque_unit", "force", "torque"),
    [("N", "N-m", 1.0, 1.0), ("kN", "Nmm", 1e-3, 1e3), ("lbf", "lbf-in", 0.2248089, 8.8507458)],
)
def test_units_of_the_box_become_newtons(
    force_unit: str, torque_unit: str, force: float, torque: float
) -> None:
    def reading(_: float) -> Array:
        return WRENCH * np.repeat([force, torque], 3)

    with NetFTBox(reading, force_unit=force_unit, torque_unit=torque_unit) as box:
        sensor = device(box)
        sensor.open()
        _, values, _ = record(sensor, 0.1)
        sensor.close()
    np.testing.assert_allclose(values[-1, 3:], WRENCH, rtol=1e-3)


def test_a_bias_is_set_and_told() -> None:
    with NetFTBox(steady) as box:
        sensor = device(box, bias=True)
        assert sensor.open()["bias"] is True
        _, values, _ = record(sensor, 0.2)
        sensor.close()
    np.testing.assert_allclose(values[:, 3:], 0, atol=1e-6)


def test_saturation_is_in_the_status() -> None:
    with NetFTBox(steady, saturation=25.0) as box:
        sensor = device(box)
        sensor.open()
        _, values, _ = record(sensor, 0.1)
        sensor.close()
    assert (values[:, 5] == 25).all()
    assert (values[:, 2].astype(int) & rdt.SATURATED != 0).all()


def test_a_box_that_dies_is_lost_and_comes_back() -> None:
    with NetFTBox(steady, faults=Faults(dies_at=0.5, back_at=2.5)) as box:
        sensor = device(box)
        sensor.open()
        with pytest.raises(DeviceLost, match=r"sent nothing for 1 s"):
            record(sensor, 10.0)
        sensor.close()
        while not box.is_powered():
            time.sleep(0.05)
        sensor.open()
        _, values, _ = record(sensor, 0.3)
        sensor.close()
    assert values[0, 0] == 1


def test_a_closed_device_is_lost() -> None:
    sensor = NetFT("127.0.0.1")
    sensor.close()
    with pytest.raises(DeviceLost, match="not open"):
        sensor.read()


def test_a_box_that_is_not_there() -> None:
    with pytest.raises(InputError, match=r"no Net F/T box answers at http://127.0.0.1:9/.*cable"):
        NetFT("127.0.0.1", http_port=9).open()


def test_a_box_that_does_not_stream() -> None:
    with NetFTBox(steady) as box:
        sensor = NetFT("127.0.0.1", port=9, http_port=box.http_port)
        with pytest.raises(InputError, match=r"no records from UDP port 9; enable RDT"):
            sensor.open()


@pytest.fixture
def page(request: pytest.FixtureRequest) -> Iterator[int]:
    """A port at which a page is served."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(request.param)

        def log_message(self, *_: object) -> None:
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, args=[0.1], daemon=True).start()
        yield server.server_address[1]
        server.shutdown()


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
    indirect=["page"],
)
def test_a_page_of_something_else(page: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        NetFT("127.0.0.1", http_port=page).open()
