"""`ur5 live` and `ur5 record`, killed at drawn moments of their start or their work."""

import os
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.lab.test_live_ends import COUNT, LIVE, Serve, hang_up, send_sample, stream_of
from tests.lab.test_record import STUDY
from tests.lab.test_recorder_faults import HERE, controller
from tests.topics.live.made_arm import PERIOD
from ur5lab.journal import FLUSH_PERIOD, left_behind
from ur5lab.recorder.session import is_taken
from ur5lib.tables import read_json, read_table

KILLS = 13  # of each; the node's are in tests/topics/live
LATE = 0.5  # s, of a computer that does other work, too
PROMPT = 60.0  # s, more than anything takes even on a busy computer
Program = subprocess.Popen[str]
UR5 = [sys.executable, "-c", "from ur5lib.cli import main; main()"]
pytestmark = [pytest.mark.thorough, pytest.mark.slow, pytest.mark.real_time]


@contextmanager
def running(folder: Path, *command: object) -> Iterator[Program]:
    """A program in a session of its own, killed with all that it started."""
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "TMPDIR": str(folder)}
    with subprocess.Popen(
        [*map(str, command)], env=environment, cwd=folder, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def started_by(process: Program) -> list[str]:
    """The processes of a program's session, without itself."""
    found = []
    for own in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            _, _, rest = (own / "stat").read_text().rpartition(")")
            state, _, _, session, *_ = rest.split()
            if int(session) == process.pid != int(own.name) and state != "Z":
                found.append(own.name)
    return found


def killed(process: Program) -> float:
    """Kill a program alone; return when, as soon as all that it started has ended."""
    moment = time.monotonic()
    process.kill()
    process.wait()
    while started_by(process):
        assert time.monotonic() < moment + PROMPT
        time.sleep(0.05)
    return moment


def sends_to(sent: list[float]) -> Serve:
    """A controller that sends samples until its client is gone, and notes when."""

    def go_on(client: socket.socket) -> None:
        while True:
            send_sample(client, len(sent))
            sent.append(time.monotonic())
            time.sleep(PERIOD)

    def serve(client: socket.socket) -> None:
        with suppress(OSError, struct.error):  # of a client that was killed
            stream_of(go_on, count=0)(client)

    return serve


def whole_live(path: Path) -> float:
    """Follow a stream to its end; returns how long it took [s]."""
    begin = time.monotonic()
    with controller(stream_of(hang_up)) as port, live(port, path) as process:
        process.communicate(timeout=PROMPT)
    return time.monotonic() - begin


def live(port: int, path: Path) -> AbstractContextManager[Program]:
    return running(path.parent, sys.executable, "-c", LIVE, port, path)


def test_what_live_has_written_stays_at_any_moment_and_the_next_start_works(
    tmp_path: Path,
) -> None:
    """All rows but of the last second; each part is told to the next run."""
    path, random, parts = tmp_path / "live.parquet", np.random.default_rng(0), dict[Path, int]()
    whole = whole_live(path)
    for _ in range(KILLS):
        sent: list[float] = []
        with controller(sends_to(sent)) as port, live(port, path) as process:
            time.sleep(random.uniform(0.0, 2 * whole))
            moment = killed(process)
            with suppress(OSError):  # in place of one that had not come yet
                socket.create_connection((HERE, port)).close()
        due = int(np.searchsorted(sent, moment - FLUSH_PERIOD - LATE))
        new = {*tmp_path.glob("*.part.csv")} - {*parts}
        assert (due > 0) <= len(new) <= 1
        for part in new:
            table = pd.read_csv(part)
            assert part.read_text().endswith("\n")
            np.testing.assert_allclose(table["time"].astype(float), PERIOD * np.arange(len(table)))
            assert len(table) >= due
            parts[part] = len(table)
    whole_live(path)
    assert len(read_table(path)) == len(read_table(tmp_path / "live.2.parquet")) == COUNT
    told = left_behind(path)
    assert len(told) == len(parts) > 0
    for part, count in parts.items():
        assert any(f"{part} was left" in line and f"with {count} samples" in line for line in told)


def recording(folder: Path, name: str) -> AbstractContextManager[Program]:
    return running(folder, *UR5, "record", "lab.yaml", name, "--seconds", 2, "--emulate")


def whole_recording(folder: Path, name: str) -> tuple[float, str]:
    """Record to the end; returns how long it took [s], and what it said."""
    begin = time.monotonic()
    with recording(folder, name) as process:
        said, _ = process.communicate(timeout=PROMPT)
    assert read_json(folder / "raw" / "lab" / name / "manifest.json")["complete"], said
    return time.monotonic() - begin, said


def contents(folder: Path) -> dict[Path, bytes]:
    return {own: own.read_bytes() for own in folder.glob("*.csv")}


@pytest.mark.usefixtures("controller_ports")
def test_what_record_has_written_stays_at_any_moment_and_the_next_start_works(
    tmp_path: Path,
) -> None:
    """In whole rows; a folder in which nothing was written blocks no name."""
    (tmp_path / "lab.yaml").write_text(STUDY)
    random, raw, number, kept = np.random.default_rng(0), tmp_path / "raw" / "lab", 0, list[Path]()
    whole, _ = whole_recording(tmp_path, "first")
    for _ in range(KILLS):
        folder = raw / f"run_{number}"
        with recording(tmp_path, folder.name) as process:
            time.sleep(random.uniform(0.0, whole))
            before = contents(folder)
            killed(process)
        for file, found in contents(folder).items():
            assert found.startswith(before.get(file, b""))
            assert len({row.count(b",") for row in found.splitlines()}) == 1
            assert found.endswith(b"\n")
        if is_taken(folder):
            number += 1
            kept.append(folder)
    _, said = whole_recording(tmp_path, f"run_{number}")
    for folder in kept:
        assert (f"{folder.relative_to(tmp_path)} was left by a session" in said) == (
            folder / "manifest.json"
        ).is_file()
    assert kept
