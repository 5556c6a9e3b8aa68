"""The double of a Net F/T box: a force sensor that streams RDT records and has a page of settings.

Source of the protocol: ATI Industrial Automation, Net F/T manual 9620-05-NET FT. Its
records are encoded independently of the decoder in `recorder`, so that one tests the other.
"""

import contextlib
import http.server
import socket
import threading
from typing import Self

import numpy as np

from ur5lab.doubles.device_double import HOST, DeviceClock, DeviceDouble, Reading
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.recorder import net_ft
from ur5lib.timeseries.arrays import Array

INTERNAL_RATE = 7000  # Hz; of ft_sequence
SATURATION_STATUS = net_ft.ERROR_BIT | net_ft.SATURATION_BIT
COUNTS = 1_000_000  # counts per unit, of force and torque
MAX_COUNT = 2**31 - 1  # count

SETTINGS_PAGE = """<?xml version="1.0"?>
<netft>
<runstat>0x00000000</runstat><prodname>Net F/T (emulated)</prodname>
<cfgnam>lab</cfgnam><cfgcalsel>0</cfgcalsel><cfgcalsn>FT00001</cfgcalsn>
<scfgfu>{force_unit}</scfgfu><scfgtu>{torque_unit}</scfgtu>
<cfgcpf>{counts}</cfgcpf><cfgcpt>{counts}</cfgcpt>
<comrdte>Enabled</comrdte><comrdtrate>{rate:.0f}</comrdtrate><comrdtbsiz>1</comrdtbsiz>
<mfgdigver>2.2.59</mfgdigver>
</netft>
"""


class NetFTDouble(DeviceDouble):
    """The double of a Net F/T box on 127.0.0.1, at free ports: `port` for RDT and `http_port` for
    its page.

    reading: force and torque (6,), in the box's units; saturation: largest force [box's unit],
    beyond which the status is SATURATION_STATUS.
    """

    is_stream = False

    def __init__(
        self,
        reading: Reading,
        rate_hz: float = 1000.0,
        clock: DeviceClock = DeviceClock(),
        faults: TransmissionFaults = TransmissionFaults(),
        force_unit: str = "N",
        torque_unit: str = "Nm",
        saturation: float = np.inf,
    ) -> None:
        super().__init__(reading, rate_hz, clock, faults)
        self._saturation = saturation
        self._page = SETTINGS_PAGE.format(
            force_unit=force_unit,
            torque_unit=torque_unit,
            counts=COUNTS,
            rate=rate_hz,
        ).encode()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((HOST, 0))
        self.line, self.port = self._socket.fileno(), self._socket.getsockname()[1]
        self._server = http.server.ThreadingHTTPServer((HOST, 0), self._handler())
        self.http_port: int = self._server.server_address[1]
        self._client: tuple[str, int] | None = None
        self._sequence = 0
        self._zero: Array | None = np.zeros(6)  # None: the next sample becomes the bias

    def __enter__(self) -> Self:
        super().__enter__()
        threading.Thread(target=self._server.serve_forever, args=[0.1], daemon=True).start()
        return self

    def answer(self) -> None:
        """Obey a request: begin or end a stream, or set the bias."""
        data, sender = self._socket.recvfrom(64)
        if len(data) != net_ft.REQUEST.size or not self.is_powered():
            return
        header, command, _ = net_ft.REQUEST.unpack(data)
        if header != net_ft.REQUEST_HEADER:
            return
        if command == net_ft.STOP:
            self._client = None
        elif command == net_ft.STREAM:
            self._client, self._sequence = sender, 0
        elif command == net_ft.SET_BIAS:
            self._zero = None

    def packet(self, sample: int) -> bytes | None:
        """Return the record of a sample; None if no client has asked for a stream."""
        if self._client is None:
            return None
        true = self.reading(self.instant(sample))
        if self._zero is None:
            self._zero = true
        clipped = np.clip(true[:3], -self._saturation, self._saturation)
        status = SATURATION_STATUS if (clipped != true[:3]).any() else 0
        self._sequence += 1
        internal = round(self.shown(sample) * INTERNAL_RATE)
        wrench = np.concatenate([clipped, true[3:]])
        counts = np.rint((wrench - self._zero) * COUNTS).clip(-MAX_COUNT, MAX_COUNT)
        numbers = [self._sequence, internal, status, *counts.astype(int)]
        return b"".join((int(n) % 2**32).to_bytes(4, "big") for n in numbers)

    def send(self, part: bytes) -> None:
        """Send a record to the client, if it is still there."""
        if self._client is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(part, self._client)

    def restart(self) -> None:
        """Forget client and bias."""
        self._client, self._zero = None, np.zeros(6)

    def disconnect(self) -> None:
        """Close both ports."""
        self._server.shutdown()
        self._server.server_close()
        self._socket.close()

    def _handler(self) -> type[http.server.BaseHTTPRequestHandler]:
        box = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                """Answer with the page of settings; without power, hang up."""
                if not box.is_powered():
                    return
                self.send_response(200 if self.path == "/netftapi2.xml" else 404)
                self.send_header("Content-Type", "text/xml")
                self.end_headers()
                self.wfile.write(box._page if self.path == "/netftapi2.xml" else b"")

            def log_message(self, *_: object) -> None:
                """Do nothing, so that requests are not printed."""

        return Handler
