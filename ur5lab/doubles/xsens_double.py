"""The double of an Xsens MTi: a motion tracker that speaks Xbus on a pseudo-terminal.

Source of the protocol: Xsens, MT Low-Level Communication Protocol Documentation. Its samples are
encoded independently of the decoder in `recorder`, so that one tests the other.
"""

import contextlib
import math
import os
import struct
import tty

from ur5lab.doubles.device_double import DeviceClock, DeviceDouble, Reading
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.recorder import xbus, xsens

WAKE_UP_MESSAGE = 0x3E
IDENTITY_ANSWERS = {  # to requests for the device's identity
    xsens.REQUEST_DEVICE_ID: bytes.fromhex("07700ABC"),
    xsens.REQUEST_FIRMWARE: bytes([1, 8, 2]),
    xsens.REQUEST_PRODUCT_CODE: b"MTi-30-2A5G4        ",
}
FACTORY_OUTPUTS = {
    xbus.PACKET_COUNTER: xsens.WITH_EACH_SAMPLE,
    xbus.SAMPLE_TIME_FINE: xsens.WITH_EACH_SAMPLE,
    **dict.fromkeys(xbus.VECTORS, 100),
}
LEGACY_SETTINGS = {
    xsens.SET_SKIP_FACTOR: b"\x00\x00",
    xsens.SET_OUTPUT_MODE: b"\x00\x02",
    xsens.SET_OUTPUT_SETTINGS: b"\x00\x00\x00\x01",
}
SERIAL_BUFFER_BYTES = 1 << 16  # kept by a serial port that nobody reads
INVALID_MESSAGE, INVALID_PARAMETER = b"\x04", b"\x21"


class XsensDouble(DeviceDouble):
    """The double of a motion tracker at the terminal `path`; it streams as soon as it is switched
    on.

    reading: specific force [m/s²], angular rate [rad/s] and magnetic field (9,), axes of the
    tracker; rate_hz: its only sampling rate; is_legacy: whether it is of the first generation and
    sends MTData.
    """

    is_stream = True

    def __init__(
        self,
        reading: Reading,
        rate_hz: float = 256.0,
        clock: DeviceClock = DeviceClock(),
        faults: TransmissionFaults = TransmissionFaults(),
        is_legacy: bool = False,
    ) -> None:
        super().__init__(reading, rate_hz, clock, faults)
        self._is_legacy = is_legacy
        self.line, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self.line, False)
        self.path = os.ttyname(self._slave)
        self._outputs = dict(FACTORY_OUTPUTS)  # kept without power
        self._asked = self._unread = b""
        self._is_measuring = True

    def answer(self) -> None:
        """Execute the requests that have arrived completely."""
        data = os.read(self.line, 4096)
        self._asked += data if self.is_powered() else b""
        while len(self._asked) >= 5:  # bytes of a message without data
            end = 5 + self._asked[3]
            request, whole = self._asked[:end], len(self._asked) >= end
            if self._asked[:2] != b"\xfa\xff":
                self._asked = self._asked[1:]
            elif not whole:
                return
            else:
                self._asked = self._asked[end:]
                self._obey(request[2], request[4:-1])

    def packet(self, sample: int) -> bytes | None:
        """Return the message with a sample; None while the device does not measure."""
        if not self._is_measuring:
            return None
        true = self.reading(self.instant(sample))
        # The counter starts with the clock's offset.
        count = round(self.shown(sample) * self.rate_hz) % 2**16
        if self._is_legacy:
            return xbus.encode(xbus.MTDATA, struct.pack(">9fH", *true, count))
        ticks = math.floor(self.shown(sample) * 10_000) % 2**32
        stamps = {
            xbus.PACKET_COUNTER: count.to_bytes(2, "big"),
            xbus.SAMPLE_TIME_FINE: ticks.to_bytes(4, "big"),
        }
        vectors = {
            name: struct.pack(">3f", *true[3 * k : 3 * k + 3])
            for k, name in enumerate(xbus.VECTORS)
        }
        items = [(name, (stamps | vectors)[name]) for name in self._outputs]
        parts = (name.to_bytes(2, "big") + bytes([len(data)]) + data for name, data in items)
        return xbus.encode(xbus.MTDATA2, b"".join(parts))

    def send(self, part: bytes) -> None:
        """Write bytes; a full buffer drops the newest ones, as Linux does for a serial port."""
        self._unread = (self._unread + part)[:SERIAL_BUFFER_BYTES]
        with contextlib.suppress(BlockingIOError):  # a terminal keeps fewer
            self._unread = self._unread[os.write(self.line, self._unread) :]

    def restart(self) -> None:
        """Send the wake-up message, and stream with the last configured outputs."""
        self._asked, self._unread, self._is_measuring = b"", b"", True
        self.send(xbus.encode(WAKE_UP_MESSAGE))

    def disconnect(self) -> None:
        """Close the terminal."""
        os.close(self.line)
        os.close(self._slave)

    def _obey(self, request: int, data: bytes) -> None:
        if request in (xsens.GO_TO_CONFIG, xsens.GO_TO_MEASUREMENT):
            self._is_measuring = request == xsens.GO_TO_MEASUREMENT
            self.delivery.forget()
            self.send(xbus.encode(request + 1))
        elif self._is_measuring:
            return  # other requests are for the configuration state
        elif request in IDENTITY_ANSWERS:
            self.send(xbus.encode(request + 1, IDENTITY_ANSWERS[request]))
        elif self._is_legacy:
            self._set_legacy(request, data)
        elif request == xsens.SET_OUTPUT_CONFIGURATION:
            self._set_outputs(data)
        else:
            self.send(xbus.encode(xbus.ERROR_MESSAGE, INVALID_MESSAGE))

    def _set_legacy(self, request: int, data: bytes) -> None:
        """Answer a request of the first generation: only the device's own mode and rate are
        accepted.
        """
        offered = LEGACY_SETTINGS | {
            xsens.SET_PERIOD: round(xsens.PERIOD_CLOCK / self.rate_hz).to_bytes(2, "big")
        }
        if request not in offered:
            self.send(xbus.encode(xbus.ERROR_MESSAGE, INVALID_MESSAGE))
        elif data != offered[request]:
            self.send(xbus.encode(xbus.ERROR_MESSAGE, INVALID_PARAMETER))
        else:
            self.send(xbus.encode(request + 1))

    def _set_outputs(self, data: bytes) -> None:
        """Configure the requested items at the device's rate, and confirm them."""
        names = [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 4)]
        if any(name not in FACTORY_OUTPUTS for name in names):
            self.send(xbus.encode(xbus.ERROR_MESSAGE, INVALID_PARAMETER))
            return
        rates = dict.fromkeys(xbus.VECTORS, round(self.rate_hz))
        self._outputs = {name: rates.get(name, xsens.WITH_EACH_SAMPLE) for name in names}
        accepted = [struct.pack(">HH", *item) for item in self._outputs.items()]
        self.send(xbus.encode(xsens.SET_OUTPUT_CONFIGURATION + 1, b"".join(accepted)))
