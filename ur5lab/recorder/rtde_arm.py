"""An arm recorded through its controller's Real-Time Data Exchange (RTDE), missing no package.

ur_rtde's receive interface is made for control: it keeps the newest package only, and its
constructor blocks all threads until a controller answers. A recorder needs every package with its
time of arrival.

Source: Universal Robots' guide to RTDE, protocol version 2. A package is its size (uint16), its
kind (uint8) and its content, big-endian; texts list variables separated by commas.
"""

import contextlib
import socket
import struct
import time
from collections.abc import Sequence

import numpy as np

from ur5lab import rtde_variables as rtde
from ur5lab.recorder.device import (
    ANSWER_TIMEOUT,
    GATHERING_TIME,
    CycleCounter,
    DeviceLost,
    Identity,
    NewSamples,
    Silence,
    answering,
    no_controller,
    receive,
)
from ur5lab.rtde_variables import PACKAGE_HEADER, STRUCT_FORMATS, all_columns, layout

PORT = 30004
PROTOCOL_VERSION = 2
RECORDED_OUTPUTS = (
    *("timestamp", "target_q", "target_qd", "target_qdd", "target_current", "target_moment"),
    *("actual_q", "actual_qd", "actual_current", "actual_current_as_torque"),
    *("actual_TCP_pose", "actual_TCP_speed", "actual_TCP_force"),
    *("ft_raw_wrench", "wrench_calc_from_currents", "actual_tool_accelerometer"),
    *("joint_temperatures", "payload", "payload_cog", "payload_inertia"),
    *("target_gravity", "target_base_acceleration"),
    *("collision_detection_ratio", "joint_position_deviation_ratio"),
    *("speed_scaling", "robot_mode", "safety_mode", "runtime_state"),
)
RATE_BY_MAJOR_VERSION = {3: 125.0}  # Hz, by the controller's software; later ones send at 500
DEFAULT_RATE = 500.0
HANDSHAKE_TIMEOUT = 6.0  # s; from the connection to the first data package
READ_TIMEOUT = 0.1  # s; for samples in one call


class RtdeClient:
    """An RTDE connection to one controller. software: its major, minor, bugfix and build number."""

    def __init__(self, address: str, port: int = PORT) -> None:
        """Connect. Raises InputError when no controller answers."""
        self._address, self._port = address, port
        self._buffer, self._until = b"", time.monotonic() + HANDSHAKE_TIMEOUT
        with answering("RTDE", address, port) as self._socket:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self._ask(rtde.VERSION_PACKAGE, struct.pack(">H", PROTOCOL_VERSION)) != b"\x01":
                raise ConnectionError("it does not speak version 2")
            major, minor, bugfix, build = struct.unpack(">4I", self._ask(rtde.SOFTWARE_PACKAGE))
        self.software = int(major), int(minor), int(bugfix), int(build)

    def start(self, names: Sequence[str], rate: float) -> list[str]:
        """Start data packages and return their outputs: those of `names` that the controller has.

        rate: [Hz]. Raises InputError, and closes the connection, when the controller refuses.
        """
        try:
            names, kinds = self._set_up(names, rate)
            if self._ask(rtde.START_PACKAGE) != b"\x01":
                raise ConnectionError("it does not start")
        except OSError as error:
            self.close()
            raise no_controller("RTDE", self._address, self._port, error) from error
        self._layout = layout(kinds)
        return names

    def receive(self, patience: float) -> list[tuple[float, tuple[float, ...]]]:
        """Return the packages that have arrived, after waiting at most `patience` [s].

        Each is the host's time.monotonic [s] at arrival, and the values of the outputs. Raises
        DeviceLost when the connection fails or the controller closes it.
        """
        arrived, data = receive(self._socket, self._address, patience)
        self._buffer += data
        return [(arrived, package) for package in self._packages()]

    def close(self) -> None:
        """Stop the packages and close the connection."""
        with contextlib.suppress(OSError):
            self._socket.sendall(PACKAGE_HEADER.pack(PACKAGE_HEADER.size, rtde.PAUSE_PACKAGE))
        self._socket.close()

    def _packages(self) -> list[tuple[float, ...]]:
        """Remove the complete packages from the buffer, and return the values of those with
        data.
        """
        start, packages = 0, list[tuple[float, ...]]()
        while len(self._buffer) - start >= PACKAGE_HEADER.size:
            size, kind = PACKAGE_HEADER.unpack_from(self._buffer, start)
            if size < PACKAGE_HEADER.size:
                if packages:  # the next call raises it, too
                    break
                raise DeviceLost(f"{self._address} does not send RTDE packages")
            if len(self._buffer) - start < size:
                break
            if kind == rtde.DATA_PACKAGE and size == PACKAGE_HEADER.size + 1 + self._layout.size:
                packages.append(
                    self._layout.unpack_from(self._buffer, start + PACKAGE_HEADER.size + 1)
                )
            start += size
        self._buffer = self._buffer[start:]
        return packages

    def _set_up(self, names: Sequence[str], rate: float) -> tuple[list[str], list[str]]:
        """Return the requested outputs that the controller has, and their types; if it lacks some,
        only the others are requested.
        """
        for _ in range(2):
            content = struct.pack(">d", rate) + ",".join(names).encode()
            kinds = (
                self._ask(rtde.OUTPUTS_PACKAGE, content)[1:].decode("ascii", "replace").split(",")
            )
            available = [
                name for name, kind in zip(names, kinds, strict=False) if kind in STRUCT_FORMATS
            ]
            if len(available) == len(names) == len(kinds):
                return list(names), kinds
            names = available
        raise ConnectionError("it refuses outputs that it offered" if names else "it has no output")

    def _ask(self, kind: int, content: bytes = b"") -> bytes:
        """Send a request and return the content of the answer to it."""
        self._socket.sendall(
            PACKAGE_HEADER.pack(PACKAGE_HEADER.size + len(content), kind) + content
        )
        while True:
            size, answered = PACKAGE_HEADER.unpack(self._exactly(PACKAGE_HEADER.size))
            answer = self._exactly(size - PACKAGE_HEADER.size)
            if answered == kind:  # text messages may arrive first
                return answer

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            if (left := self._until - time.monotonic()) <= 0:
                raise TimeoutError(f"its answers take more than {HANDSHAKE_TIMEOUT:g} s")
            self._socket.settimeout(min(ANSWER_TIMEOUT, left))
            more = self._socket.recv(count - len(data))
            if not more:
                raise ConnectionError("it has closed the connection")
            data += more
        return data


class RtdeArm:
    """The arm at an address, recorded package by package through RTDE.

    columns: those of RECORDED_OUTPUTS that the controller has; lost packages are counted by
    `timestamp`, the controller's clock.
    """

    def __init__(self, address: str, rate: float | None = None, port: int = PORT) -> None:
        """Connect to the controller; rate: [Hz], None for its default."""
        self._client = RtdeClient(address, port)
        software = self._client.software
        rate = rate or RATE_BY_MAJOR_VERSION.get(software[0], DEFAULT_RATE)
        names = self._client.start(RECORDED_OUTPUTS, rate)
        self.columns = all_columns(tuple(names))
        self._cycles = CycleCounter(1 / rate)
        self._silence = Silence(address)
        self.identity = Identity(
            model="Universal Robots controller, RTDE",
            address=address,
            firmware=".".join(map(str, software)),
            rate_hz=rate,
            units="SI",
            clock="timestamp",
            missing=[name for name in RECORDED_OUTPUTS if name not in names],
        )

    def read(self) -> NewSamples:
        """Return the samples of the last 0.05 s, as `Device.read`, after waiting at most 0.1 s for
        the first.
        """
        until, packages = time.monotonic() + GATHERING_TIME, self._client.receive(READ_TIMEOUT)
        with contextlib.suppress(DeviceLost):  # the next call raises it, too
            while packages and (remaining := until - time.monotonic()) > 0:
                packages += self._client.receive(remaining)
        self._silence.check(len(packages))
        received = np.array([arrived for arrived, _ in packages], np.float64)
        values = np.array([numbers for _, numbers in packages], np.float64)
        values = values.reshape(len(packages), len(self.columns))
        return NewSamples(received, values, self._cycles.lost(values[:, 0]))

    def close(self) -> None:
        """Stop the packages."""
        self._client.close()
