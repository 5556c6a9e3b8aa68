"""The recordings of a finished study as files of other programs: CSV, MAT, MCAP."""

import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from mcap.writer import Writer
from scipy.io import savemat
from scipy.io.matlab import MatWriteError

from ur5lib.commands.foxglove import Stream, drawn
from ur5lib.errors import InputError, expect_known, unknown
from ur5lib.finished import StudyFiles
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.pushes import SPEEDS
from ur5lib.study.turn import reserved
from ur5lib.tables import write_aside, write_csv

CSV_DIGITS = 12
PUSH_COLUMNS = [f"smallest_push_95_{axis}{of}" for axis in "xyz" for of in ("", "_std")]
EXPORTED_TABLES = ("signals", "motion", "currents", "forces", "sensor")
COLUMN_INDEX = re.compile(r"_[0-9]+$|_[Fnft][xyz]$|(?<=imu_[agm])[xyz]$")


@dataclass(frozen=True)
class RecordingTables:
    """A recording's tables by name.

    study: its study; start: time zero in seconds since 1970, None if unknown; tables: only those
    with rows, with the common index `time` [s], and the columns' units in `attrs["units"]`.
    """

    study: StudyFiles
    name: str
    start: float | None
    tables: dict[str, pd.DataFrame]


def channels(columns: list[str]) -> dict[str, list[str]]:
    """Return the columns of each channel: those of `actual_q` are actual_q_0 to actual_q_5."""
    groups = groupby(columns, key=lambda column: COLUMN_INDEX.sub("", column))
    return {name: [*group] for name, group in groups}


def with_smallest_push(study: StudyFiles, name: str, forces: pd.DataFrame) -> pd.DataFrame:
    """Return a recording's forces with the smallest push [N] along x, y and z that would be found,
    and its standard error, by the flange's speed at each sample.

    The standard error is NaN beyond the largest trial; both are NaN if not determined.
    """
    table, robot = study.table("pushes"), study.recording(name).arm.known_as
    linear = study.record(Kinematics, name).jacobian[:, :3]
    speed = np.linalg.norm(np.matvec(linear, study.record(Motion, name).qd), axis=1)
    ranges = dict(zip(SPEEDS.values(), pairwise([*SPEEDS, math.inf]), strict=True))
    pushes = {column: np.full(len(speed), np.nan) for column in PUSH_COLUMNS}
    for row in table[table["robot"] == robot].itertuples():
        low, high = ranges[row.motion]
        at_speed = (speed >= low) & (speed < high)
        pushes[f"smallest_push_95_{row.axis}"][at_speed] = row.value
        pushes[f"smallest_push_95_{row.axis}_std"][at_speed] = row.std_error
    found = forces.assign(**pushes)
    found.attrs["units"] = forces.attrs["units"] | dict.fromkeys(PUSH_COLUMNS, "N")
    return found


def write_csv_folder(contents: RecordingTables, folder: Path) -> None:
    """Write <table>.csv for each table, `time` [s] first, and units.csv: table, column, unit.

    A cell is empty where a value is unknown. Raises InputError where a file cannot be written.
    """
    for name, table in contents.tables.items():
        flags = dict.fromkeys(table.select_dtypes(bool), int)  # 0 and 1: every program reads them
        write_csv(table.astype(flags).reset_index(), folder / f"{name}.csv", CSV_DIGITS)
    units = [
        (name, column, unit)
        for name, table in contents.tables.items()
        for column, unit in table.attrs["units"].items()
    ]
    write_csv(pd.DataFrame(units, columns=["table", "column", "unit"]), folder / "units.csv")


def write_mat(contents: RecordingTables, path: Path) -> None:
    """Write a structure for each table: `time` (N, 1) [s], channels (N, k), and their `units`.

    `start_epoch_s` is time zero in seconds since 1970, NaN where unknown. Raises InputError where
    the file cannot be written or a table is too large for the format.
    """
    start = np.nan if contents.start is None else contents.start
    variables = {"recording": contents.name, "start_epoch_s": start}
    for name, table in contents.tables.items():
        variables[name] = _structure(table)

    def save(aside: Path) -> None:
        savemat(
            aside,
            variables,
            appendmat=False,
            long_field_names=True,
            do_compression=True,
            oned_as="column",
        )

    try:
        write_aside(path, save)
    except MatWriteError as error:
        raise InputError(
            f"{path}: {contents.name} is too long for a MAT file; export it with --format mcap"
        ) from error


def _structure(table: pd.DataFrame) -> dict[str, np.ndarray | dict[str, str]]:
    groups = channels([*table])
    units = table.attrs["units"]
    arrays = {name: table[columns].to_numpy() for name, columns in groups.items()}
    joined = {name: ", ".join({units[c]: None for c in group}) for name, group in groups.items()}
    return {"time": table.index.to_numpy(), **arrays, "units": {"time": "s", **joined}}


def write_mcap(contents: RecordingTables, path: Path) -> None:
    """Write a topic for each table, e.g. /forces, with a JSON message for each sample, and topics
    for Foxglove's 3D panel.

    A message of a table has a number for each column with a known value. The topic's JSON schema
    has the units. Time stamps count from 1970, or from the recording's start if its date is
    unknown. Raises InputError if the file cannot be written.
    """

    def write(aside: Path) -> None:
        with aside.open("wb") as stream:
            writer = Writer(stream)
            writer.start()
            _write_messages(writer, contents)
            writer.finish()

    write_aside(path, write)


def _write_messages(writer: Writer, contents: RecordingTables) -> None:
    """Write the samples of all topics in the order of their time stamps, as players expect."""
    table = next(iter(contents.tables.values()))
    stamps = [round(1e9 * (time + (contents.start or 0.0))) for time in table.index]
    streams = [_stream(name, table) for name, table in contents.tables.items()]
    streams += drawn(contents.study, contents.name, contents.tables, stamps)
    topics = [_add_topic(writer, stream) for stream in streams]
    # streams have one message for each sample, or are infinite
    rows = zip(stamps, *(stream.messages for stream in streams), strict=False)
    for number, (stamp, *messages) in enumerate(rows):
        for topic, message in zip(topics, messages, strict=True):
            if message is not None:
                writer.add_message(topic, stamp, message, stamp, number)


def _add_topic(writer: Writer, stream: Stream) -> int:
    schema = json.dumps(stream.schema).encode()
    number = writer.register_schema(stream.schema_name, "jsonschema", schema)
    return int(writer.register_channel(stream.topic, "json", number))


def _stream(name: str, table: pd.DataFrame) -> Stream:
    """Return a table as a topic; in its schema, each column's description is its unit."""
    kinds = {column: "boolean" if table[column].dtype == bool else "number" for column in table}
    units = table.attrs["units"]
    properties = {c: {"type": kind, "description": units[c]} for c, kind in kinds.items()}
    schema = {"type": "object", "properties": properties}
    return Stream(f"/{name}", f"ur5lib.{name}", schema, _messages(table))


def _messages(table: pd.DataFrame) -> Iterator[bytes]:
    for row in table.itertuples(index=False, name=None):
        values = zip(table, row, strict=True)
        yield json.dumps({name: x for name, x in values if math.isfinite(x)}).encode()


# By ending of a path: kind of its files, and the function that writes them.
WRITERS: dict[str, tuple[str, Callable[[RecordingTables, Path], None]]] = {
    "mat": (".mat", write_mat),
    "csv": ("", write_csv_folder),
    "mcap": (".mcap", write_mcap),
}


def write_recordings(
    results: Path, names: list[str], to: str, into: Path | None = None
) -> Iterator[Path]:
    """Write recordings of a study, and yield the path of each: <into>/<recording>.<to>.

    results: results/<study>; names: of its recordings, empty for all; to: a key of `WRITERS`; into:
    the folder, by default `exported` in the results. CSV files get a folder for each recording.
    Raises InputError for missing results and files that cannot be written, as while another process
    writes them.
    """
    if to not in WRITERS:
        raise unknown("format", to, WRITERS)
    study, (ending, write) = StudyFiles(results), WRITERS[to]
    folder = into or results / "exported"
    known = study.recordings
    named = [expect_known("recording", name, known) for name in names or known]
    paths = {name: folder / f"{name}{ending}" for name in named}
    with ExitStack() as own:
        for path in paths.values():
            own.enter_context(reserved(path))
        for name, path in paths.items():
            write(_tables_of(study, name), path)
            yield path


def _tables_of(study: StudyFiles, name: str) -> RecordingTables:
    frames = {table: study.frame(name, table) for table in EXPORTED_TABLES}
    if "if_untouched" in frames["forces"] and "pushes" in study.tables:
        frames["forces"] = with_smallest_push(study, name, frames["forces"])
    filled = {table: frame for table, frame in frames.items() if len({*frame} - {"segment"})}
    return RecordingTables(study, name, study.start(name), filled)
