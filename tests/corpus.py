"""A corpus of damaged recordings, made from real and made-up ones by a seeded script.

Damage that nothing in the recording tells from good data is left out:

- a digit, sign or decimal point that flipped in one cell, within what an arm may do;
- a file cut right behind the newline of a row, where no other file tells that it went on;
- units or columns of joints that rest, and channels of one level that change places;
- a force sensor in kN, which reads as a small force, or in mN within what a sensor may read;
- stale data of a force sensor: at rest it says the same twice, and may;
- a gyroscope in degrees, and the columns of gyroscope and magnetometer exchanged;
- digits lost from the stamp of the IMU's start, whose line never ends.

Each kind of damage strikes one recording, and each format what its reader tells otherwise; the
other pairs are drawn by Hypothesis (tests/damage.py).
"""

import gzip
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tests.synthetic import write_channel, write_recording
from ur5lib.recordings.thesis_csv import ROBOT_CHANNELS
from ur5lib.records.codes import Found

TABLE = ["time", "actual_q", "actual_qd", "actual_current", "target_current", "target_moment"]
FORCE = ["time", "ft_fx", "ft_fy", "ft_fz", "ft_tx", "ft_ty", "ft_tz"]
LEVELS = np.array([1.0, 4.0, 2.5, 0.9, 0.6, 0.4])  # A, of the joints' currents

STEERING = "[/x][red]:x:\x1b[31m\a"  # what rich would read as markup, and a terminal obey

Rows = list[list[bytes]]
Outcome = Literal["same", "repaired", "told", "refused"]


@dataclass(frozen=True)
class Expected:
    """What a damaged recording must give.

    same: the right data; repaired: the right data as far as they are left, and the finding named;
    told: doubtful data, and the finding named; refused: an error with these words.
    lost: how many of the first rows are gone, where the first row begins the clock.
    """

    outcome: Outcome
    words: str = ""
    lost: int = 0


@dataclass(frozen=True)
class Text:
    """A device file in parts."""

    head: list[bytes]
    rows: Rows
    mark: bytes
    names: list[str]
    random: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def written(self) -> bytes:
        """The file."""
        return b"".join(line + b"\n" for line in [*self.head, *map(self.mark.join, self.rows)])

    def with_rows(self, rows: Rows) -> bytes:
        """The file with other rows."""
        return replace(self, rows=rows).written()

    def with_line(self, index: int, line: bytes) -> bytes:
        """The file with a line before a row."""
        lines = [self.mark.join(row) for row in self.rows]
        return b"".join(part + b"\n" for part in [*self.head, *lines[:index], line, *lines[index:]])

    def change(self, names: str, change: Callable[[float], float]) -> bytes:
        """The file with all channels changed whose names begin so."""
        these = [index for index, name in enumerate(self.names) if name.startswith(names)]
        if not these:
            return self.written()
        rows = [list(row) for row in self.rows]
        for row in rows:
            for index in these:
                row[index] = b"%.9f" % change(float(row[index]))
        return self.with_rows(rows)

    def put(self, cells: dict[tuple[int, str], bytes]) -> bytes:
        """The file with single cells replaced, of the channels that it has."""
        rows = [list(row) for row in self.rows]
        for (row, name), cell in cells.items():
            if name in self.names:
                rows[row][self.names.index(name)] = cell
        return self.with_rows(rows)


Damage = Callable[[Text], bytes]


@dataclass(frozen=True)
class Base:
    """An undamaged recording. files: the device files, and the columns of each."""

    name: str
    recording: dict[str, Any]
    files: dict[str, list[str]]
    mark: bytes
    head: int = 0
    sensor: str | None = None

    def text(self, file: str, seed: int) -> Text:
        """One of its files in parts."""
        lines = (Path(self.recording["folder"]) / file).read_bytes().splitlines()
        rows = [line.split(self.mark) for line in lines[self.head :]]
        head = lines[: self.head]
        return Text(head, rows, self.mark, self.files[file], np.random.default_rng(seed))


# Undamaged recordings


def motion(time: np.ndarray, seed: int) -> dict[str, np.ndarray]:
    """Channels (N, 6) of a made-up arm whose joints all move, with currents of several levels."""
    random = np.random.default_rng(seed)
    pace, phase = random.uniform(2, 4, 6), random.uniform(0, 2 * np.pi, 6)
    angle = np.outer(time, pace) + phase
    current = LEVELS * (0.8 + 0.3 * np.sin(angle))
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    noise = 2e-5 * np.random.default_rng(seed + 1).normal(size=angle.shape)
    return {
        "actual_q": home + 0.3 * np.sin(angle) + noise,
        "actual_qd": 0.3 * pace * np.cos(angle),
        "target_q": home + 0.3 * np.sin(angle),
        "target_qd": 0.3 * pace * np.cos(angle),
        "actual_current": current + 0.005 * random.normal(size=angle.shape),
        "target_current": current,
        "target_moment": 10.5 * current,
    }


def rtde(folder: Path, name: str, mark: bytes) -> Base:
    """An RTDE recording at 500 Hz, with a force sensor beside it."""
    path = folder / name
    path.mkdir(parents=True)
    time = np.arange(700) * 0.002
    channels = motion(time, 1)
    names = ["timestamp", *(f"{channel}_{joint}" for channel in channels for joint in range(6))]
    table = np.column_stack([time + 5000.0, *channels.values()])
    separator = mark.decode()
    np.savetxt(
        path / "robot.csv",
        table,
        fmt=["%.3f"] + ["%.6f"] * 42,
        delimiter=separator,
        header=separator.join(names),
        comments="",
    )
    write_force(path / "force.csv", 1.4)
    entry: dict[str, Any] = {"format": "rtde-csv", "folder": str(path), "file": "robot.csv"}
    entry |= {"force_sensor": {"file": "force.csv", "columns": ["time", "ft"]}}
    return Base(name, entry, {"robot.csv": names, "force.csv": FORCE}, mark, 1, "force.csv")


def write_force(path: Path, seconds: float) -> None:
    """A force sensor that is pushed."""
    random = np.random.default_rng(2)
    time = np.arange(0, seconds, 0.005)
    push = np.outer(20 * np.sin(3 * time), [1, 0.5, -1, 0.05, 0.02, 0.1])
    np.savetxt(
        path,
        np.column_stack([time, push + 0.01 * random.normal(size=push.shape)]),
        delimiter=",",
        fmt="%.6f",
    )


def table(folder: Path) -> Base:
    """A log as of the UR10e: 31 columns without a header, steps of 10 and 12 ms."""
    path = folder / "table"
    path.mkdir(parents=True)
    time = 3000 + np.cumsum(np.random.default_rng(3).choice([0.010, 0.012], 300, p=[0.7, 0.3]))
    channels = motion(time - time[0], 4)
    columns = [channels[name] for name in TABLE[1:]]
    np.savetxt(path / "robot.csv", np.column_stack([time, *columns]), fmt="%.4f", delimiter=",")
    names = ["time", *(f"{channel}_{joint}" for channel in TABLE[1:] for joint in range(6))]
    entry = {"format": "table-csv", "folder": str(path), "file": "robot.csv", "columns": TABLE}
    return Base("table", entry, {"robot.csv": names}, b",")


def thesis_base(name: str, folder: Path, sensor: str | None) -> Base:
    """A recording in the thesis's format."""
    files = {
        f"csv_files/{file}": ["time", *(f"{channel}_{joint}" for joint in range(6))]
        for file, channel in ROBOT_CHANNELS.items()
    }
    if sensor:
        files[sensor] = FORCE
    return Base(name, {"format": "thesis-csv", "folder": str(folder)}, files, b", ", 0, sensor)


def made_up(folder: Path) -> Base:
    """The made-up recording of the other tests."""
    csv = write_recording(folder / "made-up", seconds=3, seed=5, force_sensor=True, imu=True)
    imu = np.loadtxt(csv / "acc_data.csv", delimiter=",")
    imu[:, 1:] = 0.1 * imu[:, 1:] + [0, 0, 9.8, 0.5, 0.2, 0.1, 0.3, 0.2, 0.1]
    write_channel(csv / "acc_data.csv", imu[:, 0], imu[:, 1:], "%d")
    return thesis_base("made-up", folder / "made-up", "csv_files/log_force_sensor.csv")


def excerpt(folder: Path, source: Path, first: int, sensor: bool) -> Base:
    """300 frames of a real recording of the thesis, and what its devices say of their starts."""
    target = folder / source.name / "csv_files"
    target.mkdir(parents=True)
    for file in (*ROBOT_CHANNELS, "log_force_sensor.csv"):
        rows = (source / "csv_files" / file).read_bytes().splitlines(keepends=True)
        of_sensor = file == "log_force_sensor.csv"
        (target / file).write_bytes(
            b"".join(rows[: 1700 + first] if of_sensor else rows[first : first + 300])
        )
    for file in ("start_time.csv", "log_force_sensor_start_time.csv"):
        (target / file).write_bytes((source / "csv_files" / file).read_bytes()[:200])
    return thesis_base(
        source.name, target.parent, "csv_files/log_force_sensor.csv" if sensor else None
    )


def bases(folder: Path, thesis: Path) -> list[Base]:
    """All undamaged recordings."""
    return [
        rtde(folder, "rtde", b","),
        rtde(folder, "rtde-blank", b" "),
        table(folder),
        made_up(folder),
        excerpt(folder, thesis / "Movement_No8_Singularity_Free_1", 600, sensor=False),
        excerpt(folder, thesis / "Movement_No9_Singularity_Free_ForceSensor", 900, sensor=True),
    ]


# Kinds of damage


def cut(row: int, cell: int, byte: int) -> Damage:
    """The file ends in a row: after some bytes of a cell, counted from its end where negative."""

    def damage(text: Text) -> bytes:
        cells = text.rows[row]
        cell_at = cell % len(cells)
        kept = b"".join(part + text.mark for part in cells[:cell_at])
        size = byte % (len(cells[cell_at]) + 1)
        last = kept + cells[cell_at][:size]
        return text.with_rows(text.rows[: row % len(text.rows)]) + last

    return damage


def cut_after_mark(row: int, back: int) -> Damage:
    """The file ends right after a separator, or within it."""

    def damage(text: Text) -> bytes:
        line = b"".join(cell + text.mark for cell in text.rows[row][:3])
        return text.with_rows(text.rows[: row % len(text.rows)]) + line[: len(line) - back]

    return damage


def exchange(one: str, other: str) -> Damage:
    """Two columns change places, in files that have both."""

    def damage(text: Text) -> bytes:
        if not {one, other} <= {*text.names}:
            return text.written()
        order = list(range(len(text.names)))
        j, k = text.names.index(one), text.names.index(other)
        order[j], order[k] = k, j
        return text.with_rows([[row[index] for index in order] for row in text.rows])

    return damage


def scale(names: str, factor: float) -> Damage:
    """A unit that is not SI."""
    return lambda text: text.change(names, lambda value: value * factor)


def stamp(row: int, value: Callable[[float], float] | bytes) -> Damage:
    """One row's time is another."""

    def damage(text: Text) -> bytes:
        rows = [list(cells) for cells in text.rows]
        rows[row][0] = value if isinstance(value, bytes) else b"%.6f" % value(float(rows[row][0]))
        return text.with_rows(rows)

    return damage


def select(choose: Callable[[Rows, np.random.Generator], Rows]) -> Damage:
    """Rows are lost, repeated, or in another order."""
    return lambda text: text.with_rows(choose(text.rows, text.random))


def spliced(index: int, change: Callable[[list[bytes]], list[bytes]]) -> Damage:
    """One row is another."""
    return select(lambda rows, _: [*rows[:index], change(rows[index]), *rows[index + 1 :]])


def garbage(text: Text) -> bytes:
    """Rows of a misaligned frame after the first, as in a real log of a UR10e."""
    rows = []
    for _ in range(8):
        row = [b"0.0000"] * len(text.names)
        for place in text.random.integers(1, len(row), 6):
            row[place] = b"%.4f" % (text.random.normal() * 10.0 ** text.random.integers(0, 250))
        row[0], row[1] = b"%.4f" % text.random.uniform(-1, 50), b"%.4f" % 1e154
        rows.append(row)
    return text.with_rows([text.rows[0], *rows, *text.rows[9:]])


def restart(text: Text) -> bytes:
    """The clock starts again in the middle."""
    half = len(text.rows) // 2
    start, now = float(text.rows[0][0]), float(text.rows[half][0])
    later = [[b"%.6f" % (float(row[0]) - now + start), *row[1:]] for row in text.rows[half:]]
    return text.with_rows([*text.rows[:half], *later])


def stale(cells: slice) -> Damage:
    """Every twentieth row holds some cells of the one before."""

    def damage(text: Text) -> bytes:
        rows = [list(row) for row in text.rows]
        for index in range(20, len(rows), 20):
            rows[index][cells] = rows[index - 1][cells]
        return text.with_rows(rows)

    return damage


def zeros(start: int, size: int) -> Damage:
    """A block of the file reads as zeros; negative: counted from the end."""

    def damage(text: Text) -> bytes:
        raw = text.written()
        place = start % len(raw)
        return raw[:place] + b"\0" * size + raw[place + size :]

    return damage


def holes(cell: bytes, rows: range | list[int], *names: str) -> Damage:
    """Cells replaced in some rows."""
    return lambda text: text.put({(row, name): cell for row in rows for name in names})


def all_but_time(cell: bytes, row: int) -> Damage:
    """All channels of a row replaced."""
    return spliced(row, lambda cells: [cells[0], *[cell] * (len(cells) - 1)])


def decimal_commas(mark: bytes) -> Damage:
    """A locale that writes 1,5."""
    return lambda text: replace(
        text,
        head=[line.replace(text.mark, mark) for line in text.head],
        rows=[[cell.replace(b".", b",") for cell in row] for row in text.rows],
        mark=mark,
    ).written()


def raw(change: Callable[[bytes], bytes]) -> Damage:
    """The file's bytes changed."""
    return lambda text: change(text.written())


def random_bytes(text: Text) -> bytes:
    """No text at all."""
    return text.random.bytes(5000)


def every_second_pair_lost(rows: Rows, _: np.random.Generator) -> Rows:
    """After 27 rows, two are lost after every second one: steps of 8 and 24 ms in turn."""
    return rows[:27] + [row for index, row in enumerate(rows[27:]) if index % 4 < 2]


def headed(change: Callable[[bytes], bytes]) -> Damage:
    """The line of names changed."""
    return lambda text: replace(text, head=[change(text.head[0])]).written()


def name_line(text: Text, mark: bytes | None = None, before: bytes = b"") -> bytes:
    """The names of all columns."""
    return before + (mark or text.mark).join(map(str.encode, text.names))


def repaired(finding: str, lost: int = 0) -> Expected:
    return Expected("repaired", finding, lost)


def refused(words: str) -> Expected:
    return Expected("refused", words)


# What each kind of damage gives in the robot's file of an RTDE recording, and in a sensor's; None:
# there it is another's, or no damage.

SAME = Expected("same")
TORN, BROKEN = repaired(Found.TORN_LAST_LINE), repaired(Found.DAMAGED_LINES)
ABSENT, UNUSABLE = repaired(Found.NO_SENSOR), repaired(Found.UNUSABLE_SENSOR)
IMPOSSIBLE, STRAY = repaired(Found.IMPOSSIBLE_FRAMES), repaired(Found.IMPOSSIBLE_SAMPLES)
MISSING, INCOMPLETE = repaired(Found.MISSING_CELLS), repaired(Found.INCOMPLETE_FRAMES)
NO_ROW = refused("line 1: (no complete row|expected|no column `timestamp`)")
NO_TEXT = refused("not a text file; save it as plain CSV")
OTHER_ROWS = refused(r"line [12]: expected \d+ numbers .*\d+ cells")
OTHER_STEP = refused("step between timestamps is .* s; check that the time")
IN_OTHER_UNITS = refused(r"_\d exceeds .* in .* of the rows .*; .*correct the file")
CONTRADICTED = Expected("told", Found.INCONSISTENT_CHANNELS)
DEGREES = 180 / np.pi

Given = tuple[Expected | None, Expected | None, dict[str, Damage]]
CHANNELS = ("position", "velocit", "current", "torque", "target")
KINDS: list[Given] = [
    (TORN, TORN, {
        "cut inside a number": cut(-1, 2, 3),
        "cut inside the last number": cut(-1, -1, -2),
        "cut inside the last number, one byte left": cut(-1, -1, 1),
        "cut in the middle of the file": cut(200, 3, 2),
        "cut after a separator": cut_after_mark(-1, 0),
        "cut inside a separator": cut_after_mark(-1, 1),
        "zeros at the end": raw(lambda data: data + b"\0" * 512),
    }),
    (NO_ROW, ABSENT, {
        "cut after the first byte": raw(lambda data: data[:1]),
        "cut inside the first row": cut(0, 3, 2),
        "cut after the head": lambda text: text.with_rows([]),
        "empty": raw(lambda _: b""),
        "blanks only": raw(lambda _: b" \n\n \n"),
        "no time at all": lambda text: text.change(text.names[0], lambda _: float("nan")),
    }),
    (refused("contains only 1 complete frames; record"), ABSENT, {
        "cut after the first row": select(lambda rows, _: rows[:1]),
    }),
    (SAME, SAME, {
        "cut before the newline": raw(lambda data: data[:-1]),
        "CRLF": raw(lambda data: data.replace(b"\n", b"\r\n")),
        "CRLF, cut between both": raw(lambda data: data.replace(b"\n", b"\r\n")[:-1]),
        "CR": raw(lambda data: data.replace(b"\n", b"\r")),
        "quotes": lambda text: text.with_rows([[b'"%s"' % c for c in row] for row in text.rows]),
        "a stray quote": spliced(150, lambda row: [row[0], b'"' + row[1], *row[2:]]),
        "a separator behind each row": raw(lambda data: data.replace(b"\n", b",\n")),
        "a comment on top": raw(lambda data: b"# made by a recorder\n" + data),
        "blank lines": lambda text: text.with_line(120, b"\n  \n"),
        "blank lines on top": raw(lambda data: b"\n\n" + data),
    }),
    (repaired(Found.BYTE_ORDER_MARK), repaired(Found.BYTE_ORDER_MARK), {
        "byte-order mark": raw(lambda data: b"\xef\xbb\xbf" + data),
    }),
    (repaired(Found.DECIMAL_COMMAS), repaired(Found.DECIMAL_COMMAS), {
        "decimal commas, semicolons": decimal_commas(b";"),
    }),
    (repaired(Found.COMPRESSED_FILE), repaired(Found.COMPRESSED_FILE), {
        "gzip": raw(gzip.compress),
    }),
    (refused("is a damaged gzip file; copy it again"), UNUSABLE, {
        "gzip, truncated": raw(lambda data: gzip.compress(data)[:-200]),
        "gzip, garbled": raw(lambda data: gzip.compress(data)[:300] + b"\xff" * 200),
    }),
    (NO_TEXT, UNUSABLE, {
        "UTF-16": raw(lambda data: data.decode().encode("utf-16")),
        "UTF-16 without mark": raw(lambda data: data.decode().encode("utf-16-le")),
        "binary": random_bytes,
        "zeros only": raw(lambda data: b"\0" * len(data)),
    }),
    (OTHER_ROWS, UNUSABLE, {
        "decimal commas, commas": decimal_commas(b", "),
        "a cell lost in all rows": select(lambda rows, _: [row[:-1] for row in rows]),
        "a cell too many in all rows": select(lambda rows, _: [[*row, b"0.5"] for row in rows]),
    }),
    (refused(r"line [23]: expected \d+ numbers .* of \d+ lines do not fit"), UNUSABLE, {
        "a cell too many in most rows": select(
            lambda rows, _: [[*row, b"0.5"] if k % 5 else row for k, row in enumerate(rows)]
        ),
    }),
    (BROKEN, BROKEN, {
        "zeros inside a row": zeros(9000, 3),
        "zeros over rows": zeros(8000, 4096),
        "letters that are none": spliced(99, lambda row: [row[0], b"\xe4\xff\xf6", *row[2:]]),
        "text": lambda text: text.with_line(120, b"connection lost, reconnecting"),
        "text in place of a row": spliced(120, lambda _: [b"connection lost"]),
        "comments": lambda text: text.with_line(77, b"# paused"),
        "names in the middle": lambda text: text.with_line(200, name_line(text)),
        "a newline lost": raw(lambda data: data[:5000] + data[5000:].replace(b"\n", b"", 1)),
        "a cell lost": spliced(60, lambda row: row[:3] + row[4:]),
        "a cell too many": spliced(60, lambda row: [*row[:3], b"0.5", *row[3:]]),
        "steering text": spliced(60, lambda row: [*row[:3], STEERING.encode(), *row[4:]]),
        "1_000": spliced(60, lambda row: [*row[:-1], b"1_000"]),
    }),
    # A sensor's clock counts from the first row: when that is lost, it is told and a sample late.
    (repaired(Found.DAMAGED_LINES, lost=1), Expected("told", Found.DAMAGED_LINES), {
        "words in the first row": spliced(0, lambda row: [b"lost", *[b"x"] * (len(row) - 2), b"?"]),
    }),
    (repaired(Found.IMPOSSIBLE_FRAMES, lost=1), Expected("told", Found.IMPOSSIBLE_SAMPLES), {
        "a first time of 1e300": stamp(0, b"1e300"),
    }),
    (IMPOSSIBLE, STRAY, {
        "a time of 1e300": stamp(100, b"1e300"),
        "a time of -1e300": stamp(100, b"-1e300"),
        "a time 5 s late": stamp(100, lambda time: time + 5),
        "a time 5 s early": stamp(100, lambda time: time - 5),
        "a time a day away": stamp(100, lambda time: time + 86400),
        "a last time a day away": stamp(-1, lambda time: time + 86400),
        "misaligned rows": garbage,
        "an infinite row": all_but_time(b"inf", 130),
        "a huge row": all_but_time(b"1e300", 130),
    }),
    (repaired(Found.MISSING_TIMES), repaired(Found.MISSING_TIMES), {
        "a time that is no number": stamp(100, b"nan"),
        "an infinite time": stamp(100, b"inf"),
        "an empty time": stamp(100, b""),
    }),
    (refused("timestamps is 0 s; check that the time column is in seconds"), UNUSABLE, {
        "all times equal": lambda text: text.change(text.names[0], lambda _: 1.0),
    }),
    (OTHER_STEP, UNUSABLE, {
        "milliseconds": lambda text: text.change(text.names[0], lambda time: 1e3 * time),
        "microseconds": lambda text: text.change(text.names[0], lambda time: 1e6 * time),
        "thousandths": lambda text: text.change(text.names[0], lambda time: 1e-3 * time),
    }),
    (SAME, repaired(Found.STALE_COPY), {
        "negative times": lambda text: text.change(text.names[0], lambda time: time - 1e4),
    }),
    (Expected("told", Found.CLOCK_RESET), repaired(Found.CLOCK_RESET), {"clock reset": restart}),
    (repaired(Found.FRAMES_OUT_OF_ORDER), repaired(Found.SAMPLES_OUT_OF_ORDER), {
        "rows shuffled": select(lambda rows, draw: [rows[k] for k in draw.permutation(len(rows))]),
        "rows reversed": select(lambda rows, _: rows[::-1]),
        "two rows exchanged": select(lambda r, _: [*r[:90], r[91], r[90], *r[92:]]),
        "a row late": select(lambda r, _: [*r[:90], *r[91:130], r[90], *r[130:]]),
    }),
    (repaired(Found.REPEATED_FRAMES), repaired(Found.REPEATED_FRAMES), {
        "a row repeated": select(lambda rows, _: [*rows[:90], rows[89], *rows[90:]]),
        "a block repeated": select(lambda rows, _: [*rows[:150], *rows[80:150], *rows[150:]]),
        "all rows twice": select(lambda rows, _: [row for row in rows for _ in range(2)]),
    }),
    (repaired(Found.STALE_STAMPS), Expected("told", Found.STALE_STAMPS), {
        "stale stamps": stale(slice(1)),
    }),
    (repaired(Found.STALE_DATA), None, {"stale data": stale(slice(1, None))}),
    (repaired(Found.LOST_FRAMES), repaired(Found.LOST_SAMPLES), {
        "rows lost, few": select(lambda rows, _: rows[:100] + rows[104:]),
        "rows lost in turn": select(every_second_pair_lost),
    }),
    (repaired(Found.SPLIT), repaired(Found.LOST_SAMPLES), {
        "rows lost, many": select(lambda rows, _: rows[:100] + rows[180:]),
    }),
    (MISSING, MISSING, {
        "a row without numbers": all_but_time(b"nan", 130),
        "an empty row": all_but_time(b"", 130),
        "a cell without a number": lambda text: holes(b"nan", [40, 41], text.names[3])(text),
        "empty cells": lambda text: holes(b"", [40, 50, 60], text.names[3])(text),
    }),
    (INCOMPLETE, MISSING, {
        "no numbers in the first 20 rows": lambda t: holes(b"nan", range(20), t.names[1])(t),
        "no numbers in the last 20 rows": lambda t: holes(b"nan", range(-20, 0), t.names[1])(t),
        "no numbers in 90 rows": lambda t: holes(b"nan", range(100, 190), t.names[2])(t),
    }),
    (refused(r"has no actual_q_\d; record"), ABSENT, {
        "an empty column": lambda t: holes(b"", range(len(t.rows)), t.names[4])(t),
    }),
    # The line of names
    (NO_ROW, None, {"cut inside the head": raw(lambda data: data[:30])}),
    (refused("line 1: no header; .*name the columns"), None, {
        "no head": lambda text: replace(text, head=[]).written(),
    }),
    (refused("line 1: column 'actual_q_0' appears twice; give"), None, {
        "a name twice": headed(lambda head: head.replace(b"actual_q_1", b"actual_q_0")),
    }),
    (refused("has no actual_q_3; record"), None, {
        "a misspelt position": headed(lambda head: head.replace(b"actual_q_3", b"actual_q_E")),
    }),
    (repaired(Found.INCOMPLETE_CHANNELS), None, {
        "a misspelt current": headed(lambda h: h.replace(b"current_3", b"cu\xffrent_3", 1)),
    }),
    (refused("line 1: no column `timestamp` .*; record"), None, {
        "a misspelt time": headed(lambda head: head.replace(b"timestamp", b"timestanp")),
    }),
    (repaired(Found.UNKNOWN_CHANNELS), None, {
        "a steering name": lambda text: replace(
            text,
            head=[text.head[0] + text.mark + STEERING.encode()],
            rows=[[*row, b"1"] for row in text.rows],
        ).written(),
    }),
    (BROKEN, None, {"the head twice": lambda text: replace(text, head=text.head * 2).written()}),
    (SAME, None, {
        "a head in quotes": lambda text: replace(
            text, head=[text.mark.join(b'"%s"' % name.encode() for name in text.names)]
        ).written(),
    }),
    (None, SAME, {
        "a head": lambda text: replace(text, head=[name_line(text)]).written(),
        "a head as a comment": lambda t: replace(t, head=[name_line(t, before=b"# ")]).written(),
    }),
    # Channels
    (IN_OTHER_UNITS, None, {
        "positions in mrad": scale("actual_q_", 1000),
        "positions in degrees": scale("actual_q_", DEGREES),
        "velocities in mrad/s": scale("actual_qd_", 1000),
        "velocities in degrees/s": scale("actual_qd_", DEGREES),
        "currents in mA": scale("actual_current_", 1000),
        "torques in mNm": scale("target_moment_", 1000),
        "target positions in degrees": scale("target_q_", DEGREES),
        "target accelerations in mrad/s²": scale("target_qdd_", 1000),
        "target currents in mA": scale("target_current_", 1000),
    }),
    (CONTRADICTED, None, {
        "positions in krad": scale("actual_q_", 1e-3),
        "velocities in krad/s": scale("actual_qd_", 1e-3),
        "currents in kA": scale("actual_current_", 1e-3),
        "torques in kNm": scale("target_moment_", 1e-3),
        "target velocities in krad/s": scale("target_qd_", 1e-3),
        "positions 1 and 2 exchanged": exchange("actual_q_0", "actual_q_1"),
        "positions 2 and 3 exchanged": exchange("actual_q_1", "actual_q_2"),
        "velocities 1 and 3 exchanged": exchange("actual_qd_0", "actual_qd_2"),
        "currents 2 and 5 exchanged": exchange("actual_current_1", "actual_current_4"),
        "target positions 1 and 2 exchanged": exchange("target_q_0", "target_q_1"),
    }),
    (refused("exceeds .*; .*correct the file"), None, {
        "time and position exchanged": lambda t: exchange(t.names[0], "actual_q_0")(t),
        "time last": select(lambda rows, _: [row[1:] + row[:1] for row in rows]),
    }),
    (IMPOSSIBLE, None, {
        "a huge position": holes(b"1e300", [70], "actual_q_2"),
        "an infinite velocity": holes(b"inf", [70], "actual_qd_2"),
    }),
    (MISSING, None, {"an empty current": holes(b"", range(30, 33), "actual_current_2")}),
    # Forces
    (None, ABSENT, {
        "zeros of no sensor": lambda text: text.change("ft_", lambda _: -1e-6),
        "no values recorded": raw(lambda _: b"no values recorded\n"),
    }),
    (None, UNUSABLE, {"forces in mN": scale("ft_", 1000)}),
    (None, STRAY, {"a huge force": holes(b"1e300", [50], "ft_fy")}),
    (None, MISSING, {"a force that is no number": holes(b"nan", [50, 51], "ft_fy")}),
]  # fmt: skip
DAMAGES = {kind: damage for _, _, group in KINDS for kind, damage in group.items()}
OF_ROBOT = {kind: given for given, _, group in KINDS if given for kind in group}
OF_SENSOR = {kind: given for _, given, group in KINDS if given for kind in group}
OF_CHANNELS = [k for k in OF_ROBOT if any(c in k for c in CHANNELS) and "misspelt" not in k]

# Files of the thesis are joined by their stamps, so that the order of their rows does not matter.
UNORDERED = ["rows shuffled", "rows reversed", "two rows exchanged", "a row late"]
OFF = [kind for _, given, group in KINDS if given is STRAY for kind in group if " time " in kind]
OF_THESIS: dict[str, Expected] = {
    **dict.fromkeys([*OFF, "a first time of 1e300"], repaired(Found.IMPOSSIBLE_TIMES)),
    **dict.fromkeys(UNORDERED, SAME),
    **dict.fromkeys(["a row repeated", "all rows twice"], repaired(Found.REPEATED_STAMPS)),
    "stale stamps": repaired(Found.REPEATED_STAMPS),
    "words in the first row": BROKEN,
    "rows lost, few": MISSING,
    "time and position exchanged": OTHER_STEP,
    "time last": OTHER_STEP,
}
ALSO_OF_THESIS = ["rows lost, many", "rows lost in turn", "misaligned rows", "text", "gzip"]
ALSO_OF_THESIS += ["cut inside a number", "empty", "UTF-16", "an empty column", "empty cells"]
ALSO_OF_THESIS += ["clock reset", "a block repeated", "stale data"]  # joined by their stamps
IN_ALL_FILES = [kind for kind in OF_ROBOT if "time" in kind or "seconds" in kind]
IN_ALL_FILES += ["thousandths", "clock reset", "a block repeated", "stale data"]
IN_ALL_FILES += ["rows lost, many", "rows lost in turn", "misaligned rows"]
ONE_FILE = ["words in the first row", "rows lost, few"]
OF_TABLE = ["cut inside the first row", "words in the first row", "a first time of 1e300"]
OF_TABLE += ["clock reset", "rows shuffled", "stale stamps", "stale data", "rows lost, few"]
OF_TABLE += ["rows lost, many", "rows lost in turn", "positions in degrees", "time last"]
OF_BLANK = ["cut after a separator", "cut inside the last number", "quotes", "a cell lost"]
OF_BLANK += ["a cell too many", "an empty row", "empty cells", "no head", "the head twice"]
STAMPS: dict[str, bytes] = {
    "a stamp that is no number": b"nan\n",
    "a stamp that is text": b"unknown\n",
    "an empty stamp": b"",
    "a stamp of another day": b"1386600000.5\n",
    "a torn stamp": b"13866",
    "a torn stamp, near": b"1386687253.",
    "a binary stamp": b"\xff\x00\xfe",
}
STAMP_FILE = "csv_files/log_force_sensor_start_time.csv"
IMU_FILE = "csv_files/acc_data.csv"
IMU = ["time", *(f"imu_{quantity}{axis}" for quantity in "amg" for axis in "xyz")]
INERTIAL: dict[str, tuple[Damage, Expected]] = {
    "accelerations in mm/s²": (scale("imu_a", 1000), UNUSABLE),
    "rates in mrad/s": (scale("imu_g", 1000), UNUSABLE),
    "time in seconds": (scale("time", 1e-3), UNUSABLE),
    "accelerations in g": (scale("imu_a", 1 / 9.8), Expected("told", Found.NO_GRAVITY)),
    "a huge rate": (holes(b"1e300", [50], "imu_gx"), STRAY),
    "a time ten minutes late": (stamp(30, lambda t: t + 6e5), STRAY),
    "text": (spliced(40, lambda _: [b"text"]), BROKEN),
    "binary": (random_bytes, UNUSABLE),
    "empty": (raw(lambda _: b""), ABSENT),
}
MISSING_FILES = {"a file missing": False, "a folder for a file": True}  # a folder in its place

# Cases


@dataclass(frozen=True)
class Case:
    """A kind of damage to a part of a recording."""

    base: Base
    part: Literal["robot", "sensor", "imu", "stamp"]
    kind: str

    @property
    def label(self) -> str:
        return f"{self.base.name}, {self.part}: {self.kind}"

    @property
    def expected(self) -> Expected:
        """What the damage must give."""
        if self.part == "imu":
            return INERTIAL[self.kind][1]
        if self.part == "stamp":
            return repaired(Found.STALE_COPY if "another" in self.kind else Found.NO_START_STAMP)
        if self.kind in MISSING_FILES:
            if self.part == "robot":
                return refused("is missing or cannot be read .*; add the file")
            return UNUSABLE if MISSING_FILES[self.kind] else ABSENT
        if self.part == "sensor":
            return OF_SENSOR[self.kind]
        known = OF_ROBOT
        if self.base.recording["format"] == "thesis-csv":
            known = OF_ROBOT | OF_THESIS
        return known[self.kind]

    @property
    def files(self) -> list[str]:
        """The files that are struck: of recordings with several, those whose channels are meant."""
        if self.part == "imu":
            return [IMU_FILE]
        if self.part == "sensor" and self.base.sensor:
            return [self.base.sensor]
        robot = [file for file in self.base.files if file != self.base.sensor]
        everywhere = self.kind in {*OF_CHANNELS, *OF_THESIS, *IN_ALL_FILES} - {*ONE_FILE}
        return robot if everywhere else robot[:1]

    def written(self, folder: Path) -> dict[str, Any]:
        """Write the recording into a folder, undamaged files as links, and return its entry."""
        source = Path(self.base.recording["folder"])
        for file in filter(Path.is_file, source.rglob("*")):
            copy = folder / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.symlink_to(file)
        for name in [STAMP_FILE] if self.part == "stamp" else self.files:
            (folder / name).unlink()
            if self.kind in STAMPS:
                (folder / name).write_bytes(STAMPS[self.kind])
            elif self.kind not in MISSING_FILES:
                (folder / name).write_bytes(self.damaged(name))
            elif MISSING_FILES[self.kind]:
                (folder / name).mkdir()
        return {**self.base.recording, "folder": str(folder)}

    def damaged(self, file: str) -> bytes:
        base, damage = self.base, DAMAGES.get(self.kind)
        if self.part == "imu":
            base, damage = replace(base, files={IMU_FILE: IMU}), INERTIAL[self.kind][0]
        elif self.part == "sensor" and base.head:  # beside an RTDE recording, a plain table
            base = replace(base, mark=b",", head=0)
        assert damage is not None
        return damage(base.text(file, zlib.crc32(self.kind.encode())))


def usual_cases(base: Base) -> Iterator[Case]:
    """Each kind once, and of each format what its reader tells otherwise."""
    of_sensor = [kind for kind in OF_SENSOR if kind not in OF_ROBOT]
    of_rtde = [kind for kind in OF_ROBOT if "acceleration" not in kind]  # it has none
    robot, sensor = {
        "rtde": ([*of_rtde, *MISSING_FILES], [*OF_SENSOR, *MISSING_FILES]),
        "rtde-blank": (OF_BLANK, []),
        "table": (OF_TABLE, []),
        "made-up": ([*OF_THESIS, *ALSO_OF_THESIS, *MISSING_FILES], [*of_sensor, *MISSING_FILES]),
    }.get(base.name, ([], of_sensor) if base.sensor else (OF_CHANNELS, []))
    yield from (Case(base, "robot", kind) for kind in robot)
    yield from (Case(base, "sensor", kind) for kind in sensor)
    if base.name == "made-up":
        yield from (Case(base, "imu", kind) for kind in INERTIAL)
    elif base.sensor and base.name.startswith("Movement"):
        yield from (Case(base, "stamp", kind) for kind in STAMPS)


def other_cases(base: Base) -> Iterator[Case]:
    """The rest of the pairs: of a table and of the thesis's format."""
    if base.name not in ("table", "made-up"):
        return
    usual = {case.label for case in usual_cases(base)}
    usual.add(Case(base, "robot", "negative times").label)  # a thesis clock starts anywhere
    absent = ("target p", "target v", "target a") if base.name == "table" else ()
    for kind in OF_ROBOT:
        of_head = any(word in kind for word in ("head", "name", "misspelt"))
        if not of_head and not kind.startswith(absent):
            case = Case(base, "robot", kind)
            if case.label not in usual:
                yield case
