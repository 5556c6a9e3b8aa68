"""`ur5 live`: the contact force on a running arm, stated sample by sample from its currents."""

import time
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import csv
from rich.console import Console
from rich.live import Live as Display

from ur5lab.journal import Journal, journal_of, left_behind
from ur5lab.recorder.device import DeviceLost, Silence
from ur5lab.recorder.rtde_arm import (
    DEFAULT_RATE,
    PORT,
    RATE_BY_MAJOR_VERSION,
    READ_TIMEOUT,
    RtdeClient,
)
from ur5lib.commands.interrupts import signals_interrupt
from ur5lib.errors import InputError, NameTaken
from ur5lib.finished import StudyFiles
from ur5lib.tables import write_new
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.topics.live.arm_file import known_of_arm
from ur5lib.topics.live.live import CONTACT, FREE, UNKNOWN, Answer, Live

INPUTS = ("timestamp", "actual_q", "actual_qd", "actual_current")
TORQUES = (*INPUTS[:3], "actual_current_as_torque")  # less gravity
PARTS = ("Fx", "Fy", "Fz", "nx", "ny", "nz")
UNITS = {"time": "s"}
for prefix in ("live", "live_std"):
    UNITS |= {f"{prefix}_{part}": "N" if part[0] == "F" else "Nm" for part in PARTS}
UNITS |= {"evidence": "1", "contact": "1", "known": "1"}
for name in ("untouched", "hidden", "hidden_at_all"):
    UNITS |= {f"{name}_{axis}": "N" for axis in "xyz"}
UNITS |= {"link": "1", "off_flange": "1", "late": "s"}
SHOWN_PERIOD = 0.2  # s

Show = Callable[[float, Answer, str], None]


@dataclass(frozen=True)
class Stream:
    """Where an arm's samples come from, and for how long.

    address, port: of its controller's RTDE; seconds: duration, None until the arm sends nothing for
    a second or Ctrl-C.
    """

    address: str
    seconds: float | None = None
    port: int = PORT


@dataclass(frozen=True)
class Ended:
    """How a stream ended: path of the written file, number of samples, why it ended, and whether
    the arm was lost.
    """

    path: Path
    samples: int
    why: str
    lost: bool

    @property
    def failed(self) -> bool:
        """Return whether the stream ended early, or had no samples."""
        return self.lost or self.samples == 0

    def in_words(self) -> str:
        """Return a line of text on how the stream ended."""
        if self.samples == 0:
            return f"no sample came; ended by {self.why}"
        return f"{self.path}: {self.samples} samples; ended by {self.why}"


def live(
    results: Path, robot: str | None, as_in: str, stream: Stream, write: Path, console: Console
) -> Ended:
    """State the contact force on an arm that a study fitted, and write it until the stream ends.

    as_in: recording with the payload and mounting to use, "" for none. Raises InputError if the
    report states no force, or no controller answers.
    """
    study = StudyFiles(results)
    arms = sorted({one.arm.known_as for one in study.configuration().recordings})
    if robot is None and len(arms) != 1:
        raise InputError(f"{results} has the arms {', '.join(arms)}; name one by --robot")
    arm = known_of_arm(study, robot or arms[0], as_in)
    if write.exists():
        raise InputError(f"{write} exists; give another name by --output")
    for line in left_behind(write):
        console.print(line)
    view = Display(console=console, auto_refresh=False) if console.is_terminal else None
    with view or nullcontext():
        return record(Live(arm), stream, write, _nothing if view is None else shown_on(view))


def record(estimator: Live, stream: Stream, path: Path, show: Show) -> Ended:
    """Write each answer of the estimator at once to a CSV next to `path`, and at the end all as
    Parquet, under `<name>.2` where the name was taken meanwhile; return how the stream ended.

    The file has the columns of `live_forces.parquet`, and `late`, the time from a sample's arrival
    to its answer. The arm gets only the request for its samples. If the Parquet cannot be written,
    the CSV stays.
    """
    if estimator.input == "torque":
        raise InputError(
            "a UR states torques less gravity, and the arm was identified by whole ones; identify "
            "it by the controller's currents"
        )
    inputs = TORQUES if estimator.input == "torque_less_gravity" else INPUTS
    with closing(connected(stream, inputs)) as client:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            journal = journal_of(path, list(UNITS))
        except OSError as error:
            raise InputError(
                f"{path} cannot be written ({error.strerror}); name another"
            ) from error
        why, lost = followed(client, estimator, stream, journal, show)
    if estimator.refused:
        why, lost = f"{why}; {estimator.refused}", True
    try:
        if journal.rows:
            path = _written(path, partial(_join, journal.path))
    except InputError as error:
        return Ended(journal.path, journal.rows, f"{why}; {error}", lost=True)
    journal.path.unlink()
    return Ended(path, journal.rows, why, lost)


def connected(stream: Stream, inputs: tuple[str, ...] = INPUTS) -> RtdeClient:
    """Return the connection to the stream's controller, which sends `inputs`."""
    client = RtdeClient(stream.address, stream.port)
    try:
        rate = RATE_BY_MAJOR_VERSION.get(client.software[0], DEFAULT_RATE)
        if missing := {*inputs} - {*client.start(inputs, rate)}:
            names = ", ".join(sorted(missing))
            raise InputError(f"the controller at {stream.address} does not state {names}")
    except BaseException:
        client.close()
        raise
    return client


def followed(
    client: RtdeClient, estimator: Live, stream: Stream, journal: Journal, show: Show
) -> tuple[str, bool]:
    """Write the estimator's answers to an arm's samples until its stream ends; return why it ended,
    and whether the arm was lost.
    """
    silence, begin = Silence(stream.address), time.monotonic()
    shown = begin
    try:
        with signals_interrupt(), closing(journal):
            while stream.seconds is None or time.monotonic() - begin < stream.seconds:
                packages = client.receive(READ_TIMEOUT)
                silence.check(len(packages))
                journal.write(_answered(estimator, *package) for package in packages)
                if time.monotonic() - shown > SHOWN_PERIOD:
                    shown = time.monotonic()
                    show(shown - begin, estimator.answer, estimator.reason)
    except DeviceLost as error:
        return str(error), True
    except KeyboardInterrupt as error:
        return str(error) or "Ctrl-C", False
    except OSError as error:
        return f"{journal.path}, which cannot be written ({error.strerror})", True
    return f"--seconds {stream.seconds:g}", False


def _written(path: Path, write: Callable[[Path], object]) -> Path:
    """Write a file, under the next free name where another has taken its own; return its path."""
    number, name = 1, path
    while True:
        try:
            write_new(name, write)
            return name
        except NameTaken:
            number += 1
            name = path.with_stem(f"{path.stem}.{number}")


def _join(part: Path, aside: Path) -> None:
    """Write the rows of the journal `part` into the Parquet file `aside`, batch by batch."""
    schema = pa.schema(
        [
            pa.field(
                name, pa.bool_() if name in ("contact", "known") else pa.float64()
            ).with_metadata({"unit": unit})
            for name, unit in UNITS.items()
        ]
    )
    types = csv.ConvertOptions(column_types=schema)
    with (
        csv.open_csv(part, convert_options=types) as rows,
        pq.ParquetWriter(aside, schema, use_dictionary=False) as writer,
    ):
        for batch in rows:
            writer.write_batch(pa.RecordBatch.from_arrays(batch.columns, schema=schema))


def _answered(estimator: Live, arrived: float, values: tuple[float, ...]) -> str:
    """Return the CSV row with the answer to a package of the estimator's inputs; arrived: when it
    did [s, monotonic].
    """
    stamp, q, qd, current = values[0], values[1:7], values[7:13], values[13:19]
    wrench, std, contact, *limits, link, off_flange = estimator.step(stamp, q, qd, current)
    known = contact == CONTACT, contact != UNKNOWN
    late = time.monotonic() - arrived
    limited = [value for limit in limits for value in limit.tolist()]
    touched = (link, off_flange) if link else (np.nan, np.nan)
    row = stamp, *wrench.tolist(), *std.tolist(), estimator.evidence, *known, *limited
    return ",".join(map(repr, (*row, *touched, late)))


def in_words(seconds: float, answer: Answer, reason: str) -> str:
    """Return an answer, and why nothing is known, as a line of text; seconds: since the start.

    Of a free arm, the line has the largest contact that could be hidden along an axis.
    """
    force = "  ".join(
        f"{axis} {value:+6.1f} ± {NORMAL95 * std:4.1f}"
        for axis, value, std in zip("xyz", answer.wrench, answer.std, strict=False)
    )
    line = f"{seconds:8.1f} s  {answer.contact:9}  {force} N  {reason}".rstrip()
    if answer.contact != FREE:
        return line
    hidden, before = answer.hidden.max(), answer.hidden_at_all.max()
    line = f"{line}; a contact of up to {hidden:.0f} N could be hidden"
    return line if before < hidden + 0.5 else f"{line}, {before:.0f} N if it began before the rest"


def shown_on(view: Display) -> Show:
    """Return a function that shows an answer on a terminal."""
    return lambda *now: view.update(in_words(*now), refresh=True)


def _nothing(seconds: float, answer: Answer, reason: str) -> None:
    """Do nothing, in place of showing an answer, where there is no terminal."""
