"""An arm whose controller answers or stamps wrongly is recorded on, or refused with a reason."""

import gc
import math
import multiprocessing
import signal
import socket
import struct
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lab.made_up_device import MadeUp
from ur5lab import rtde_variables as rtde
from ur5lab.recorder.capture import SampleFile, capture
from ur5lab.recorder.realtime_arm import MESSAGE_HEAD, RealtimeArm
from ur5lab.recorder.rtde_arm import RECORDED_OUTPUTS, RtdeArm, RtdeClient
from ur5lib.errors import InputError
from ur5lib.robots.realtime_message import SOFTWARE_BY_SIZE

HERE, CYCLE = "127.0.0.1", 0.008
BYTES = max(SOFTWARE_BY_SIZE)  # of a message
LOST = 3  # cycles
DAMAGED = [math.nan, math.inf, -math.inf, 1e300]


@contextmanager
def controller(serve: Callable[[socket.socket], None]) -> Iterator[int]:
    """The port of a controller that serves one client as it likes."""
    with socket.create_server((HERE, 0)) as server:

        def run() -> None:
            with server.accept()[0] as client, suppress(ConnectionError):
                serve(client)
                client.recv(1 << 16)  # until the client has closed

        thread = threading.Thread(target=run)
        thread.start()
        yield server.getsockname()[1]
        thread.join()


def stamps(damaged: float) -> list[float]:
    """Of 60 cycles; one stamp is damaged, and three cycles are lost later on."""
    slots = np.delete(np.arange(60.0), range(40, 40 + LOST))
    slots[20] = damaged / CYCLE
    return (CYCLE * slots).tolist()


def rtde_controller(client: socket.socket, kinds: Iterable[str], sent: Iterable[float]) -> None:
    """Answer the set-up, as often as it is asked for outputs; send packages of one `timestamp`."""
    outputs = iter(kinds)
    while head := client.recv(rtde.PACKAGE_HEADER.size, socket.MSG_WAITALL):
        size, kind = rtde.PACKAGE_HEADER.unpack(head)
        client.recv(size - rtde.PACKAGE_HEADER.size, socket.MSG_WAITALL)
        answer = b"\1"
        if kind == rtde.SOFTWARE_PACKAGE:
            answer = struct.pack(">4I", 3, 15, 8, 0)
        if kind == rtde.OUTPUTS_PACKAGE:
            answer += next(outputs).encode()
        client.sendall(
            rtde.PACKAGE_HEADER.pack(rtde.PACKAGE_HEADER.size + len(answer), kind) + answer
        )
        if kind == rtde.START_PACKAGE:
            break
    for stamp in sent:
        client.sendall(
            rtde.PACKAGE_HEADER.pack(12, rtde.DATA_PACKAGE) + b"\1" + struct.pack(">d", stamp)
        )


@pytest.mark.parametrize("damaged", DAMAGED)
def test_a_damaged_stamp_of_rtde_ends_no_recording(damaged: float, tmp_path: Path) -> None:
    sent, kinds = stamps(damaged), ["DOUBLE" + ",NOT_FOUND" * (len(RECORDED_OUTPUTS) - 1), "DOUBLE"]
    with controller(lambda client: rtde_controller(client, kinds, sent)) as port:
        arm, lost, values = RtdeArm(HERE, 125.0, port), 0, np.empty((0, 1))
        file = SampleFile(tmp_path / "robot.csv", arm.columns)
        while len(values) < len(sent):
            new = arm.read()
            file.write(new, 0.0)
            lost, values = lost + new.lost, np.concatenate([values, new.values])
        arm.close()
        file.close()
    np.testing.assert_array_equal(values[:, 0], sent)
    assert lost == LOST + (not math.isfinite(damaged))  # that cycle has no stamp either


@pytest.mark.parametrize("damaged", DAMAGED)
def test_a_damaged_stamp_of_the_realtime_port_ends_no_recording(damaged: float) -> None:
    sent = stamps(damaged)
    stream = b"".join(MESSAGE_HEAD.pack(BYTES, one).ljust(BYTES, b"\0") for one in sent)
    with controller(lambda client: client.sendall(stream)) as port:
        arm, messages, lost = RealtimeArm(HERE, port), 0, 0
        while messages < len(sent):
            new = arm.read()
            messages, lost = messages + new.messages, lost + new.lost
        arm.close()
    assert lost == LOST + (not math.isfinite(damaged))  # that cycle has no stamp either


@pytest.mark.parametrize("second", [5e-324, 1e-9, -CYCLE, math.nan])
def test_a_realtime_port_without_a_clock_is_refused(second: float) -> None:
    """Of a step whose inverse is infinite, too."""
    sent = [0.0, second, CYCLE]
    stream = b"".join(MESSAGE_HEAD.pack(BYTES, one).ljust(BYTES, b"\0") for one in sent)
    with (
        controller(lambda client: client.sendall(stream)) as port,
        pytest.raises(InputError, match="no timestamps"),
    ):
        RealtimeArm(HERE, port)


@pytest.mark.parametrize("device", [RealtimeArm, RtdeClient])
def test_a_refused_controller_is_disconnected(
    device: Callable[[str, int], object], recwarn: pytest.WarningsRecorder
) -> None:
    with (
        controller(lambda client: client.sendall(bytes(BYTES))) as port,
        pytest.raises(InputError),
    ):
        device(HERE, port)
    gc.collect()
    assert not [one for one in recwarn if one.category is ResourceWarning]


@pytest.mark.parametrize("kinds", ["", "NOT_FOUND", "DOUBLE,", ",,"])
def test_a_controller_without_the_outputs_it_was_asked_for_is_refused(kinds: str) -> None:
    """It answers the same to whatever it is asked for."""
    with (
        controller(lambda client: rtde_controller(client, [kinds] * 2, [])) as port,
        pytest.raises(InputError, match=f"port {port} "),
    ):
        RtdeArm(HERE, 125.0, port)


class Faulty(MadeUp):
    """A device whose driver has a fault."""

    def open(self) -> "Faulty":
        return self

    def read(self) -> Any:
        raise ZeroDivisionError("that nobody thought of")


def test_a_fault_of_the_recorder_is_said(tmp_path: Path) -> None:
    here, there = multiprocessing.Pipe()
    handler, plan, stop = signal.getsignal(signal.SIGINT), Faulty(), multiprocessing.Event()
    try:
        capture(plan, tmp_path / "made_up.csv", 0.0, there, stop)
    finally:
        signal.signal(signal.SIGINT, handler)
    _, status = here.recv(), here.recv()
    assert "ZeroDivisionError: that nobody thought of" in str(status.ended)
    assert status.final
