"""A corpus of damaged recordings, made from real and made-up ones by a seeded script.

Damage that nothing in the recording tells from good data is left out:

- a digit, sign or decimal point that flipped in one cell, within what an arm may do;
- a file cut right behind the newline of a row, where no other file tells that it went on;
- units or columns of joints that rest, and channels of one level that change places;
- a force sensor in kN, which reads as a small force, or in mN within what a sensor may read;
- stale data of a force sensor: at rest it says the same twice, and may;
- a gyroscope in degrees, and the columns of gyroscope and magnetometer exchanged;
- digits lost from the stamp of the IMU's start, whose line never ends.
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

    def column(self, name: str) -> int:
        """Where a channel stands."""
        return self.names.index(name)

    def change(self, names: str, change: Callable[[float], float]) -> bytes:
        """The file with all channels changed whose names begin so."""
        these = [index for index, name in enumerate(self.names) if name.startswith(names)]
        rows = [list(row) for row in self.rows]
        for row in rows:
            for index in these:
                row[index] = b"%.9f" % change(float(row[index]))
        return self.with_rows(rows)

    def put(self, cells: dict[tuple[int, str], bytes]) -> bytes:
        """The file with single cells replaced."""
        rows = [list(row) for row in self.rows]
        for (row, name), cell in cells.items():
            rows[row][self.column(name)] = cell
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


@dataclass(frozen=True)
class Case:
    """A damaged recording, the undamaged one, and what is expected."""

    label: str
    kind: str
    base: Base
    recording: dict[str, Any]
    expected: Expected
    on_sensor: bool = False


# Undamaged recordings


def motion(time: np.ndarray, seed: int) -> dict[str, np.ndarray]:
    """Channels (N, 6) of a made-up arm whose joints all move, with currents of several levels."""
    random = np.random.default_rng(seed)
    pace, phase = random.uniform(2, 4, 6), random.uniform(0, 2 * np.pi, 6)
    angle = np.outer(time, pace) + phase
    current = LEVELS * (0.8 + 0.3 * np.sin(angle))
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    return {
        "actual_q": home + 0.3 * np.sin(angle),
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
    entry: dict[str, Any] = {
        "name": name,
        "robot": "ur5",
        "folder": str(path),
        "role": "fit",
        "format": "rtde-csv",
        "file": "robot.csv",
        "force_sensor": {
            "file": "force.csv",
            "columns": ["time", "ft"],
            "units": {},
            "time": "relative_s",
            "start_file": None,
            "start": "epoch_s",
        },
        "imu": None,
    }
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
    entry: dict[str, Any] = {
        "name": "table",
        "robot": "ur5",
        "folder": str(path),
        "role": "fit",
        "format": "table-csv",
        "file": "robot.csv",
        "columns": TABLE,
        "units": {},
        "time": "relative_s",
        "force_sensor": None,
        "imu": None,
    }
    return Base("table", entry, {"robot.csv": names}, b",")


def thesis_base(name: str, folder: Path, sensor: str | None) -> Base:
    """A recording in the thesis's format."""
    files = {
        f"csv_files/{file}": ["time", *(f"{channel}_{joint}" for joint in range(6))]
        for file, channel in ROBOT_CHANNELS.items()
    }
    if sensor:
        files[sensor] = FORCE
    entry: dict[str, Any] = {
        "name": name,
        "robot": "ur5",
        "folder": str(folder),
        "role": "validate",
        "format": "thesis-csv",
    }
    return Base(name, entry, files, b", ", 0, sensor)


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
    """Two columns change places."""

    def damage(text: Text) -> bytes:
        order = list(range(len(text.names)))
        j, k = text.column(one), text.column(other)
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


def stale_data(text: Text) -> bytes:
    """Every twentieth row holds the data of the one before."""
    rows = [list(row) for row in text.rows]
    for index in range(20, len(rows), 20):
        rows[index][1:] = rows[index - 1][1:]
    return text.with_rows(rows)


def stale_stamps(text: Text) -> bytes:
    """Every twentieth row carries the stamp of the one before."""
    rows = [list(row) for row in text.rows]
    for index in range(20, len(rows), 20):
        rows[index][0] = rows[index - 1][0]
    return text.with_rows(rows)


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


TRUNCATED: dict[str, Damage] = {
    "cut inside a number": cut(-1, 2, 3),
    "cut inside the last number": cut(-1, -1, -2),
    "cut inside the last number, one byte left": cut(-1, -1, 1),
    "cut in the middle of the file": cut(200, 3, 2),
    "cut after a separator": cut_after_mark(-1, 0),
    "cut inside a separator": cut_after_mark(-1, 1),
    "cut before the newline": raw(lambda data: data[:-1]),
    "cut after the first byte": raw(lambda data: data[:1]),
    "cut inside the first row": cut(0, 3, 2),
    "cut after the first row": select(lambda rows, _: rows[:1]),
    "cut after the head": lambda text: text.with_rows([]),
    "empty": raw(lambda _: b""),
    "blanks only": raw(lambda _: b" \n\n \n"),
}
ENCODED: dict[str, Damage] = {
    "CRLF": raw(lambda data: data.replace(b"\n", b"\r\n")),
    "CRLF, cut between both": raw(lambda data: data.replace(b"\n", b"\r\n")[:-1]),
    "CR": raw(lambda data: data.replace(b"\n", b"\r")),
    "byte-order mark": raw(lambda data: b"\xef\xbb\xbf" + data),
    "UTF-16": raw(lambda data: data.decode().encode("utf-16")),
    "UTF-16 without mark": raw(lambda data: data.decode().encode("utf-16-le")),
    "decimal commas, semicolons": decimal_commas(b";"),
    "decimal commas, commas": decimal_commas(b", "),
    "quotes": lambda text: text.with_rows([[b'"%s"' % cell for cell in row] for row in text.rows]),
    "a stray quote": spliced(150, lambda row: [row[0], b'"' + row[1], *row[2:]]),
    "gzip": raw(gzip.compress),
    "gzip, truncated": raw(lambda data: gzip.compress(data)[:-200]),
    "gzip, garbled": raw(lambda data: gzip.compress(data)[:300] + b"\xff" * 200),
    "binary": random_bytes,
    "zeros inside a row": zeros(9000, 3),
    "zeros over rows": zeros(8000, 4096),
    "zeros at the end": raw(lambda data: data + b"\0" * 512),
    "zeros only": raw(lambda data: b"\0" * len(data)),
    "letters that are none": spliced(99, lambda row: [row[0], b"\xe4\xff\xf6", *row[2:]]),
}
TIMES: dict[str, Damage] = {
    "a time of 1e300": stamp(100, b"1e300"),
    "a first time of 1e300": stamp(0, b"1e300"),
    "a time of -1e300": stamp(100, b"-1e300"),
    "a time that is no number": stamp(100, b"nan"),
    "an infinite time": stamp(100, b"inf"),
    "an empty time": stamp(100, b""),
    "no time at all": lambda text: text.change(text.names[0], lambda _: float("nan")),
    "a time 5 s late": stamp(100, lambda time: time + 5),
    "a time 5 s early": stamp(100, lambda time: time - 5),
    "a time a day away": stamp(100, lambda time: time + 86400),
    "a last time a day away": stamp(-1, lambda time: time + 86400),
    "all times equal": lambda text: text.change(text.names[0], lambda _: 1.0),
    "milliseconds": lambda text: text.change(text.names[0], lambda time: 1e3 * time),
    "microseconds": lambda text: text.change(text.names[0], lambda time: 1e6 * time),
    "thousandths": lambda text: text.change(text.names[0], lambda time: 1e-3 * time),
    "negative times": lambda text: text.change(text.names[0], lambda time: time - 1e4),
    "clock reset": restart,
    "rows shuffled": select(lambda rows, random: [rows[k] for k in random.permutation(len(rows))]),
    "rows reversed": select(lambda rows, _: rows[::-1]),
    "two rows exchanged": select(lambda r, _: [*r[:90], r[91], r[90], *r[92:]]),
    "a row late": select(lambda r, _: [*r[:90], *r[91:130], r[90], *r[130:]]),
    "a row repeated": select(lambda rows, _: [*rows[:90], rows[89], *rows[90:]]),
    "a block repeated": select(lambda rows, _: [*rows[:150], *rows[80:150], *rows[150:]]),
    "all rows twice": select(lambda rows, _: [row for row in rows for _ in range(2)]),
    "stale stamps": stale_stamps,
    "stale data": stale_data,
}
LINES: dict[str, Damage] = {
    "text": lambda text: text.with_line(120, b"connection lost, reconnecting"),
    "text in place of a row": lambda text: replace(
        text, rows=[*text.rows[:120], *text.rows[121:]]
    ).with_line(120, b"connection lost"),
    "words in the first row": spliced(0, lambda row: [b"lost", *[b"x"] * (len(row) - 2), b"?"]),
    "comments": lambda text: text.with_line(77, b"# paused"),
    "a comment on top": raw(lambda data: b"# made by a recorder\n" + data),
    "blank lines": lambda text: text.with_line(120, b"\n  \n"),
    "blank lines on top": raw(lambda data: b"\n\n" + data),
    "names in the middle": lambda text: text.with_line(
        200, text.mark.join(map(str.encode, text.names))
    ),
    "a newline lost": raw(lambda data: data[:5000] + data[5000:].replace(b"\n", b"", 1)),
    "a cell lost": spliced(60, lambda row: row[:3] + row[4:]),
    "a cell too many": spliced(60, lambda row: [*row[:3], b"0.5", *row[3:]]),
    "a cell lost in all rows": select(lambda rows, _: [row[:-1] for row in rows]),
    "a cell too many in all rows": select(lambda rows, _: [[*row, b"0.5"] for row in rows]),
    "a cell too many in most rows": select(
        lambda rows, _: [[*row, b"0.5"] if k % 5 else row for k, row in enumerate(rows)]
    ),
    "a separator behind each row": raw(lambda data: data.replace(b"\n", b",\n")),
    "steering text": spliced(60, lambda row: [*row[:3], STEERING.encode(), *row[4:]]),
    "1_000": spliced(60, lambda row: [*row[:-1], b"1_000"]),
    "rows lost, few": select(lambda rows, _: rows[:100] + rows[104:]),
    "rows lost, many": select(lambda rows, _: rows[:100] + rows[180:]),
    "rows lost in turn": select(every_second_pair_lost),
    "misaligned rows": garbage,
    "a row without numbers": all_but_time(b"nan", 130),
    "an empty row": all_but_time(b"", 130),
    "an infinite row": all_but_time(b"inf", 130),
    "a huge row": all_but_time(b"1e300", 130),
    "no numbers in the first 20 rows": lambda text: holes(b"nan", range(20), text.names[1])(text),
    "no numbers in the last 20 rows": lambda text: holes(b"nan", range(-20, 0), text.names[1])(
        text
    ),
    "no numbers in 90 rows": lambda text: holes(b"nan", range(100, 190), text.names[2])(text),
    "a cell without a number": lambda text: holes(b"nan", [40, 41], text.names[3])(text),
    "empty cells": lambda text: holes(b"", [40, 50, 60], text.names[3])(text),
    "an empty column": lambda text: holes(b"", range(len(text.rows)), text.names[4])(text),
}
HEAD: dict[str, Damage] = {
    "cut inside the head": raw(lambda data: data[:30]),
    "no head": lambda text: replace(text, head=[]).written(),
    "a name twice": lambda text: replace(
        text, head=[text.head[0].replace(b"actual_q_1", b"actual_q_0")]
    ).written(),
    "a misspelt position": lambda text: replace(
        text, head=[text.head[0].replace(b"actual_q_3", b"actual_q_E")]
    ).written(),
    "a misspelt current": lambda text: replace(
        text, head=[text.head[0].replace(b"actual_current_3", b"actual_cu\xffrent_3")]
    ).written(),
    "a misspelt time": lambda text: replace(
        text, head=[text.head[0].replace(b"timestamp", b"timestanp")]
    ).written(),
    "a steering name": lambda text: replace(
        text,
        head=[text.head[0] + text.mark + STEERING.encode()],
        rows=[[*row, b"1"] for row in text.rows],
    ).written(),
    "the head twice": lambda text: replace(text, head=text.head * 2).written(),
    "a head in quotes": lambda text: replace(
        text, head=[text.mark.join(b'"%s"' % name.encode() for name in text.names)]
    ).written(),
}
NO_HEAD: dict[str, Damage] = {
    "a head": lambda text: replace(
        text, head=[text.mark.join(map(str.encode, text.names))]
    ).written(),
    "a head as a comment": lambda text: replace(
        text, head=[b"# " + text.mark.join(map(str.encode, text.names))]
    ).written(),
}
DEGREES = 180 / np.pi
CHANNELS: dict[str, tuple[str, Damage]] = {
    "positions in mrad": ("actual_q", scale("actual_q_", 1000)),
    "positions in krad": ("actual_q", scale("actual_q_", 1e-3)),
    "positions in degrees": ("actual_q", scale("actual_q_", DEGREES)),
    "velocities in mrad/s": ("actual_qd", scale("actual_qd_", 1000)),
    "velocities in krad/s": ("actual_qd", scale("actual_qd_", 1e-3)),
    "velocities in degrees/s": ("actual_qd", scale("actual_qd_", DEGREES)),
    "currents in mA": ("actual_current", scale("actual_current_", 1000)),
    "currents in kA": ("actual_current", scale("actual_current_", 1e-3)),
    "torques in mNm": ("target_moment", scale("target_moment_", 1000)),
    "torques in kNm": ("target_moment", scale("target_moment_", 1e-3)),
    "positions 1 and 2 exchanged": ("actual_q", exchange("actual_q_0", "actual_q_1")),
    "positions 2 and 3 exchanged": ("actual_q", exchange("actual_q_1", "actual_q_2")),
    "velocities 1 and 3 exchanged": ("actual_qd", exchange("actual_qd_0", "actual_qd_2")),
    "currents 2 and 5 exchanged": (
        "actual_current",
        exchange("actual_current_1", "actual_current_4"),
    ),
    "time and position exchanged": (
        "actual_q",
        lambda text: exchange(text.names[0], "actual_q_0")(text),
    ),
    "time last": ("actual_q", select(lambda rows, _: [row[1:] + row[:1] for row in rows])),
    "target positions in degrees": ("target_q", scale("target_q_", DEGREES)),
    "target velocities in krad/s": ("target_qd", scale("target_qd_", 1e-3)),
    "target accelerations in mrad/s²": ("target_qdd", scale("target_qdd_", 1000)),
    "target currents in mA": ("target_current", scale("target_current_", 1000)),
    "target positions 1 and 2 exchanged": ("target_q", exchange("target_q_0", "target_q_1")),
    "a huge position": ("actual_q", holes(b"1e300", [70], "actual_q_2")),
    "an infinite velocity": ("actual_qd", holes(b"inf", [70], "actual_qd_2")),
    "an empty current": ("actual_current", holes(b"", range(30, 33), "actual_current_2")),
}

# Cases


def damaged(base: Base, folder: Path, damages: dict[str, Damage], seed: int) -> dict[str, Any]:
    """Write a recording with some of its files damaged, the others as they are."""
    for file in Path(base.recording["folder"]).rglob("*"):
        if file.is_file():
            name = str(file.relative_to(base.recording["folder"]))
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            if name in damages:
                (folder / name).write_bytes(damages[name](base.text(name, seed)))
            else:
                (folder / name).symlink_to(file)
    return {**base.recording, "folder": str(folder)}


def without(base: Base, folder: Path, file: str, as_folder: bool) -> dict[str, Any]:
    """Write a recording with a file missing, or a folder in its place."""
    recording = damaged(base, folder, {}, 0)
    (folder / file).unlink()
    if as_folder:
        (folder / file).mkdir()
    return recording


def files_for(base: Base, kind: str) -> tuple[list[str], Damage]:
    """Which files of a robot a kind of damage strikes: where each channel has a file, times all."""
    if kind in CHANNELS:
        channel, damage = CHANNELS[kind]
        return [f for f, names in base.files.items() if f"{channel}_0" in names], damage
    damage = (TRUNCATED | ENCODED | LINES | HEAD | NO_HEAD | TIMES)[kind]
    robot = [file for file in base.files if file != base.sensor]
    return robot if kind in TIMES or kind in EVERYWHERE else robot[:1], damage


ELSEWHERE = {"negative times"}  # a thesis clock that starts elsewhere is no damage
BLANK = ["cut after a separator", "cut inside the last number", "quotes", "a cell lost"]
BLANK += ["a cell too many", "an empty row", "empty cells", "no head", "the head twice"]
EVERYWHERE = {"rows lost, many", "rows lost in turn", "misaligned rows"}


def kinds(base: Base) -> list[str]:
    """Kinds of damage to the robot's files of a recording."""
    if base.name.startswith("Movement_No9"):
        return []  # its sensor is of interest
    if base.name == "rtde-blank":
        return BLANK
    if base.name.startswith("Movement"):
        return [*CHANNELS]  # as large and as fast as real ones
    heads = HEAD if base.head else NO_HEAD
    skipped = ELSEWHERE if base.recording["format"] == "thesis-csv" else set()
    every = [*TRUNCATED, *ENCODED, *TIMES, *LINES, *heads, *CHANNELS]
    return [kind for kind in every if kind not in skipped]


def robot_cases(base: Base, folder: Path) -> Iterator[Case]:
    """A recording with its robot's files damaged."""
    for kind in kinds(base):
        files, damage = files_for(base, kind)
        if not files:
            continue
        place = folder / base.name / kind.replace("/", " per ")
        recording = damaged(base, place, dict.fromkeys(files, damage), zlib.crc32(kind.encode()))
        yield Case(f"{base.name}: {kind}", kind, base, recording, expected(base, kind))


def sensor_cases(base: Base, folder: Path) -> Iterator[Case]:
    """A recording with its force sensor's file damaged; one reader serves those of all formats."""
    if base.sensor is None or base.name == "rtde-blank":
        return
    mark, head = (b",", 0) if base.name == "rtde" else (base.mark, 0)
    of_sensor = replace(base, mark=mark, head=head)
    made = {"rtde": TRUNCATED | ENCODED | TIMES | LINES | NO_HEAD, "made-up": TIMES | LINES}
    for kind, damage in (made.get(base.name, {}) | FORCES).items():
        if kind == "stale data":
            continue  # a force sensor at rest says the same twice, and may
        place = folder / base.name / f"sensor {kind}"
        recording = damaged(of_sensor, place, {base.sensor: damage}, zlib.crc32(kind.encode()))
        label = f"{base.name}, sensor: {kind}"
        yield Case(label, kind, base, recording, expected(base, kind, "sensor"), True)


FORCES: dict[str, Damage] = {
    "zeros of no sensor": lambda text: text.change("ft_", lambda _: -1e-6),
    "no values recorded": raw(lambda _: b"no values recorded\n"),
    "forces in mN": scale("ft_", 1000),
    "a huge force": holes(b"1e300", [50], "ft_fy"),
    "a force that is no number": holes(b"nan", [50, 51], "ft_fy"),
}
STAMPS: dict[str, bytes] = {
    "a stamp that is no number": b"nan\n",
    "a stamp that is text": b"unknown\n",
    "an empty stamp": b"",
    "a stamp of another day": b"1386600000.5\n",
    "a torn stamp": b"13866",
    "a torn stamp, near": b"1386687253.",
    "a binary stamp": b"\xff\x00\xfe",
}


IMU_FILE = "csv_files/acc_data.csv"
IMU = ["time", *(f"imu_{quantity}{axis}" for quantity in "amg" for axis in "xyz")]
INERTIAL: dict[str, tuple[Damage, Expected]] = {
    "accelerations in mm/s²": (scale("imu_a", 1000), Expected("repaired", "unusable sensor")),
    "rates in mrad/s": (scale("imu_g", 1000), Expected("repaired", "unusable sensor")),
    "time in seconds": (scale("time", 1e-3), Expected("repaired", "unusable sensor")),
    "accelerations in g": (scale("imu_a", 1 / 9.8), Expected("told", "no gravity")),
    "a huge rate": (holes(b"1e300", [50], "imu_gx"), Expected("repaired", "impossible samples")),
    "a time ten minutes late": (
        stamp(30, lambda t: t + 6e5),
        Expected("repaired", "impossible samples"),
    ),
    "text": (spliced(40, lambda _: [b"text"]), Expected("repaired", "damaged lines")),
    "binary": (random_bytes, Expected("repaired", "unusable sensor")),
    "empty": (raw(lambda _: b""), Expected("repaired", "no sensor")),
}


def imu_cases(base: Base, folder: Path) -> Iterator[Case]:
    """A recording with its IMU's file damaged."""
    if base.name != "made-up":
        return
    with_imu = replace(base, files={IMU_FILE: IMU}, sensor=IMU_FILE)
    for index, (kind, (damage, outcome)) in enumerate(INERTIAL.items()):
        recording = damaged(with_imu, folder / base.name / f"imu {index}", {IMU_FILE: damage}, 0)
        yield Case(f"made-up, IMU: {kind}", kind, with_imu, recording, outcome, True)


def file_cases(base: Base, folder: Path) -> Iterator[Case]:
    """A recording with files missing, folders in their place, or damaged stamps."""
    for file in base.files:
        if file in (next(iter(base.files)), base.sensor):
            for as_folder in (False, True):
                kind = "a folder for a file" if as_folder else "a file missing"
                recording = without(
                    base, folder / base.name / f"{kind} {Path(file).name}", file, as_folder
                )
                part = "sensor" if file == base.sensor else "robot"
                label = f"{base.name}, {part}: {kind}"
                yield Case(
                    label, kind, base, recording, expected(base, kind, part), part == "sensor"
                )
    stamp = "csv_files/log_force_sensor_start_time.csv"
    for kind, content in STAMPS.items():
        if base.name.startswith("Movement_No9"):
            recording = damaged(base, folder / base.name / kind, {}, 0)
            (Path(recording["folder"]) / stamp).unlink()
            (Path(recording["folder"]) / stamp).write_bytes(content)
            yield Case(
                f"{base.name}: {kind}", kind, base, recording, expected(base, kind, "sensor"), True
            )


def corpus(folder: Path, thesis: Path) -> list[Case]:
    """Every damaged recording, written below a folder. thesis: the real recordings."""
    return [
        case
        for base in bases(folder / "whole", thesis)
        for make in (robot_cases, sensor_cases, imu_cases, file_cases)
        for case in make(base, folder / "damaged")
    ]


# What is expected

ROWS_OUT = ["a time of 1e300", "a time of -1e300", "a time 5 s late", "a time 5 s early"]
ROWS_OUT += ["a time a day away", "a last time a day away"]
NOT_TEXT = ["UTF-16", "UTF-16 without mark", "binary", "zeros only"]
EMPTY = ["cut after the first byte", "cut inside the first row", "cut after the head", "empty"]
EMPTY += ["blanks only"]
OTHER_ROWS = ["decimal commas, commas", "a cell lost in all rows", "a cell too many in all rows"]
TORN = [*[kind for kind in TRUNCATED if "number" in kind or "separator" in kind]]
TORN += ["cut in the middle of the file", "zeros at the end"]
DAMAGED = ["zeros inside a row", "zeros over rows", "letters that are none", "text", "comments"]
DAMAGED += ["text in place of a row", "names in the middle", "a newline lost", "a cell lost"]
DAMAGED += ["a cell too many", "steering text", "1_000", "the head twice"]
SAME = ["cut before the newline", "CRLF", "CRLF, cut between both", "CR", "quotes", "a stray quote"]
SAME += ["a comment on top", "blank lines", "blank lines on top", "a head in quotes", "a head"]
SAME += ["a head as a comment", "negative times"]
HOLES = ["a row without numbers", "an empty row", "a cell without a number", "empty cells"]
HOLES += ["an empty current"]
NO_TIME = ["a time that is no number", "an infinite time", "an empty time"]
DISORDER = ["rows shuffled", "rows reversed", "two rows exchanged", "a row late"]
REPEATS = ["a row repeated", "a block repeated", "all rows twice"]
ABSURD = ["a huge position", "an infinite velocity", "an infinite row", "a huge row"]
UNITS = [kind for kind in CHANNELS if " in m" in kind or " in degrees" in kind]
WRONG = [kind for kind in CHANNELS if " in k" in kind or " exchanged" in kind]

SHARED: list[tuple[list[str], Expected]] = [
    (SAME, Expected("same")),
    (TORN, Expected("repaired", "torn last line")),
    (DAMAGED, Expected("repaired", "damaged lines")),
    (["byte-order mark"], Expected("repaired", "byte-order mark")),
    (["decimal commas, semicolons"], Expected("repaired", "decimal commas")),
    (["gzip"], Expected("repaired", "compressed file")),
    (NO_TIME, Expected("repaired", "missing times")),
    (["words in the first row"], Expected("repaired", "damaged lines", lost=1)),
    (REPEATS, Expected("repaired", "repeated frames")),
]
ROBOT: list[tuple[list[str], Expected]] = [
    *SHARED,
    (NOT_TEXT, Expected("refused", "not a text file; save it as plain CSV")),
    (
        ["gzip, truncated", "gzip, garbled"],
        Expected("refused", "is a damaged gzip file; copy it again"),
    ),
    (EMPTY, Expected("refused", "line 1: (no complete row|expected|no column `timestamp`)")),
    (OTHER_ROWS, Expected("refused", r"line [12]: expected \d+ numbers .*\d+ cells")),
    (
        ["cut inside the head", "no time at all"],
        Expected("refused", "line 1: (no complete row|expected)"),
    ),
    (["a separator behind each row"], Expected("refused", "line [12]: .*; ")),
    (["cut after the first row"], Expected("refused", "contains only 1 complete frames; record")),
    (
        ["a cell too many in most rows"],
        Expected("refused", r"line [23]: expected \d+ numbers .* of \d+ lines do not fit"),
    ),
    (
        ["all times equal"],
        Expected("refused", "timestamps is 0 s; check that the time column is in seconds"),
    ),
    (
        ["milliseconds", "microseconds", "thousandths"],
        Expected("refused", "step between timestamps is .* s; check that the time"),
    ),
    (["no head"], Expected("refused", "line 1: no header; .*name the columns")),
    (["a name twice"], Expected("refused", "line 1: column 'actual_q_0' appears twice; give")),
    (["a misspelt time"], Expected("refused", "line 1: no column `timestamp` .*; record")),
    (
        ["a misspelt position", "an empty column"],
        Expected("refused", "has no actual_q_0 to actual_q_5"),
    ),
    (["a misspelt current"], Expected("repaired", "incomplete channels")),
    (["a steering name"], Expected("repaired", "unknown channels")),
    (UNITS, Expected("refused", r"_\d exceeds .* in .* of the rows .*; .*correct the file")),
    (WRONG, Expected("told", "inconsistent channels")),
    (
        ["time and position exchanged", "time last"],
        Expected("refused", "exceeds .*; .*correct the file"),
    ),
    ([*ROWS_OUT, *ABSURD, "misaligned rows"], Expected("repaired", "impossible frames")),
    (["a first time of 1e300"], Expected("repaired", "impossible frames", lost=1)),
    (["clock reset"], Expected("told", "clock reset")),
    (DISORDER, Expected("repaired", "frames out of order")),
    (["stale stamps"], Expected("repaired", "stale stamps")),
    (["stale data"], Expected("repaired", "stale data")),
    (["rows lost, few", "rows lost in turn"], Expected("repaired", "lost frames")),
    (["rows lost, many"], Expected("repaired", "split")),
    (HOLES, Expected("repaired", "missing cells")),
    ([k for k in LINES if k.startswith("no numbers")], Expected("repaired", "incomplete frames")),
    (
        ["a file missing", "a folder for a file"],
        Expected("refused", "is missing or cannot be read .*; add the file"),
    ),
]
RTDE: list[tuple[list[str], Expected]] = [
    (["a separator behind each row"], Expected("repaired", "unknown channels")),
]
THESIS: list[tuple[list[str], Expected]] = [
    ([*ROWS_OUT, "a first time of 1e300"], Expected("repaired", "impossible times")),
    (["words in the first row"], Expected("repaired", "damaged lines")),
    # Its files are joined by their stamps, so that their order does not matter.
    (DISORDER, Expected("same")),
    (["a row repeated", "all rows twice", "stale stamps"], Expected("repaired", "repeated stamps")),
    (["rows lost, few"], Expected("repaired", "missing cells")),
    (
        ["time and position exchanged", "time last"],
        Expected("refused", "step between timestamps is .* s; check that the time"),
    ),
]
SENSOR: list[tuple[list[str], Expected]] = [
    *SHARED,
    (
        ["cut after the first row", "no time at all", "an empty column"],
        Expected("repaired", "no sensor"),
    ),
    (EMPTY, Expected("repaired", "no sensor")),
    ([*OTHER_ROWS, "a separator behind each row"], Expected("repaired", "unusable sensor")),
    (["zeros of no sensor", "no values recorded"], Expected("repaired", "no sensor")),
    (["a file missing"], Expected("repaired", "no sensor")),
    (["a folder for a file"], Expected("repaired", "unusable sensor")),
    ([*NOT_TEXT, "gzip, truncated", "gzip, garbled"], Expected("repaired", "unusable sensor")),
    (["a cell too many in most rows", "forces in mN"], Expected("repaired", "unusable sensor")),
    (["all times equal", "milliseconds"], Expected("repaired", "unusable sensor")),
    (["microseconds", "thousandths"], Expected("repaired", "unusable sensor")),
    (
        [*ROWS_OUT, "a huge row", "an infinite row", "a huge force"],
        Expected("repaired", "impossible samples"),
    ),
    (["misaligned rows"], Expected("repaired", "impossible samples")),
    # Its clock counts from the first row; when that is lost, it is told and a sample late.
    (["a first time of 1e300"], Expected("told", "impossible samples")),
    (["words in the first row"], Expected("told", "damaged lines")),
    (["negative times"], Expected("repaired", "stale copy")),
    (["clock reset"], Expected("repaired", "clock reset")),
    (DISORDER, Expected("repaired", "samples out of order")),
    (["stale stamps"], Expected("told", "stale stamps")),
    (
        [kind for kind in LINES if kind.startswith("rows lost")],
        Expected("repaired", "lost samples"),
    ),
    ([*HOLES, "a force that is no number"], Expected("repaired", "missing cells")),
    ([k for k in LINES if k.startswith("no numbers")], Expected("repaired", "missing cells")),
    (["a stamp of another day"], Expected("repaired", "stale copy")),
    ([k for k in STAMPS if "another" not in k], Expected("repaired", "no start stamp")),
]


def expected(base: Base, kind: str, part: str = "robot") -> Expected:
    """What a kind of damage must give; the last entry that knows it counts."""
    special = {"rtde": RTDE, "made-up": THESIS}.get(base.name, [])
    special = THESIS if base.name.startswith("Movement") else special
    entries = SENSOR if part == "sensor" else [*ROBOT, *special]
    return [outcome for known, outcome in entries if kind in known][-1]
