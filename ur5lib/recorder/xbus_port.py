"""The serial port of an Xsens motion tracker: requests with their acknowledgements, and the stream.

Source: Xsens, MT Low-Level Communication Protocol Documentation, "Message reference".
"""

import contextlib
import time
from collections import deque

from ur5lib.errors import InputError
from ur5lib.recorder import xbus
from ur5lib.recorder.device import DeviceLost

ERROR = 0x42  # identifier of the answer to a request that the device does not know or accept
WAIT = 0.02  # s, for which one call waits for bytes
ANSWER = 0.5  # s, for an acknowledgement
ATTEMPTS = 4  # requests that arrive while the device starts are lost


class RefusedError(Exception):
    """The device does not know a request, or does not accept its data."""


class XbusPort:
    """The messages of a device at a serial port."""

    def __init__(self, path: str, baudrate: int) -> None:
        """Open the port. Raises InputError when that fails."""
        import serial

        self._path = path
        self._decoder = xbus.Decoder()
        self._early: deque[xbus.Message] = deque()
        try:
            self._port = serial.Serial(path, baudrate, timeout=WAIT, write_timeout=ANSWER)
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise InputError(
                f"the IMU's serial port {path} cannot be opened; check the cable, the port and "
                f"baudrate in the study, and the permissions of {path}"
            ) from error

    def ask(self, request: int, data: bytes = b"") -> bytes:
        """Return the data of a request's acknowledgement, which is the next higher identifier.

        Raises RefusedError when the device answers with an error, InputError when not at all.
        """
        try:
            for _ in range(ATTEMPTS):
                self._port.write(xbus.encode(request, data))
                answer = self._answer(request)
                if answer is not None:
                    return answer
        except (OSError, DeviceLost):
            pass
        raise InputError(
            f"no Xsens motion tracker answers at {self._path}; check its power, the port and the "
            "baudrate in the study"
        )

    def send(self, request: int) -> None:
        """Send a request without waiting for its answer; does nothing when the device has gone."""
        with contextlib.suppress(OSError):
            self._port.write(xbus.encode(request))
            self._port.flush()

    def receive(self) -> list[xbus.Message]:
        """Return the messages that have arrived, after waiting at most 0.02 s for the first byte.

        Raises DeviceLost when the port has gone.
        """
        messages = [*self._early]
        self._early.clear()
        try:
            data = self._port.read(max(1, self._port.in_waiting))
        except OSError as error:
            raise DeviceLost(f"the serial port {self._path} of the IMU has gone") from error
        return messages + self._decoder.feed(data)

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def _answer(self, request: int) -> bytes | None:
        """Return the acknowledgement's data, None if it is late; skip data messages before it."""
        until = time.monotonic() + ANSWER
        while time.monotonic() < until:
            messages = self.receive()
            for number, message in enumerate(messages):
                if message.identifier == ERROR:
                    raise RefusedError
                if message.identifier == request + 1:
                    self._early.extend(messages[number + 1 :])
                    return message.data
        return None
