"""Reader of files of arrays: the study names the array of each channel."""

from collections.abc import Collection, Iterable
from itertools import takewhile
from pathlib import Path

import numpy as np
import pandas as pd

import ur5lib.recordings.echoed
import ur5lib.recordings.own_formats  # noqa: F401 - both register their format
from ur5lib.channels import JOINT_CHANNELS, MOST_JOINTS, joint_count
from ur5lib.channels import suffixes as suffixes_of
from ur5lib.errors import InputError
from ur5lib.recordings.array_files import LOADERS, PACKED_ENDING, Arrays, array_format
from ur5lib.recordings.channel_files import at_stamps
from ur5lib.recordings.delimited import drop_untimed
from ur5lib.recordings.entries import ArrayFiles, StoredTable
from ur5lib.recordings.plausibility import drop_zeroed, first_time
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.recordings.sensors import counted_from_first, on_robot_clock, repair_samples
from ur5lib.records.quality import Finding, Log


@array_format("rosbag", "a ROS bag", ".bag", ".db3", ".mcap", PACKED_ENDING, is_folder=True)
def rosbag_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of messages by `<topic>/<field>`."""
    from ur5lib.recordings.rosbag import arrays_of_bag  # slow to import

    return arrays_of_bag(path, wanted, findings)


def read_arrays(recording: ArrayFiles) -> RawRecording:
    """Read the arrays of a robot, and those of sensors in the same file.

    Raises InputError when the file lacks an array, or arrays of one clock differ in length.
    """
    path, findings, sensors = recording.path, list[Finding](), recording.sensors()
    arrays = _loaded(recording, [recording, *sensors.values()], findings)
    in_arm_order = {
        f"{channel}_{place}": f"{channel}_{joint - 1}"
        for channel in JOINT_CHANNELS
        for place, joint in enumerate(recording.joints or [])
    }
    table = _table(recording, arrays, path)
    _expect_listed(recording, table)
    table = table.rename(columns=in_arm_order)
    table = drop_untimed(drop_zeroed(table, findings), Log(path, "robot", findings))
    if table.empty:
        raise InputError(f"{path}: no row has a time; record it again, or correct `channels`")
    robot = counted_from_first(table, first_time(table["time"].to_numpy()), recording, path)
    present = {}
    for device, sensor in sensors.items():
        log, shares = Log(path, device, findings), sensor.shares_clock(recording)
        record = _sensor(sensor.on_clock_of(recording) if shares else sensor, arrays, log)
        if record is not None:
            present[device] = on_robot_clock(record) if shares else record
    return RawRecording(robot, recording.cycle, present, findings)


def rows_of_arrays(recording: ArrayFiles) -> pd.DataFrame:
    """Return all rows of a robot's arrays as they are in the file, `time` [s] among them, NaN where
    a row has none.

    Raises InputError as `read_arrays` does.
    """
    table = _table(recording, _loaded(recording, [recording], []), recording.path)
    return drop_zeroed(table, [])


def _loaded(recording: ArrayFiles, named: Iterable[StoredTable], findings: list[Finding]) -> Arrays:
    """Return the arrays, and their columns, that a robot and its sensors name in a file."""
    arrays = LOADERS[recording.format](recording.path, _wanted(named), findings)
    return _with_columns(_on_its_clock(recording, arrays))


def _on_its_clock(recording: ArrayFiles, arrays: Arrays) -> Arrays:
    """Return arrays; of a folder of text files, all at the stamps of the file in which the study
    names the time, as `q.csv_0`.
    """
    name, mark, column = str(recording.channels.get("time", "")).rpartition("_")
    is_stamped = recording.format == "channel-files" and mark and column == "0" and name in arrays
    return at_stamps(arrays, name) if is_stamped else arrays


def _expect_listed(recording: ArrayFiles, table: pd.DataFrame) -> None:
    """Raise InputError where `joints` lists more or fewer joints than the arrays have."""
    listed, found = len(recording.joints or []), joint_count(table.columns)
    if listed not in (0, found):
        raise InputError(
            f"`joints` in the study lists {listed} joints, but {recording.path} has {found}; "
            "list the joint of each column"
        )


def _wanted(tables: Iterable[StoredTable]) -> set[str]:
    """Return all array names that a study's entry may mean, with `_0` ... for the columns of a
    channel.
    """
    named = {
        (channel, name)
        for table in tables
        for channel, given in table.channels.items()
        for name in ([given] if isinstance(given, str) else given)
    }
    single = {
        name + suffix for channel, name in named for suffix in suffixes_of(channel, MOST_JOINTS)
    }
    whole = {name.rpartition("_")[0] for _, name in named if name.rpartition("_")[2].isdecimal()}
    return {name for _, name in named} | single | whole


def _table(named: StoredTable, arrays: Arrays, path: Path) -> pd.DataFrame:
    """Return `time` and the channels in SI units, from arrays as the study names them."""
    first, *others = sorted(named.channels.items(), key=lambda pair: pair[0] != "time")
    values = _array(arrays, *first, path)
    if first[0] == "time":
        columns = {"time": seconds_of(values)}
        rows = len(columns["time"])
    else:
        rows = max(values.shape)
        columns = _columns(*first, arrays, rows, path)
    for channel, given in others:
        columns |= _columns(channel, given, arrays, rows, path)
    return named.in_si(pd.DataFrame(columns))


def _columns(
    channel: str, given: str | list[str], arrays: Arrays, rows: int, path: Path
) -> dict[str, np.ndarray]:
    """Return a channel's columns by name; an array with one row for each column is transposed."""
    values = np.atleast_2d(_array(arrays, channel, given, path)).astype(float)
    shapes = [values.shape, values.shape[::-1]]
    # as many joints as there are, if the channel can have them
    width = next((k for count, k in shapes if count == rows and 1 < k <= MOST_JOINTS), 6)
    suffixes = suffixes_of(channel, width) or ("",)
    if (rows, len(suffixes)) not in shapes or rows == len(suffixes) > 1:
        raise InputError(
            f"{path}: {given} ({channel}) has shape {shapes[0]}, but its clock has {rows} stamps "
            f"and the channel {len(suffixes)} columns; correct `channels` in the study, or record "
            "it again"
        )
    columns = values.T if shapes[0] == (rows, len(suffixes)) else values
    return {channel + suffix: column for suffix, column in zip(suffixes, columns, strict=True)}


def _array(arrays: Arrays, channel: str, given: str | list[str], path: Path) -> np.ndarray:
    """Return the array that a channel names, or several that contain its columns, joined as (k, n).

    A name `<name>` may stand for `<name>_0` ... in the file. Raises InputError where one is
    missing.
    """
    if isinstance(given, str) and given in arrays:
        return arrays[given]
    single = given if isinstance(given, list) else _single(arrays, channel, given) or [given]
    missing = [name for name in single if name not in arrays]
    if missing or not single:
        named = given if isinstance(given, str) else missing[0]
        raise InputError(
            f"{path}: {channel} names {named}, which the file lacks; correct `channels` in "
            "the study (`ur5 import` writes them), or copy the file again"
        )
    parts = [np.atleast_2d(arrays[name]) for name in single]
    rows = max(parts[0].shape)
    turned = [part if part.shape[1] == rows else part.T for part in parts]
    if len({part.shape[1] for part in turned}) > 1:
        raise InputError(
            f"{path}: the columns of {channel} differ in length; correct `channels`, or record it "
            "again"
        )
    return np.concatenate(turned)


def _with_columns(arrays: Arrays) -> Arrays:
    """Return arrays, and each column of those with several by name and number, as `state_3`."""
    tall = {
        name: rows if rows.shape[0] > rows.shape[1] else rows.T
        for name, rows in arrays.items()
        if rows.ndim == 2
    }
    columns = {
        f"{name}_{k}": column for name, rows in tall.items() for k, column in enumerate(rows.T)
    }
    return columns | arrays


def _single(arrays: Arrays, channel: str, given: str) -> list[str]:
    """Return the names `<name>_0` ... of a channel's columns, for as many joints as the file
    has.
    """
    every = [given + suffix for suffix in suffixes_of(channel, MOST_JOINTS)]
    if channel not in JOINT_CHANNELS:
        return every
    return [*takewhile(arrays.__contains__, every)] or every[:6]


def seconds_of(stamps: np.ndarray) -> np.ndarray:
    """Return stamps as (n,); of pairs (n, 2) or (2, n), the first is in seconds, the second in
    nanoseconds.
    """
    pairs = stamps.T if stamps.ndim == 2 and stamps.shape[0] == 2 else stamps
    if pairs.ndim == 2 and pairs.shape[1] == 2:
        return pairs[:, 0] + 1e-9 * pairs[:, 1]
    return stamps.ravel().astype(float)


def _sensor(sensor: StoredTable, arrays: Arrays, log: Log) -> DeviceRecord | None:
    """Return a sensor's record; where it cannot be used, None and a finding."""
    samples = log.unless_unusable(lambda: repair_samples(_table(sensor, arrays, log.path), log))
    if samples is None:
        return None
    return counted_from_first(samples.table, samples.first, sensor, log.path)
