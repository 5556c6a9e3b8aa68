"""`ur5 live`: the contact force on a running arm, stated sample by sample from its currents."""

import contextlib
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
from rich.console import Console
from rich.live import Live as Display

from ur5lab.recorder.device import DeviceLost, Silence
from ur5lab.recorder.rtde_arm import (
    DEFAULT_RATE,
    PORT,
    RATE_BY_MAJOR_VERSION,
    READ_TIMEOUT,
    RtdeClient,
)
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.tables import write_aside
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.topics.live.arm_file import known_of_arm
from ur5lib.topics.live.live import CONTACT, UNKNOWN, Answer, Live

INPUTS = ("timestamp", "actual_q", "actual_qd", "actual_current")
PARTS = ("Fx", "Fy", "Fz", "nx", "ny", "nz")
UNITS = {"time": "s"}
for prefix in ("live", "live_std"):
    UNITS |= {f"{prefix}_{part}": "N" if part[0] == "F" else "Nm" for part in PARTS}
UNITS |= {"evidence": "1", "contact": "1", "known": "1", "late": "s"}
PART = 2500  # rows that are written at once
SHOWN_PERIOD = 0.2  # s

Row = tuple[float, ...]
Show = Callable[[float, Answer], None]


@dataclass(frozen=True)
class Stream:
    """An arm whose force is stated.

    address, port: of its controller's RTDE; seconds: for which it is, None until it sends nothing
    for a second or Ctrl-C.
    """

    address: str
    seconds: float | None = None
    port: int = PORT


def live(
    results: Path, robot: str | None, as_in: str, stream: Stream, write: Path, console: Console
) -> str:
    """State the force of an arm that a study fitted; returns what was written.

    as_in: recording whose payload and mounting it has, "" for none. Raises InputError where the
    report states no force, or no controller answers.
    """
    study = FinishedStudy(results)
    arms = sorted({one.arm.known_as for one in study.configuration().recordings})
    if robot is None and len(arms) != 1:
        raise InputError(f"{results} has the arms {', '.join(arms)}; name one by --robot")
    arm = known_of_arm(study, robot or arms[0], as_in)
    if write.exists():
        raise InputError(f"{write} exists; give another name by --output")
    view = Display(console=console, auto_refresh=False) if console.is_terminal else None
    with view or nullcontext():
        count = record(Live(arm), stream, write, _nothing if view is None else shown_on(view))
    return f"{write}: {count} samples"


def record(estimator: Live, stream: Stream, path: Path, show: Show) -> int:
    """Write what is stated as Parquet, as it comes; returns the number of samples.

    The file has the columns of `live_forces.parquet`, and `late`: from a sample's arrival to its
    answer. Nothing is sent to the arm but the request for its samples.
    """
    schema = pa.schema(
        [
            pa.field(
                name, pa.bool_() if name in ("contact", "known") else pa.float64()
            ).with_metadata({"unit": unit})
            for name, unit in UNITS.items()
        ]
    )
    count = 0

    def write(aside: Path) -> None:
        nonlocal count
        with pq.ParquetWriter(aside, schema, use_dictionary=False) as writer:
            for rows in answers(estimator, stream, show):
                columns = [pa.array(own, one.type) for own, one in zip(zip(*rows), schema)]  # noqa: B905
                writer.write_table(pa.Table.from_arrays(columns, schema=schema))
                count += len(rows)

    write_aside(path, write)
    return count


def answers(estimator: Live, stream: Stream, show: Show) -> Iterator[list[Row]]:
    """Yield the answers to an arm's samples, many at a time, until its stream ends."""
    client = RtdeClient(stream.address, stream.port)
    try:
        rate = RATE_BY_MAJOR_VERSION.get(client.software[0], DEFAULT_RATE)
        if missing := {*INPUTS} - {*client.start(INPUTS, rate)}:
            names = ", ".join(sorted(missing))
            raise InputError(f"the controller at {stream.address} does not state {names}")
        rows: list[Row] = []
        silence, begin = Silence(stream.address), time.monotonic()
        shown = begin
        with contextlib.suppress(DeviceLost, KeyboardInterrupt):
            while stream.seconds is None or time.monotonic() - begin < stream.seconds:
                packages = client.receive(READ_TIMEOUT)
                silence.check(len(packages))
                rows += [_answered(estimator, *package) for package in packages]
                if time.monotonic() - shown > SHOWN_PERIOD:
                    shown = time.monotonic()
                    show(shown - begin, estimator.answer)
                if len(rows) >= PART:
                    yield rows
                    rows = []
        if rows:
            yield rows
    finally:
        client.close()


def _answered(estimator: Live, arrived: float, values: tuple[float, ...]) -> Row:
    """Return the row of a package of INPUTS."""
    stamp, q, qd, current = values[0], values[1:7], values[7:13], values[13:19]
    wrench, std, contact = estimator.step(stamp, q, qd, current)
    known = contact == CONTACT, contact != UNKNOWN
    late = time.monotonic() - arrived
    return (stamp, *wrench.tolist(), *std.tolist(), estimator.evidence, *known, late)


def in_words(seconds: float, answer: Answer) -> str:
    """Return an answer as a line."""
    force = "  ".join(
        f"{axis} {value:+6.1f} ± {NORMAL95 * std:4.1f}"
        for axis, value, std in zip("xyz", answer.wrench, answer.std, strict=False)
    )
    return f"{seconds:8.1f} s  {answer.contact:8}  {force} N"


def shown_on(view: Display) -> Show:
    """Return a function that shows an answer on a terminal."""
    return lambda seconds, answer: view.update(in_words(seconds, answer), refresh=True)


def _nothing(seconds: float, answer: Answer) -> None:
    """Show nothing, where there is no terminal."""
