"""Controllers that answer and send damaged bytes."""

import random
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from tests.damage import damaged_stream
from tests.fuzz import Attempt
from tests.lab.test_recorder_faults import BYTES, HERE
from ur5lab import rtde_variables as rtde
from ur5lab.recorder.device import DeviceLost
from ur5lab.recorder.realtime_arm import MESSAGE_HEAD, RealtimeArm
from ur5lab.recorder.rtde_arm import RECORDED_OUTPUTS, RtdeArm


def package(kind: int, content: bytes) -> bytes:
    """Return a package of RTDE."""
    return rtde.PACKAGE_HEADER.pack(rtde.PACKAGE_HEADER.size + len(content), kind) + content


KINDS = "DOUBLE" + ",NOT_FOUND" * (len(RECORDED_OUTPUTS) - 1)
SAMPLES = [package(rtde.DATA_PACKAGE, b"\1" + struct.pack(">d", 0.008 * k)) for k in range(40)]
OF_RTDE = [
    package(rtde.VERSION_PACKAGE, b"\1"),
    package(rtde.SOFTWARE_PACKAGE, struct.pack(">4I", 3, 15, 8, 0)),
    package(rtde.OUTPUTS_PACKAGE, b"\1" + KINDS.encode()),
    package(rtde.OUTPUTS_PACKAGE, b"\1DOUBLE"),
    package(rtde.START_PACKAGE, b"\1"),
    *SAMPLES,
]
OF_STREAM = [MESSAGE_HEAD.pack(BYTES, 0.008 * k).ljust(BYTES, b"\0") for k in range(40)]


def follow(sent: bytes, arm: Callable[[int], Any]) -> None:
    """Record from a controller that sends these bytes, and then no more."""
    with socket.create_server((HERE, 0)) as server:

        def serve() -> None:
            with server.accept()[0] as client, suppress(OSError):
                client.sendall(sent)
                client.shutdown(socket.SHUT_WR)
                while client.recv(1 << 16):
                    pass

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        device = arm(server.getsockname()[1])
        try:
            with suppress(DeviceLost):
                while True:
                    device.read()
        finally:
            device.close()
            thread.join()


def controllers(folder: Path) -> Attempt:
    """Return what records from a controller of either protocol, of damaged answers and samples."""

    def attempt(draw: random.Random, place: Path) -> None:
        whole, arm = draw.choice(
            [
                (OF_RTDE, lambda port: RtdeArm(HERE, 125.0, port)),
                (OF_STREAM, lambda port: RealtimeArm(HERE, port)),
            ]
        )
        sent = b"".join(whole)
        for _ in range(draw.randint(1, 3)):
            sent = damaged_stream(sent, draw)
        (place / "sent").write_bytes(sent)
        follow(sent, arm)

    return attempt


TARGETS = {"controllers": controllers}
