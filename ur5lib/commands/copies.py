"""Copies of recordings' files, in their own layout, with estimates added to each row."""

import json
import math
import os
import shutil
import struct
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.reader import McapReader, make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter

from ur5lib.commands.added import Added, described
from ur5lib.errors import InputError
from ur5lib.recordings.added import GROUP, is_added
from ur5lib.recordings.array_files import LOADERS, Arrays
from ur5lib.recordings.delimited import TextTable
from ur5lib.recordings.entries import Files, expand
from ur5lib.recordings.rosbag import typestore
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.tables import write_aside

CSV_NOTHING = {b" ": b"nan"}  # where no cell may be empty
OTHERWISE_READ = (Found.COMPRESSED_FILE, Found.TURNED_TABLE)
PLAIN = {"f": "std_msgs/msg/Float64", "u": "std_msgs/msg/UInt8"}  # of numbers, by kind of dtype
WRENCH = "geometry_msgs/msg/WrenchStamped"
PLAIN_CDR = b"\x00\x01"  # begins a message that is not packed, its lowest bytes first
NO_HASH = "RIHS01_" + 64 * "0"  # of a kind that the bag does not define


class Rows(NamedTuple):
    """What is added to a file: values of each row, about them all, and when a bag received a row.

    topic: of the rows; received: times (N,) [s], as the reader of bags has them; stamped: whether
    the rows' time is that in the headers of their messages.
    """

    added: Sequence[Added]
    about: Mapping[str, str]
    topic: str = ""
    received: np.ndarray | None = None
    stamped: bool = False

    def columns(self) -> dict[str, np.ndarray]:
        """Return all columns by their names in a table."""
        return {f"{GROUP}_{n}": own for one in self.added for n, own in one.columns().items()}

    def at(self) -> dict[float, list[int]]:
        """Return the rows that were received at each time."""
        rows = defaultdict[float, list[int]](list)
        for row, time in enumerate([] if self.received is None else self.received.tolist()):
            rows[time].append(row)
        return rows


def _expect_original(recording: Files, names: Iterable[str]) -> None:
    """Raise InputError where a file has estimates already; names: of all that it has."""
    if any(map(is_added, names)):
        raise InputError(f"{recording.path} is a copy with estimates already; copy its original")


def write_hdf5(recording: Files, aside: Path, rows: Rows) -> None:
    """Add a group with an array for each value, with its unit, and what they are, as attributes."""
    shutil.copyfile(recording.path, aside)
    with h5py.File(aside, "r+") as file:
        _expect_original(recording, file)
        group = file.create_group(GROUP)
        group.attrs.update(rows.about)
        for one in rows.added:
            group[one.name] = one.values
            group[one.name].attrs.update({"unit": one.unit, "meaning": one.meaning})
            if one.values.ndim == 2:
                group[one.name].attrs["columns"] = [*map(str, one.columns())]


def write_npz(recording: Files, aside: Path, rows: Rows) -> None:
    """Add arrays `ur5lib/<name>`, and `ur5lib/about`, a text in JSON."""
    shutil.copyfile(recording.path, aside)
    told = json.dumps({**rows.about, "columns": described(rows.added)})
    arrays = {one.name: one.values for one in rows.added} | {"about": np.array(told)}
    with ZipFile(aside, "a", ZIP_DEFLATED) as archive:
        _expect_original(recording, archive.namelist())
        for name, values in arrays.items():
            with archive.open(f"{GROUP}/{name}.npy", "w") as file:
                np.lib.format.write_array(file, values, allow_pickle=False)


def write_parquet(recording: Files, aside: Path, rows: Rows) -> None:
    """Add columns, of lists where the table has lists; unit and meaning are their metadata."""
    with pq.ParquetFile(recording.path) as file:
        _expect_original(recording, file.schema_arrow.names)
        before, listed = file.schema_arrow, any(map(_is_list, file.schema_arrow.types))
        arrays = _listed(rows) if listed else _single(rows)
        fields = [pa.field(name, one.type, metadata=own) for name, (one, own) in arrays.items()]
        about = {f"{GROUP}.{name}": text for name, text in rows.about.items()}
        schema = pa.schema([*before, *fields], {**(before.metadata or {}), **_as_bytes(about)})
        start = 0
        with pq.ParquetWriter(aside, schema, compression=_compression(file)) as writer:
            for number in range(file.num_row_groups):
                part = file.read_row_group(number)
                more = [one.slice(start, len(part)) for one, _ in arrays.values()]
                whole = pa.Table.from_arrays([*part.columns, *more], schema=schema)
                writer.write_table(whole, row_group_size=max(1, len(part)))
                start += len(part)


def _is_list(kind: pa.DataType) -> bool:
    return bool(pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind))


def _compression(file: pq.ParquetFile) -> str:
    """Return the compression of a file's first column."""
    known = file.metadata.num_row_groups and file.metadata.num_columns
    name = file.metadata.row_group(0).column(0).compression if known else "SNAPPY"
    return {"UNCOMPRESSED": "NONE"}.get(name, name)


def _single(rows: Rows) -> dict[str, tuple[pa.Array, dict[bytes, bytes]]]:
    told = described(rows.added)
    named = rows.columns().items()
    return {n: (pa.array(own), _as_bytes(told[n.removeprefix(f"{GROUP}_")])) for n, own in named}


def _listed(rows: Rows) -> dict[str, tuple[pa.Array, dict[bytes, bytes]]]:
    return {
        f"{GROUP}_{one.name}": (
            pa.array(one.values) if one.values.ndim == 1 else pa.array([*one.values]),
            _as_bytes({"unit": one.unit, "meaning": one.meaning}),
        )
        for one in rows.added
    }


def _as_bytes(texts: Mapping[str, str]) -> dict[bytes, bytes]:
    return {name.encode(): text.encode() for name, text in texts.items()}


def write_csv(recording: Files, aside: Path, rows: Rows) -> None:
    """Add cells behind each line of a table of numbers; all bytes before them stay."""
    findings = list[Finding]()
    text, named = TextTable(Log(recording.path, "robot", findings)), rows.columns()
    if changed := [one.detail for one in findings if one.code in OTHERWISE_READ]:
        raise InputError(f"{recording.path}: {changed[0]}; no copy is made of such a table")
    _expect_original(recording, text.cells)
    stated = getattr(recording, "columns", None)
    above, mark = text.above(None if stated is None else expand(stated)), text.delimiter
    lines = recording.path.read_bytes().split(b"\n")
    body = lines[above:]
    point = b"," if mark in b";\t" and any(b"," in one for one in body[:1000]) else b"."
    cells = [_cells(own, mark, point) for own in named.values()]
    numbers = iter(zip(*cells, strict=True))
    nothing = tuple(CSV_NOTHING.get(mark, b"") for _ in named)
    body = [_longer(one, next(numbers, nothing), mark) if one.strip() else one for one in body]
    if text.has_names() and above:
        lines[above - 1] = _longer(lines[above - 1], [*map(str.encode, named)], mark)
    aside.write_bytes(b"\n".join(lines[:above] + body))


def _longer(line: bytes, cells: Sequence[bytes], mark: bytes) -> bytes:
    """Return a line with cells behind it, before a carriage return."""
    bare = line.removesuffix(b"\r")
    between = b"" if bare.endswith(mark) and mark != b" " else mark
    return bare + between + mark.join(cells) + line[len(bare) :]


def _cells(values: np.ndarray, mark: bytes, point: bytes) -> list[bytes]:
    """Return numbers as text with all their digits; mark: between cells; point: decimal one."""
    nothing = CSV_NOTHING.get(mark, b"")
    texts = (nothing if math.isnan(x) else repr(x).encode() for x in values.tolist())
    return [one.replace(b".", point) for one in texts] if point != b"." else [*texts]


def write_mcap(recording: Files, aside: Path, rows: Rows) -> None:
    """Write all messages anew, each of the rows' topic followed by the estimates for it."""
    at, of_ours = rows.at(), dict[str, int]()
    with recording.path.open("rb") as read, aside.open("wb") as written:
        reader, writer = make_reader(read), Writer(written)
        writer.start(reader.get_header().profile, f"{GROUP} {rows.about['version']}")
        topics = _same_channels(reader, writer)
        _expect_original(recording, _topics_of(reader))
        for _, channel, one in reader.iter_messages(log_time_order=False):
            writer.add_message(
                topics[channel.id], one.log_time, one.data, one.publish_time, one.sequence
            )
            make = _json_of if channel.message_encoding == "json" else _cdr_of
            here = at.get(1e-9 * one.log_time, ()) if channel.topic == rows.topic else ()
            for row, (topic, kind, data) in (
                (k, m) for k in here for m in make(rows, k, one.data, one.log_time)
            ):
                if topic not in of_ours:
                    of_ours[topic] = _register(writer, topic, kind, rows)
                writer.add_message(of_ours[topic], one.log_time, data, one.publish_time, row)
        for kept in reader.iter_attachments():
            file = kept.name, kept.media_type, kept.data
            writer.add_attachment(kept.create_time, kept.log_time, *file)
        for told in reader.iter_metadata():
            writer.add_metadata(told.name, told.metadata)
        writer.add_metadata(GROUP, dict(rows.about))
        writer.finish()


def _topics_of(reader: McapReader) -> list[str]:
    summary = reader.get_summary()
    return [one.topic for one in summary.channels.values()] if summary else []


def _same_channels(reader: McapReader, writer: Writer) -> dict[int, int]:
    """Register all channels of a file in its copy, and return their new numbers."""
    summary = reader.get_summary()
    schemas, channels = (summary.schemas, summary.channels) if summary else ({}, {})
    kinds = {k: writer.register_schema(s.name, s.encoding, s.data) for k, s in schemas.items()}
    return {
        number: writer.register_channel(
            one.topic, one.message_encoding, kinds.get(one.schema_id, 0), one.metadata
        )
        for number, one in channels.items()
    }


def _register(writer: Writer, topic: str, kind: str, rows: Rows) -> int:
    """Return the new channel of a topic; kind: of ROS, or empty of JSON."""
    name = topic.rpartition("/")[2]
    told = {one.name: {"unit": one.unit, "meaning": one.meaning} for one in rows.added}
    about = {**rows.about, **told.get(name, {})}
    if kind:
        text = typestore().generate_msgdef(kind, ros_version=2)[0].encode()
        schema = writer.register_schema(kind, "ros2msg", text)
        return int(writer.register_channel(topic, "cdr", schema, about))
    columns = described(rows.added).items()
    fields = {n: {"type": "number", "description": own["unit"]} for n, own in columns}
    whole = json.dumps({"type": "object", "properties": fields}).encode()
    schema = writer.register_schema(f"{GROUP}.estimates", "jsonschema", whole)
    return int(writer.register_channel(topic, "json", schema, about))


def _json_of(rows: Rows, row: int, *_: object) -> Iterator[tuple[str, str, bytes]]:
    """Yield the one message of a row in JSON: its numbers that are known."""
    values = {n: own[row].item() for one in rows.added for n, own in one.columns().items()}
    known = {name: value for name, value in values.items() if math.isfinite(value)}
    yield f"/{GROUP}/estimates", "", json.dumps(known).encode()


def _cdr_of(
    rows: Rows, row: int, message: bytes, received: int
) -> Iterator[tuple[str, str, bytes]]:
    """Yield topic, kind and message of each value of a row.

    message: of the row, whose stamp they have, or else the time of its receipt [ns].
    """
    types = typestore().types
    vector, head = types["geometry_msgs/msg/Vector3"], types["std_msgs/msg/Header"]
    in_header = rows.stamped and message.startswith(PLAIN_CDR)
    parts = struct.unpack_from("<iI", message, 4) if in_header else divmod(received, 10**9)
    stamp = types["builtin_interfaces/msg/Time"](*parts)
    for one in rows.added:
        value = one.values[row].tolist()
        kind = WRENCH if one.values.ndim == 2 else PLAIN[one.values.dtype.kind]
        if kind == WRENCH:
            force, moment = vector(*value[:3]), vector(*value[3:])
            body = types["geometry_msgs/msg/Wrench"](force, moment)
            own = types[kind](head(stamp, "base"), body)
        else:
            own = types[kind](value)
        yield f"/{GROUP}/{one.name}", kind, bytes(typestore().serialize_cdr(own, kind))


def write_bag(recording: Files, aside: Path, rows: Rows) -> None:
    """Write a bag of ROS 2 anew, a folder or its one file, with topics of standard messages."""
    source, at = recording.path, rows.at()
    folder = aside if source.is_dir() else aside.with_name(f"{aside.name}.folder")
    mcap = any(source.glob("*.mcap*")) if source.is_dir() else False
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    try:
        with ExitStack() as open_files:
            bag = open_files.enter_context(AnyReader([source], default_typestore=typestore()))
            writer = open_files.enter_context(BagWriter(folder, version=9, storage_plugin=plugin))
            _expect_original(recording, (one.topic for one in bag.connections))
            for name, text in rows.about.items():
                writer.set_custom_data(f"{GROUP}.{name}", text)
            topics = {one.id: _connection(writer, one) for one in bag.connections}
            of_ours = dict[str, Any]()
            for connection, received, data in bag.messages():
                writer.write(topics[connection.id], received, data)
                for row in at.get(received * 1e-9, ()) if connection.topic == rows.topic else ():
                    for topic, kind, own in _cdr_of(rows, row, bytes(data), received):
                        if topic not in of_ours:
                            made = writer.add_connection(topic, kind, typestore=typestore())
                            of_ours[topic] = made
                        writer.write(of_ours[topic], received, own)
        if not source.is_dir():
            next(folder.glob(f"*{source.suffix}")).rename(aside)
    finally:
        if folder != aside:
            shutil.rmtree(folder, ignore_errors=True)


def _connection(writer: BagWriter, one: Any) -> Any:
    """Return a topic of a bag in its copy, with the definition that the bag has."""
    ext = one.ext
    defined: dict[str, Any] = {"msgdef": one.msgdef.data, "rihs01": one.digest or NO_HASH}
    if not one.msgdef.data and one.msgtype in typestore().fielddefs:
        defined = {"typestore": typestore()}
    return writer.add_connection(
        one.topic,
        one.msgtype,
        **defined,
        serialization_format=ext.serialization_format,
        offered_qos_profiles=ext.offered_qos_profiles,
    )


Write = Callable[[Files, Path, Rows], None]
WRITERS: dict[str, Write] = {  # by the end of a file's name, "" of a folder with a bag
    **dict.fromkeys((".h5", ".hdf5"), write_hdf5),
    ".npz": write_npz,
    ".parquet": write_parquet,
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), write_csv),
    ".mcap": write_mcap,
    **dict.fromkeys((".db3", ""), write_bag),
}


def ending_of(path: Path) -> str:
    """Return the end of a file's name, in small letters, "" of a folder."""
    return "" if path.is_dir() else path.suffix.lower()


def write_copy(
    recording: Files, target: Path, added: Sequence[Added], about: Mapping[str, str]
) -> None:
    """Write the copy of a recording's file, under a temporary name until it is whole.

    added: values of each row of the file. Raises InputError where it cannot be written.
    """
    source = recording.path
    rows = Rows(added, about)
    if recording.format == "rosbag":
        rows = rows._replace(**_received(recording))
    write = WRITERS[ending_of(source)]
    if source.is_dir():
        _write_folder(target, lambda aside: write(recording, aside, rows))
    else:
        write_aside(target, lambda aside: write(recording, aside, rows))


def _write_folder(target: Path, write: Callable[[Path], None]) -> None:
    aside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write(aside)
        os.rename(aside, target)
    except OSError as error:
        raise InputError(f"{target} cannot be written ({error.strerror})") from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _received(recording: Any) -> dict[str, Any]:
    """Return topic and times of a bag's rows; of topics with one output each, as of positions."""
    group, _, name = str(recording.channels["time"]).rpartition("/")
    received = f"{group}/bag_stamp"
    arrays: Arrays = LOADERS["rosbag"](recording.path, {f"{group}/{name}", received}, [])
    of_outputs = f"{group}/actual_q" == recording.channels["actual_q"]
    topic = f"{group}/actual_q" if of_outputs else group
    return {"topic": topic, "received": arrays[received], "stamped": name == "stamp"}
