"""Reader of files that hold arrays: the study says which of them is which channel."""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.channels import JOINT_CHANNELS, SUFFIXES
from ur5lib.errors import InputError
from ur5lib.recordings.channel_files import channel_file_arrays
from ur5lib.recordings.columnar import feather_arrays, parquet_arrays
from ur5lib.recordings.columns import to_si
from ur5lib.recordings.delimited import drop_untimed
from ur5lib.recordings.hdf5 import hdf5_arrays
from ur5lib.recordings.mat import mat_arrays
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.quality import SENSORS, Device, Finding
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.recordings.rosbag import rosbag_arrays
from ur5lib.recordings.sensors import repair_samples, table_start
from ur5lib.recordings.storage import Arrays
from ur5lib.recordings.zeroed import drop_zeroed
from ur5lib.strict import expect_file

LOADERS: dict[str, Callable[[Path, Collection[str] | None, list[Finding]], Arrays]] = {
    "hdf5": hdf5_arrays,
    "mat": mat_arrays,
    "rosbag": rosbag_arrays,
    "parquet": parquet_arrays,
    "feather": feather_arrays,
    "channel-files": channel_file_arrays,
}


def read_stored(recording: Mapping[str, Any]) -> RawRecording:
    """Read arrays. recording: `format`, `folder`, `file`, `channels`, `joints`, `units`, `time`.

    A sensor is read from the same file. Raises InputError when the file lacks an array, or arrays
    of one clock differ in length.
    """
    path, findings = _path(recording), list[Finding]()
    sensors = {d: recording[key] for key, d in SENSORS.items() if recording.get(key)}
    named = [recording, *sensors.values()]
    arrays = load_arrays(recording["format"], path, _wanted(named), findings)
    table = _table(recording, arrays, path)
    table = _in_arm_order(table, recording["joints"] or [*range(1, 7)])
    table = drop_untimed(drop_zeroed(table, findings), path, "robot", findings)
    if table.empty:
        raise InputError(f"{path}: no row has a time; record it again, or correct `channels`")
    first = first_time(table["time"].to_numpy())
    start = table_start(first, recording["time"])
    robot = DeviceRecord(table.assign(time=table["time"] - first), start, str(path))
    records = {d: _sensor(sensor, arrays, path, d, findings) for d, sensor in sensors.items()}
    return RawRecording(robot, None, {d: r for d, r in records.items() if r}, findings)


def load_arrays(
    format: str, path: Path, wanted: Collection[str] | None, findings: list[Finding]
) -> Arrays:
    """Return arrays of a file by their path in it; None wanted: all of them.

    Names that the file lacks are left out. Raises InputError when it cannot be read.
    """
    expect_file(path)
    if format != "channel-files" and not path.is_file():
        raise InputError(
            f"{path} is missing or is a folder; add the file, or remove the recording from the "
            "study"
        )
    return LOADERS[format](path, wanted, findings)


def _path(recording: Mapping[str, Any]) -> Path:
    return Path(recording["folder"]) / (recording.get("file") or "")


def _wanted(tables: list[Mapping[str, Any]]) -> set[str]:
    """Return the names of all arrays that may be meant: also of single columns."""
    named = {
        (channel, name)
        for table in tables
        for channel, given in table["channels"].items()
        for name in ([given] if isinstance(given, str) else given)
    }
    single = {name + suffix for channel, name in named for suffix in SUFFIXES.get(channel, [])}
    return {name for _, name in named} | single


def _table(named: Mapping[str, Any], arrays: Arrays, path: Path) -> pd.DataFrame:
    """Return `time` and the channels in SI units; named: `channels`, `units` and `time`."""
    time = seconds_of(_array(arrays, "time", named["channels"]["time"], path))
    columns = {"time": time}
    for channel, given in named["channels"].items():
        if channel != "time":
            columns |= _columns(channel, given, arrays, len(time), path)
    units = named["units"] | ({"time": "ms"} if named["time"] == "day_ms" else {})
    return to_si(pd.DataFrame(columns), units)


def _columns(
    channel: str, given: str | list[str], arrays: Arrays, rows: int, path: Path
) -> dict[str, np.ndarray]:
    """Return a channel's columns, turned where the file has one row for each of them."""
    suffixes = SUFFIXES.get(channel, [""])
    values = np.atleast_2d(_array(arrays, channel, given, path)).astype(float)
    shapes = [values.shape, values.shape[::-1]]
    if (rows, len(suffixes)) not in shapes or rows == len(suffixes) > 1:
        raise InputError(
            f"{path}: {given} ({channel}) has shape {shapes[0]}, but its clock has {rows} stamps "
            f"and the channel {len(suffixes)} columns; correct `channels` in the study, or record "
            "it again"
        )
    columns = values.T if shapes[0] == (rows, len(suffixes)) else values
    return {channel + suffix: column for suffix, column in zip(suffixes, columns, strict=True)}


def _array(arrays: Arrays, channel: str, given: str | list[str], path: Path) -> np.ndarray:
    """Return the array that a channel names, or those that hold its columns, joined as (k, n).

    A name stands for `<name>_0` ... too. Raises InputError where one is missing.
    """
    if isinstance(given, str) and given in arrays:
        return arrays[given]
    single = [given + s for s in SUFFIXES.get(channel, [])] if isinstance(given, str) else given
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


def seconds_of(stamps: np.ndarray) -> np.ndarray:
    """Return stamps (n,); pairs (n, 2) or (2, n) are seconds and nanoseconds."""
    pairs = stamps.T if stamps.ndim == 2 and stamps.shape[0] == 2 else stamps
    if pairs.ndim == 2 and pairs.shape[1] == 2:
        return pairs[:, 0] + 1e-9 * pairs[:, 1]
    return stamps.ravel().astype(float)


def _in_arm_order(table: pd.DataFrame, joints: list[int]) -> pd.DataFrame:
    """Return the table with each joint's columns under its own number.

    joints: of each column, 1 to 6.
    """
    names = {
        f"{channel}_{place}": f"{channel}_{joint - 1}"
        for channel in JOINT_CHANNELS
        for place, joint in enumerate(joints)
    }
    return table.rename(columns=names)


def _sensor(
    sensor: Mapping[str, Any],
    arrays: Arrays,
    path: Path,
    device: Device,
    findings: list[Finding],
) -> DeviceRecord | None:
    """Return a sensor's record; where it cannot be used, None and a finding."""
    try:
        samples = repair_samples(_table(sensor, arrays, path), path, device, findings)
    except InputError as error:
        findings.append(Finding(device, "unusable sensor", "error", 1, {"error": str(error)}))
        return None
    if samples is None:
        return None
    table = samples.table.assign(time=samples.table["time"] - samples.first)
    return DeviceRecord(table, table_start(samples.first, sensor["time"]), str(path))
