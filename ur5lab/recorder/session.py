"""A session: all devices recorded together, each by its own process, and its manifest."""

import errno
import multiprocessing
import platform
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

from ur5lab.journal import rows_in
from ur5lab.recorder.capture import Status, capture
from ur5lab.recorder.device import Identity
from ur5lib import __version__
from ur5lib.errors import InputError
from ur5lib.study.devices import DeviceSettings
from ur5lib.tables import checksum, read_json, write_json

MANIFEST = "manifest.json"
HOST_CLOCK = "time.monotonic of the host, plus its difference to seconds since 1970 at the start"
START_TIMEOUT = 30.0  # s; for a device's process to start and the device to answer
CLOSING_TIMEOUT = 10.0  # s; for all processes to write their last samples
POLL_INTERVAL = 0.05  # s between queries of their reports meanwhile


@dataclass
class _Worker:
    process: Any
    connection: Connection
    identity: Identity | None
    status: Status


class Session:
    """Devices being recorded into a folder: `with Session(devices, folder) as session:`.

    devices: by name; folder: gets `<name>.csv` of each. All have answered when the context begins.
    """

    def __init__(self, devices: Mapping[str, DeviceSettings], folder: Path) -> None:
        self._devices, self._folder = devices, folder
        # a fork would copy the locks of other threads
        self._context = multiprocessing.get_context("spawn")
        self._stop = self._context.Event()
        self._workers: dict[str, _Worker] = {}
        self.zero = time.time() - time.monotonic()  # s; the same zero for all devices

    def __enter__(self) -> Self:
        """Start all devices. Raises InputError when one does not answer, or the folder exists; none
        records then.
        """
        new_folder(self._folder)
        try:
            for name, settings in self._devices.items():
                here, there = self._context.Pipe()
                arguments = settings, self._folder / f"{name}.csv", self.zero, there, self._stop
                process = self._context.Process(target=capture, args=arguments, daemon=True)
                process.start()
                there.close()
                self._workers[name] = _Worker(process, here, None, Status())
            for name, worker in self._workers.items():
                worker.identity = self._answer(name, worker)
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def identities(self) -> dict[str, Identity]:
        """Return each device's entry in the manifest, by name."""
        identities = {name: worker.identity for name, worker in self._workers.items()}
        return {name: identity for name, identity in identities.items() if identity}

    def statuses(self) -> dict[str, Status]:
        """Return the progress of each device so far, by name."""
        for name, worker in self._workers.items():
            self._listen(name, worker)
        return {name: worker.status for name, worker in self._workers.items()}

    def close(self) -> None:
        """Stop all devices; returns when their files are closed."""
        self._stop.set()
        end = time.monotonic() + CLOSING_TIMEOUT
        for name, worker in self._workers.items():
            while worker.process.is_alive() and time.monotonic() < end:
                self._listen(name, worker)
                worker.process.join(POLL_INTERVAL)
            self._listen(name, worker)
            is_late = worker.process.is_alive()
            if is_late:
                worker.process.kill()
            if worker.status.ended is None and not worker.status.final:
                cause = f"did not end within {CLOSING_TIMEOUT:g} s" if is_late else "was killed"
                worker.status.ended = (
                    f"the process that records {name} {cause}; its file may have samples that are "
                    "not counted here"
                )

    def _answer(self, name: str, worker: _Worker) -> Identity:
        try:
            answer = worker.connection.recv() if worker.connection.poll(START_TIMEOUT) else None
        except EOFError:
            answer = None
        if isinstance(answer, Identity):
            return answer
        raise InputError(answer or f"{name} does not answer; check its cable and its address")

    def _listen(self, name: str, worker: _Worker) -> None:
        """Take the last report from a device's process; one that died without a report counts as
        ended.
        """
        try:
            while worker.connection.poll():
                report = worker.connection.recv()
                if isinstance(report, Status):  # else an answer that nobody waited for
                    worker.status = report
        except (EOFError, OSError):
            if worker.status.ended is None and not self._stop.is_set():
                worker.status.ended = f"the process that records {name} was killed"


def new_folder(folder: Path) -> None:
    """Make a recording's folder, in place of an empty one. Raises InputError if it exists, even
    since a moment ago.
    """
    try:
        with suppress(FileNotFoundError):
            folder.rmdir()
        folder.mkdir(parents=True)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
            raise
        raise taken(folder) from error


def is_taken(folder: Path) -> bool:
    """Return whether a recording, or a file, has the name already; an empty folder is none."""
    return folder.exists() and not (folder.is_dir() and not any(folder.iterdir()))


def taken(folder: Path) -> InputError:
    """Return the error of a recording with the folder of another."""
    return InputError(f"{folder} exists; give the recording another name")


def left_behind(folder: Path) -> str:
    """Return a line of text on the files that an interrupted session, as by a power failure, left
    in a folder, "" if there are none.
    """
    manifest = folder / MANIFEST
    try:
        if not manifest.is_file() or read_json(manifest)["complete"]:
            return ""
    except (InputError, KeyError, TypeError):  # a file of another program
        return ""
    files = sorted(folder.glob("*.csv"))
    counts = ", ".join(f"{file.name} has {rows_in(file)} samples" for file in files)
    return f"{folder} was left by a session that was cut off; {counts or 'it has no files'}"


def write_manifest(
    folder: Path,
    identities: Mapping[str, Identity],
    statuses: Mapping[str, Status] | None,
    moved: str | None,
) -> None:
    """Write a session's manifest; statuses: at the end, None before; moved: the commanded motion,
    None without one.
    """
    entries = {
        name: {key: value for key, value in vars(identity).items() if value is not None}
        for name, identity in identities.items()
    }
    for name, status in (statuses or {}).items():
        file = folder / f"{name}.csv"
        entries[name] |= {
            "file": file.name,
            "sha256": checksum(file) if file.is_file() else None,
            "samples": status.samples,
            "lost": status.lost,
            "recorded_rate_hz": round(status.rate(), 3),
            "ended": status.ended,
        }
    write_json(
        {
            "written": datetime.now(UTC).isoformat(timespec="seconds"),
            "complete": statuses is not None,
            "host": platform.node(),
            "clock": HOST_CLOCK,
            "ur5lib": __version__,
            "motion": moved,
            "devices": entries,
        },
        folder / MANIFEST,
    )
