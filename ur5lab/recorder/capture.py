"""One device, recorded into its file by a process of its own."""

import copy
import multiprocessing
import os
import queue
import signal
import threading
import time
from contextlib import closing
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from ur5lab.journal import Journal
from ur5lab.recorder.device import Device, DeviceLost, NewSamples, Packets
from ur5lab.recorder.opened import opened
from ur5lib.commands.processes import end_with_parent
from ur5lib.errors import InputError
from ur5lib.study.devices import DeviceSettings

REPORT_INTERVAL = 0.25  # s between reports to the recorder
HOST_TIME_COLUMN = "host_time"


@dataclass
class Status:
    """The progress of recording one device.

    samples, lost: numbers of samples recorded and lost; seconds: from its first sample to its last;
    latest: its last sample, by column; low, high: smallest and largest value of each column;
    ended: why the recording stopped early, None if it did not; final: whether the file is closed.
    """

    samples: int = 0
    lost: int = 0
    seconds: float = 0.0
    latest: dict[str, float] = field(default_factory=dict)
    low: dict[str, float] = field(default_factory=dict)
    high: dict[str, float] = field(default_factory=dict)
    ended: str | None = None
    final: bool = False

    def rate(self) -> float:
        """Return the mean number of samples per second so far."""
        return self.samples / self.seconds if self.seconds > 0 else 0.0


class SampleFile:
    """A CSV to which samples are appended, at any time valid up to the last line.

    One row a sample, with all digits of its numbers; the host's time is the first column, or the
    last one where the device has its own `timestamp`. Packets of bytes are rows
    `received_s,payload_hex`.
    """

    def __init__(self, path: Path, columns: tuple[str, ...]) -> None:
        self._has_clock = columns[0] == "timestamp"
        time = "received_s" if columns == ("payload_hex",) else HOST_TIME_COLUMN
        names = (*columns, time) if self._has_clock else (time, *columns)
        self._journal = Journal(path, names, period=0.0)

    def write(self, samples: NewSamples | Packets, zero: float) -> None:
        """Append samples; zero: time of the host's clock when time.monotonic read zero [s]."""
        arrived = (zero + samples.received).tolist()
        if isinstance(samples, Packets):
            packets = zip(arrived, samples.packets, strict=True)
            lines = [f"{time:.6f},{packet.hex()}" for time, packet in packets]
        else:
            rows = zip(arrived, samples.values.tolist(), strict=True)
            lines = [
                ",".join(map(repr, [*values, time] if self._has_clock else [time, *values]))
                for time, values in rows
            ]
        self._journal.write(lines)

    def close(self) -> None:
        """Close the file."""
        self._journal.close()


def capture(
    settings: DeviceSettings, path: Path, zero: float, line: Connection, stop: Event
) -> None:
    """Record a device into a file until `stop` is set; runs in the device's own process.

    zero: as in SampleFile.write. Sends through `line`: first the device's entry for the manifest,
    or why it cannot be recorded; then its Status repeatedly, and once at the end.
    """
    end_with_parent()
    started_by = multiprocessing.parent_process()  # which may have ended meanwhile
    parent = os.getppid() if started_by is None or started_by.pid is None else started_by.pid
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the recorder handles Ctrl-C
    try:
        device = opened(settings)
    except InputError as error:
        line.send(str(error))
        return
    line.send(device.identity)
    status = Status()
    with closing(device):  # after the last report, since a device may take long to answer
        try:
            _record(device, path, zero, line, stop, status, parent)
        except DeviceLost as error:
            status.ended = str(error)
        except OSError as error:
            status.ended = f"{path} cannot be written ({error.strerror}); free some space"
        except Exception as error:  # a fault of this recorder must not end the others
            status.ended = f"recording it failed ({type(error).__name__}: {error})"
        status.final = True
        if os.getppid() == parent:
            line.send(status)


def _record(
    device: Any,
    path: Path,
    zero: float,
    line: Connection,
    stop: Event,
    status: Status,
    parent: int,
) -> None:
    """Write a device's samples to its file until `stop`, or until the recorder's process has ended;
    `status` is updated and reported.
    """
    file = SampleFile(path, device.columns)
    received: queue.SimpleQueue[Any] = queue.SimpleQueue()
    over = threading.Event()
    reports: queue.SimpleQueue[Status | None] = queue.SimpleQueue()
    # A disk may block for seconds, and a device's buffer overflows sooner: a thread reads it.
    reader = threading.Thread(target=_read, args=(device, received, over), daemon=True)
    # A recorder that does not fetch reports must not block the recording: a thread sends them.
    reporter = threading.Thread(target=_report, args=(line, reports), daemon=True)
    reader.start()
    reporter.start()
    first: float | None = None
    reported = 0.0
    try:
        while not stop.is_set() and os.getppid() == parent:
            samples = received.get()
            if isinstance(samples, Exception):
                raise samples
            file.write(samples, zero)
            if len(samples.received):
                first = samples.received[0] if first is None else first
                _count(status, device, samples, first)
            if time.monotonic() - reported > REPORT_INTERVAL and reports.empty():
                reported = time.monotonic()
                reports.put(copy.deepcopy(status))
    finally:
        over.set()
        reader.join()
        file.close()
        reports.put(None)
        reporter.join(REPORT_INTERVAL if os.getppid() != parent else None)


def _read(device: Any, received: queue.SimpleQueue[Any], over: threading.Event) -> None:
    """Put a device's samples into a queue until `over`; also an exception, which a thread would
    swallow.
    """
    try:
        while not over.is_set():
            received.put(device.read())
    except Exception as error:
        received.put(error)


def _report(line: Connection, reports: queue.SimpleQueue[Status | None]) -> None:
    """Send reports from a queue until it gives None, or until the recorder was killed."""
    try:
        while (status := reports.get()) is not None:
            line.send(status)
    except BrokenPipeError:  # the samples are in the file
        return


def _count(status: Status, device: Device, samples: NewSamples | Packets, first: float) -> None:
    status.lost += samples.lost
    status.seconds = float(samples.received[-1] - first)
    if isinstance(samples, Packets):
        status.samples += samples.messages
        return
    status.samples += len(samples.received)
    low, high = samples.values.min(axis=0).tolist(), samples.values.max(axis=0).tolist()
    for name, least, most in zip(device.columns, low, high, strict=True):
        status.low[name] = min(least, status.low.get(name, least))
        status.high[name] = max(most, status.high.get(name, most))
    status.latest = dict(zip(device.columns, samples.values[-1].tolist(), strict=True))
