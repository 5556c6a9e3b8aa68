"""How the force of a running arm ends: what was stated stays, and it is said why."""

import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.lab.test_recorder_faults import HERE, controller
from tests.topics.live.made_arm import PERIOD, POSTURE, arm_file, exported
from ur5lab import rtde_variables as rtde
from ur5lab.journal import FLUSH_PERIOD, journal_of, left_behind
from ur5lab.live import INPUTS, Ended, Show, Stream, record
from ur5lab.recorder import rtde_arm
from ur5lib.errors import InputError
from ur5lib.tables import read_table
from ur5lib.topics.live.live import Live

COUNT = 60  # samples before the stream ends
Serve = Callable[[socket.socket], None]


def sent(client: socket.socket, kind: int, content: bytes) -> None:
    client.sendall(
        rtde.PACKAGE_HEADER.pack(rtde.PACKAGE_HEADER.size + len(content), kind) + content
    )


def stream_of(end: Serve, count: int = COUNT) -> Serve:
    """A controller that answers, sends samples of a resting arm, and then does as `end` does."""

    def serve(client: socket.socket) -> None:
        kind = None
        while kind != rtde.START_PACKAGE:
            head = client.recv(rtde.PACKAGE_HEADER.size, socket.MSG_WAITALL)
            size, kind = rtde.PACKAGE_HEADER.unpack(head)
            client.recv(size - rtde.PACKAGE_HEADER.size, socket.MSG_WAITALL)
            names = b"DOUBLE" + b",VECTOR6D" * (len(INPUTS) - 1)
            answers = {
                rtde.SOFTWARE_PACKAGE: struct.pack(">4I", 5, 11, 0, 0),
                rtde.OUTPUTS_PACKAGE: b"\1" + names,
            }
            sent(client, kind, answers.get(kind, b"\1"))
        for k in range(count):
            send_sample(client, k)
        end(client)

    return serve


def send_sample(client: socket.socket, number: int) -> None:
    values = number * PERIOD, *POSTURE, *np.zeros(6), *np.full(6, 0.1)
    sent(client, rtde.DATA_PACKAGE, b"\1" + struct.pack(">19d", *values))


def hang_up(client: socket.socket) -> None:
    client.shutdown(socket.SHUT_WR)


def silence(_: socket.socket) -> None:
    time.sleep(1.2)


def rubbish(client: socket.socket) -> None:
    client.sendall(b"\0\1\0\0\0")
    time.sleep(0.2)


def killed_by(number: int) -> Serve:
    def end(_: socket.socket) -> None:
        time.sleep(0.2)
        os.kill(os.getpid(), number)
        time.sleep(0.2)

    return end


def followed(
    serve: Serve, path: Path, seconds: float | None = None, show: Show = lambda *_: None
) -> Ended:
    with controller(serve) as port:
        return record(Live(arm_file()), Stream(HERE, seconds, port), path, show)


@pytest.mark.real_time
@pytest.mark.usefixtures("on_a_terminal")
@pytest.mark.parametrize(
    ("end", "why", "lost"),
    [
        (hang_up, "closed the connection", True),
        (silence, "has sent nothing for 1 s", True),
        (rubbish, "does not send RTDE packages", True),
        (killed_by(signal.SIGTERM), "SIGTERM", False),
        (killed_by(signal.SIGHUP), "SIGHUP", False),
        (killed_by(signal.SIGINT), "Ctrl-C", False),
    ],
)
def test_what_was_stated_stays_however_the_stream_ends(
    end: Serve, why: str, lost: bool, tmp_path: Path
) -> None:
    path = tmp_path / "live.parquet"
    ended = followed(stream_of(end), path)
    assert why in ended.in_words()
    assert (ended.lost, ended.failed) == (lost, lost)
    table = read_table(path)
    assert ended.samples == len(table) == COUNT
    np.testing.assert_allclose(np.diff(table["time"]), PERIOD)
    assert not left_behind(path)


@pytest.mark.real_time
def test_two_runs_into_one_file_keep_both(tmp_path: Path) -> None:
    """The second begins after the first, and ends before it."""
    path, seconds = tmp_path / "live.parquet", list[Ended]()

    def second(*_: object) -> None:
        if not seconds:
            assert (tmp_path / "live.1.part.csv").is_file()
            seconds.append(followed(stream_of(hang_up, COUNT // 2), path))

    first = followed(stream_of(silence), path, show=second)
    assert [one.path for one in (*seconds, first)] == [path, tmp_path / "live.2.parquet"]
    assert len(read_table(path)) == seconds[0].samples == COUNT // 2
    assert len(read_table(first.path)) == first.samples == COUNT
    assert {*tmp_path.iterdir()} == {path, first.path}


def test_two_starts_at_once_have_two_journals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each sees no file yet."""
    monkeypatch.setattr(Path, "exists", lambda *_: False)
    first, second = (journal_of(tmp_path / "live.parquet", ["time"], 0.0) for _ in range(2))
    first.write(["0.5"])
    second.write(["0.6"])
    assert [one.path.read_text() for one in (first, second)] == ["time\n0.5\n", "time\n0.6\n"]
    first.close()
    second.close()


def test_an_arm_that_was_identified_by_torques_gets_no_currents(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A controller before 5.23 states no torques."""

    def serve(client: socket.socket) -> None:
        with suppress(struct.error):  # where it is not asked to start
            stream_of(silence)(client)

    monkeypatch.setattr(rtde_arm.RtdeClient, "start", lambda *_: INPUTS)
    less, path = Live(exported("torque_less_gravity")), tmp_path / "live.parquet"
    lacks = "does not state actual_current_as_torque"
    with controller(serve) as port, pytest.raises(InputError, match=lacks):
        record(less, Stream(HERE, 1.0, port), path, print)
    whole = Live(exported("torque"))
    with pytest.raises(InputError, match="by whole ones; identify it"):
        record(whole, Stream(HERE, 1.0, port), path, print)


def test_refused_efforts_are_told_at_the_end(tmp_path: Path) -> None:
    estimator = Live(exported())
    assert estimator.efforts is not None
    estimator.efforts.refused = "of another kind"
    with controller(stream_of(silence, count=1)) as port:
        stream = Stream(HERE, 0.3, port)
        ended = record(estimator, stream, tmp_path / "live.parquet", lambda *_: None)
    assert ended.failed
    assert ended.in_words().endswith("; of another kind")


def test_nothing_came(tmp_path: Path) -> None:
    path = tmp_path / "live.parquet"
    ended = followed(stream_of(silence, count=0), path, seconds=0.3)
    assert ended.failed
    assert ended.in_words().startswith("no sample came")
    assert [*tmp_path.iterdir()] == []


def test_a_full_disk_keeps_whole_rows_and_is_told(tmp_path: Path) -> None:
    """As a limit on the size of files, below that of some samples."""
    path = tmp_path / "live.parquet"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (6_000, before[1]))
    try:
        ended = followed(stream_of(silence), path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert ended.failed
    assert "cannot be written" in ended.in_words()
    [part] = tmp_path.glob("*.part.csv")
    assert part == ended.path
    assert part.read_text().endswith("\n")
    assert len(pd.read_csv(part)) == ended.samples


def test_rows_are_written_each_second_and_the_next_run_says_what_was_left(tmp_path: Path) -> None:
    path = tmp_path / "live.parquet"
    journal = journal_of(path, ["time"], period=0.1)
    journal.write(["0.5", "0.6"])
    time.sleep(0.12)
    journal.write(["0.7"])
    journal.write(["0.8"])  # lost, where the process is killed now
    assert pd.read_csv(journal.path)["time"].tolist() == [0.5, 0.6, 0.7]
    [line] = left_behind(path)
    assert f"{journal.path} was left by another run, or is written by one, with 3 samples" in line
    journal.close()
    again = journal_of(path, ["time"])
    again.close()
    assert again.path != journal.path
    assert len(pd.read_csv(journal.path)) == 4


LIVE = """
import sys
from pathlib import Path
from tests.topics.live.made_arm import arm_file
from ur5lab.live import Stream, record
from ur5lib.topics.live.live import Live
stream = Stream("127.0.0.1", None, int(sys.argv[1]))
record(Live(arm_file()), stream, Path(sys.argv[2]), lambda *_: None)
"""


@pytest.mark.slow
@pytest.mark.real_time
def test_a_killed_run_leaves_all_rows_but_of_the_last_second(tmp_path: Path) -> None:
    """By SIGKILL, while samples come on."""
    path, begun = tmp_path / "live.parquet", list[float]()

    def go_on(client: socket.socket) -> None:
        with suppress(OSError):  # of a client that was killed
            while True:
                send_sample(client, len(begun))
                begun.append(time.monotonic())
                time.sleep(PERIOD)

    with controller(stream_of(go_on, count=0)) as port:
        command = [sys.executable, "-c", LIVE, str(port), str(path)]
        path_of = os.environ | {"PYTHONPATH": str(PROJECT)}
        with subprocess.Popen(command, env=path_of, cwd=PROJECT) as live:
            while not begun or time.monotonic() - begun[0] < 3.7:
                time.sleep(0.05)
            killed = time.monotonic()
            live.kill()
    [part] = tmp_path.iterdir()
    table = pd.read_csv(part)
    assert part.read_text().endswith("\n")
    np.testing.assert_allclose(table["time"], PERIOD * np.arange(len(table)))
    late = 0.5  # s, of a computer that does other work, too
    assert len(table) > np.searchsorted(begun, killed - FLUSH_PERIOD - late)
    assert (
        f"{part} was left by another run, or is written by one, with {len(table)} samples"
        in left_behind(path)[0]
    )


def test_a_handshake_has_one_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller that answers byte by byte, each before a byte's own limit."""
    monkeypatch.setattr(rtde_arm, "HANDSHAKE_TIMEOUT", 0.5)
    over = threading.Event()

    def drip(client: socket.socket) -> None:
        for byte in 100 * b"\0\x50":
            if over.wait(0.1):
                return
            try:
                client.sendall(bytes([byte]))
            except OSError:
                return

    begin = time.monotonic()
    with controller(drip) as port:
        with pytest.raises(InputError, match="no controller answers by RTDE"):
            record(Live(arm_file()), Stream(HERE, None, port), tmp_path / "x.parquet", print)
        over.set()
    assert time.monotonic() - begin < 3.0
