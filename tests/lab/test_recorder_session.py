"""Sessions of the recorder with doubles of devices, which know when they took each sample."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PosixPath
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.entries import read_recording
from tests.lab.made_up_device import MadeUp
from ur5lab.doubles.controller_double import ControllerDouble, Ports
from ur5lab.doubles.device_double import HOST, DeviceClock
from ur5lab.doubles.net_ft_double import NetFTDouble
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.doubles.xsens_double import XsensDouble
from ur5lab.recorder.capture import Status, capture
from ur5lab.recorder.opened import file_entry
from ur5lab.recorder.session import MANIFEST, Session, left_behind, write_manifest
from ur5lib.errors import InputError
from ur5lib.recordings.recording import RawRecording
from ur5lib.recordings.starts import place_sensors
from ur5lib.records.quality import Finding
from ur5lib.study.devices import (
    ArmSettings,
    LabSettings,
    NetFTSettings,
    XsensSettings,
)
from ur5lib.study.model import RtdeRecording
from ur5lib.tables import read_json

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

BORN = time.monotonic()  # sensors read the time since, by the host's clock,
SCALE = 0.01  # per s, so that no reading is beyond what a sensor can read
SECONDS = 15.0  # shorter than the 60 s that are promised, so that clocks are harder to tell
PROMPT = 60.0  # s, more than anything takes even on a busy computer


def age(now: float) -> np.ndarray:
    """Return the same time for each channel."""
    return np.full(9, SCALE * (now - BORN))


@contextmanager
def lab(
    rate: int = 125, faults: TransmissionFaults = TransmissionFaults()
) -> Iterator[tuple[LabSettings, ControllerDouble]]:
    """An arm and both sensors; faults: of the force sensor."""
    slow = DeviceClock(drift_ppm=200.0)
    controller = ControllerDouble("ur5e", rate=rate, ports=Ports.free(), clock=slow)
    box = NetFTDouble(lambda now: age(now)[:6], 500.0, DeviceClock(drift_ppm=-800.0), faults)
    imu = XsensDouble(age, 100.0, DeviceClock(drift_ppm=-3000.0))
    with controller, box, imu:
        yield (
            LabSettings(
                robot=ArmSettings(address=HOST, rate_hz=rate, port=controller.setup.ports.rtde),
                force_sensor=NetFTSettings(address=HOST, port=box.port, http_port=box.http_port),
                imu=XsensSettings(port=imu.path, rate_hz=100.0),
            ),
            controller,
        )


def until(condition: object) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + PROMPT
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def read_back(devices: LabSettings, folder: Path) -> RawRecording:
    """Read a recording by the entry that `ur5 record` gives it."""
    entry: dict[str, object] = {"name": "run", "role": "contact", "robot": "ur5e"}
    entry["folder"] = str(folder)
    entry |= file_entry(devices.robot, "robot.csv")
    entry |= {n: file_entry(d, f"{n}.csv") for n, d in devices.devices().items() if n != "robot"}
    return read_recording(RtdeRecording.model_validate(entry).model_dump())


def behind(controller: ControllerDouble) -> float:
    """Return how far a controller's double is behind the time [s]."""
    due = controller.clock.shown(time.monotonic()) - controller.setup.clock.offset_s
    return due - controller.ask("time")


@pytest.fixture(scope="module")
def recorded(
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[LabSettings, Path, ControllerDouble]:
    """A session of some seconds, with its manifest; refused where the arm could not keep up."""
    folder = tmp_path_factory.mktemp("session") / "run"
    with lab() as (devices, controller):
        with Session(devices.devices(), folder) as session:
            write_manifest(folder, session.identities(), None, None)
            assert not read_json(folder / MANIFEST)["complete"]
            assert left_behind(folder)
            lags = [behind(controller)]
            time.sleep(SECONDS)
            lags.append(behind(controller))
        assert max(lags) < 0.02, f"this computer is too busy: the arm is {lags} s behind"
        write_manifest(folder, session.identities(), session.statuses(), None)
    assert not left_behind(folder)
    return devices, folder, controller


def test_the_clocks_of_all_devices_agree_within_two_milliseconds(
    recorded: tuple[LabSettings, Path, ControllerDouble],
) -> None:
    """Without anything that moves."""
    devices, folder, controller = recorded
    raw = read_back(devices, folder)
    first = float(pd.read_csv(folder / "robot.csv", nrows=1)["timestamp"].iloc[0])
    for name, (record, start) in place_sensors(raw, []).items():
        channel = "ft_fx" if name == "force" else "imu_ax"
        true = BORN + record.table[channel].to_numpy() / SCALE  # of the host
        on_robot = first + start.seconds + record.table["time"].to_numpy()
        error = np.asarray(controller.clock.host(on_robot)) - true
        assert np.abs(error).max() < 0.002, name


def test_nothing_is_lost_and_the_manifest_says_what_recorded(
    recorded: tuple[LabSettings, Path, ControllerDouble],
) -> None:
    manifest = read_json(recorded[1] / MANIFEST)
    assert manifest["complete"]
    for name, rate in (("robot", 125), ("force_sensor", 500), ("imu", 100)):
        entry = manifest["devices"][name]
        assert entry["lost"] == 0
        assert entry["recorded_rate_hz"] == pytest.approx(rate, rel=0.02)
        assert entry["ended"] is None
        rows = (recorded[1] / entry["file"]).read_text().count("\n") - 1
        assert rows == entry["samples"]
    # Time stamps are multiples of the cycle after the start, as the controller sent them.
    stamps = pd.read_csv(recorded[1] / "robot.csv")["timestamp"].to_numpy()
    assert np.abs(np.diff(stamps) - 0.008).max() < 1e-9


@pytest.mark.thorough
def test_a_device_that_dies_leaves_the_others(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Whose processes end without a word, while their devices still send."""
    with lab(faults=TransmissionFaults(dies_at=8.0)) as (devices, _):
        with Session(devices.devices(), tmp_path / "run") as session:
            until(lambda: all(status.samples > 100 for status in session.statuses().values()))
            until(lambda: session.statuses()["force_sensor"].ended)
            before = session.statuses()["robot"].samples
            until(lambda: session.statuses()["robot"].samples > before + 20)
        statuses = session.statuses()
    assert capfd.readouterr().err == ""
    assert "Net F/T" in (statuses["force_sensor"].ended or "")
    assert statuses["robot"].ended is None
    assert statuses["imu"].ended is None
    raw, findings = read_back(devices, tmp_path / "run"), list[Finding]()
    assert set(place_sensors(raw, findings)) == {"force", "imu"}, (raw.findings, findings)


@pytest.mark.thorough
@pytest.mark.parametrize(("hangs_in", "expected"), [("close", None), ("read", "did not end")])
def test_a_device_that_does_not_close_loses_no_sample(
    hangs_in: str, expected: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the manifest counts is what the file holds, or it says that it may hold more."""
    monkeypatch.setattr("ur5lab.recorder.session.CLOSING_TIMEOUT", 2.0)
    plan: Any = MadeUp(hangs_in)
    with Session({"imu": plan}, tmp_path / "run") as session:
        until(lambda: session.statuses()["imu"].samples > 50)
        time.sleep(0.7)
    status, rows = session.statuses()["imu"], (tmp_path / "run" / "imu.csv").read_text()
    assert (expected or "") in str(status.ended)
    assert (status.ended is None) == (expected is None)
    if expected is None:
        assert status.samples == rows.count("\n") - 1


@pytest.mark.thorough
def test_a_recording_goes_on_though_nobody_asks_for_its_progress(tmp_path: Path) -> None:
    plan: Any = MadeUp(width=500)  # so that reports soon fill a pipe
    with Session({"imu": plan}, tmp_path / "run") as session:
        time.sleep(3.0)
    status, rows = session.statuses()["imu"], (tmp_path / "run" / "imu.csv").read_text()
    assert status.ended is None
    assert status.samples == rows.count("\n") - 1
    assert status.seconds > 2.0


def test_of_several_devices_that_are_not_there_one_is_said(tmp_path: Path) -> None:
    absent = {name: XsensSettings(port=str(tmp_path / name)) for name in ("imu", "other")}
    with pytest.raises(InputError, match="imu"), Session(absent, tmp_path / "run"):
        pass


class FullDisk(PosixPath):
    """The device that is always full, as a file that is new."""

    def open(self, mode: str = "r", *more: Any, **named: Any) -> Any:
        return super().open(mode.replace("x", "w"), *more, **named)


def test_a_full_disk_is_said() -> None:
    here, there = multiprocessing.Pipe()
    handler, plan, stop = signal.getsignal(signal.SIGINT), MadeUp(), multiprocessing.Event()
    try:
        capture(plan, FullDisk("/dev/full"), 0.0, there, stop)
    finally:
        signal.signal(signal.SIGINT, handler)
    identity, status = here.recv(), here.recv()
    assert identity.model == "made up"
    assert isinstance(status, Status)
    assert "cannot be written (No space left on device)" in str(status.ended)


RECORD = """
import sys, time
from pathlib import Path
if __name__ == "__main__":  # not in the processes that it starts
    from tests.lab.test_recorder_session import lab
    from ur5lab.recorder.session import Session, write_manifest
    folder = Path(sys.argv[1])
    with lab() as (devices, _), Session(devices.devices(), folder) as session:
        write_manifest(folder, session.identities(), None, None)
        while True:
            if all(status.samples for status in session.statuses().values()):
                print("recording", flush=True)
            time.sleep(0.1)
"""


@pytest.mark.thorough
def test_a_killed_recorder_leaves_whole_files(tmp_path: Path) -> None:
    """By SIGKILL: its processes notice, and end."""
    script, folder = tmp_path / "record.py", tmp_path / "run"
    script.write_text(RECORD)
    command = [sys.executable, str(script), str(folder)]
    path = {"PYTHONPATH": str(PROJECT)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=os.environ | path) as recorder:
        assert recorder.stdout is not None
        for _ in range(20):
            assert recorder.stdout.readline() == b"recording\n"
        recorder.kill()
    sizes: list[int] = []

    def settled() -> bool:
        sizes.append(sum(file.stat().st_size for file in folder.iterdir()))
        return len(sizes) > 40 and len(set(sizes[-40:])) == 1

    until(settled)
    said = left_behind(folder)
    for name in ("robot", "force_sensor", "imu"):
        rows = (folder / f"{name}.csv").read_text().splitlines()
        assert {row.count(",") for row in rows} == {rows[0].count(",")}
        assert len(rows) > 100
        assert f"{name}.csv has {len(rows) - 1} samples" in said
