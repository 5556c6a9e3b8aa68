"""The entry of a recording in a study, as far as its reader needs it: files, columns, units."""

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, TypeAdapter, model_validator
from pydantic_core import PydanticCustomError

from ur5lib.channels import MEASURED_EFFORTS, SIX_SUFFIXES, joint_count, meant
from ur5lib.channels import columns as columns_of
from ur5lib.errors import InputError
from ur5lib.recordings.roll_overs import without_roll_over
from ur5lib.records.account import AccountRow
from ur5lib.records.quality import SENSORS, Device
from ur5lib.robots.description import Direction, Vector3
from ur5lib.strict import PathText, Strict

if TYPE_CHECKING:
    import pandas as pd

    from ur5lib.timeseries.arrays import Labels

SKIPPED_COLUMN = "-"
# Columns of frame repair.
RESERVED_COLUMNS = ["time", "received", "epoch", "slot", "segment", "interpolated"]
UNKNOWN = "unknown"  # the unit of efforts, of which no force may be stated then
OPPOSITE_SIGN = "opposite"  # SI, with the opposite sign, as a wrench of the arm on its surroundings
UNIT_FACTORS = {  # from these units to SI
    "deg": math.pi / 180,
    "deg/s": math.pi / 180,
    "deg/s2": math.pi / 180,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "mA": 1e-3,
    "mm": 1e-3,
    "mNm": 1e-3,
    "g": 9.80665,
    OPPOSITE_SIGN: -1.0,
    UNKNOWN: 1.0,
}


RunFile = Annotated[
    PathText,
    Field(
        description="path within the recording's folder, of a bag also its folder; a pattern, as "
        "`2026-*/*.csv`, stands for an entry of each file that it matches, named after it and "
        "dated by its path"
    ),
]


class InUnits(Strict):
    """Channels and their units."""

    units: dict[str, str | list[float]] = Field(
        default={},
        description="units of the channels not in SI units: deg, deg/s, ms, mA, g, ...; "
        "`opposite`: SI units with the opposite sign, as of a force sensor that reads the force of "
        "the arm on its surroundings; `unknown`: of currents or torques, so that no force is "
        "stated; or a list with the SI value of one unit of each column",
    )

    def in_si(self, table: "pd.DataFrame") -> "pd.DataFrame":
        """Return a table with its channels in SI units and without the columns to skip.

        Raises InputError for an unknown unit, and for units of channels that the table lacks.
        """
        table = table.drop(columns=[name for name in table if name.startswith(SKIPPED_COLUMN)])
        joints = joint_count(table.columns) or len(SIX_SUFFIXES)
        for channel, unit in self.known_units().items():
            names = columns_of(channel, joints)
            factor = UNIT_FACTORS.get(unit) if isinstance(unit, str) else unit
            fits = not isinstance(factor, list) or len(factor) == len(names)
            fits &= unit != UNKNOWN or channel in MEASURED_EFFORTS
            if factor is None or not fits or not set(names) <= set(table):
                raise InputError(
                    f"`units` in the study give {channel} in {unit}; "
                    f"use one of {', '.join(UNIT_FACTORS)}, "
                    "or a number for each of its columns, for channels of the recording"
                )
            table[names] = table[names] * factor
        return table

    def known_units(self) -> dict[str, str | list[float]]:
        """Return the units of the channels that are not in SI units, by channel."""
        return self.units


class Clocked(InUnits):
    """Channels with a common clock or rate, and their units."""

    time: Literal["relative_s", "epoch_s", "day_ms", "host_s"] = Field(
        "relative_s",
        description="time base: seconds since the start, seconds since 1970, milliseconds of the "
        "day, seconds of the clock of the computer that recorded robot and sensors together",
    )
    rate: float | None = Field(
        None,
        ge=1,
        le=5000,
        description="rows per second [Hz], of a log without a clock: its rows are equally spaced",
    )

    @property
    def cycle(self) -> float | None:
        """Return the time between two rows [s], None where each row has its own time."""
        return None if self.rate is None else 1 / self.rate

    def instead_of_time(self) -> str:
        """Return the key that the entry has in place of `time`, "rate"; empty where each row has
        its own time.
        """
        return "" if self.rate is None else "rate"

    def names(self) -> Collection[str]:
        """Return the names of the columns or channels, empty where the format defines them."""
        return ()

    @model_validator(mode="after")
    def _has_one_clock(self) -> Self:
        stamped, instead = "time" in self.names(), self.instead_of_time()
        if instead and (stamped or self.time != "relative_s"):
            raise of_entry(f"has both `time` and `{instead}`; remove one")
        if self.names() and not stamped and not instead:
            raise of_entry(
                "names no `time`; name it, or state the `rate` of the rows [Hz], or `still: true` "
                "if they are postures at rest"
            )
        return self

    def known_units(self) -> dict[str, str | list[float]]:
        """Return the units, by channel and of `time`, that are not SI."""
        return self.units | ({"time": "ms"} if self.time == "day_ms" else {})

    def in_si(self, table: "pd.DataFrame", row: "Labels | None" = None) -> "pd.DataFrame":
        """Return a table in SI units as `InUnits.in_si` does; if the entry has a rate, with the
        rows' time.

        row: numbers (N,) of the rows; default: in order.
        """
        table = super().in_si(table)
        if self.cycle is not None:
            table["time"] = self.cycle * (np.arange(len(table)) if row is None else row)
        elif "time" in table:
            table["time"] = without_roll_over(table["time"].to_numpy(float))
        return table


def _spelt(column: str) -> str:
    """Return a column's name unchanged. Raises ValueError where it is a misspelt channel."""
    if (channel := meant(column)) is not None:
        raise ValueError(
            f"`{channel}` if you mean that channel, or `{SKIPPED_COLUMN}` to skip the column"
        )
    return column


class DeviceTable(Clocked):
    """A delimited table of numbers, with or without a header line."""

    file: PathText = Field(description="path within the recording's folder")
    columns: list[Annotated[str, AfterValidator(_spelt)]] = Field(
        min_length=1,
        description="contents of the columns, in order: `time` and channels by their RTDE names; a "
        "channel without suffix stands for all its columns, `-` for a column to skip",
    )

    def names(self) -> Collection[str]:
        """Return the names of the columns."""
        return self.columns


class Sensor(DeviceTable):
    """A force sensor or an IMU with its own clock."""

    start_file: PathText | None = Field(
        None, description="file with the time at which a relative clock read zero"
    )
    start: Literal["epoch_s", "day_ms"] = Field(
        "epoch_s",
        description="unit of the time in `start_file`: seconds since 1970, milliseconds of the day",
    )
    offset_s: float | None = Field(
        None,
        description="time from the robot's first frame to the sensor's first sample [s], where "
        "their clocks have nothing in common; `ur5 import` finds it by efforts and forces",
    )
    drift_ppm: float = Field(
        0.0, description="by which the robot's clock is faster than the sensor's, with `offset_s`"
    )


class SensorMounting(Strict):
    """How a force sensor is mounted on the flange."""

    position_m: Vector3 = Field((0.0, 0.0, 0.0), description="its origin in frame 6 [m]")
    rotation_deg: Vector3 = Field(
        (0.0, 0.0, 0.0), description="rotation vector from frame 6 to its axes [°]"
    )


class Mounted(Strict):
    """A force sensor on the flange."""

    mounting: SensorMounting | None = Field(
        None, description="how it is mounted; default: as described for the arm"
    )


class ForceSensor(Mounted, Sensor):
    """A force sensor with its own clock."""


def _of_channels(channels: dict[str, str | list[str]]) -> dict[str, str | list[str]]:
    for name in channels:
        if (channel := meant(name)) is not None:
            raise ValueError(f"`{channel}` instead of `{name}`, if you mean that channel")
    if not all(channels.values()):
        raise ValueError("a mapping in which each channel names an array")
    return channels


class StoredTable(Clocked):
    """Arrays in a file, with one clock."""

    channels: Annotated[dict[str, str | list[str]], AfterValidator(_of_channels)] = Field(
        description="the array of each channel: of `time` and of channels by their RTDE names, "
        "without suffix; an array by its path in the file, or a list of those that hold its "
        "columns. Arrays may be n × 6 or 6 × n, stamps pairs of seconds and nanoseconds"
    )

    def names(self) -> Collection[str]:
        """Return the names of the channels."""
        return self.channels

    def shares_clock(self, other: "StoredTable") -> bool:
        """Return whether the arrays have the same time array and rate as others in the same
        file.
        """
        mine, its = ((one.channels.get("time"), one.rate) for one in (self, other))
        return mine == its

    def on_clock_of(self, other: "StoredTable") -> Self:
        """Return these arrays with the time base and time unit of `other`."""
        unit = {name: unit for name, unit in other.units.items() if name == "time"}
        return self.model_copy(update={"time": other.time, "units": self.units | unit})


class StoredForceSensor(Mounted, StoredTable):
    """Arrays of a force sensor."""


def _each_once(joints: list[int]) -> list[int]:
    if sorted(joints) != [*range(1, len(joints) + 1)]:
        raise ValueError(f"each joint from 1 to {len(joints)} once")
    return joints


class Files(Strict):
    """The device files of a recording, in any format; other keys of its entry are ignored."""

    model_config = ConfigDict(extra="ignore")

    folder: PathText = Field(description="the folder that holds the device files")
    from_s: float | None = Field(
        None, ge=0, description="use the recording from this time on, counted from its first frame"
    )
    to_s: float | None = Field(
        None, gt=0, description="use the recording until this time, counted from its first frame"
    )
    home_deg: list[float] | None = Field(
        None,
        description="angle of each joint [°] by the arm's description where the recorded position "
        "is zero: q = home + direction · recorded; default: as the arm's `drives` say, else 0",
    )
    directions: list[Direction] | None = Field(
        None,
        description="direction of each joint: -1 where the signs of its recorded positions, "
        "velocities, currents and torques are opposite to those of the arm's description; default: "
        "as the arm's `drives` say, else 1",
    )
    account: list[AccountRow] = Field(
        default=[],
        description="what `ur5 import` took each column for, and why; the report shows it",
    )
    format: str = Field(description="format of the files")

    @property
    def path(self) -> Path:
        """Return the robot's file, or the folder if the format consists of several files."""
        return Path(self.folder, getattr(self, "file", ""))

    @property
    def at_rest(self) -> bool:
        """Return whether the rows are postures at rest, without time."""
        return getattr(self, "still", False)

    def unknown_unit(self) -> bool:
        """Return whether the unit of the measured efforts is unknown."""
        return UNKNOWN in getattr(self, "units", {}).values()

    def sensors(self) -> dict[Device, Any]:
        """Return the entries of the sensors by device."""
        parts = {device: getattr(self, key, None) for key, device in SENSORS.items()}
        return {device: part for device, part in parts.items() if part is not None}

    def file_names(self) -> list[str]:
        """Return the names of the files in the entry; empty if it uses its whole folder."""
        parts = [self, *self.sensors().values()]
        names = [getattr(part, key, None) for part in parts for key in ("file", "start_file")]
        return [name for name in names if name is not None]


class WithSensors(Files):
    """Files of a robot and of sensors, each with its own clock."""

    force_sensor: ForceSensor | None = Field(None, description="file of the force sensor, if any")
    imu: Sensor | None = Field(None, description="file of the IMU, if any")


class RecordedFiles(WithSensors):
    """A file of the robot and files of its sensors, as `ur5 record` leaves them."""

    file: RunFile


class ThesisFiles(Files):
    """The files of the thesis's format."""

    format: Literal["thesis-csv"] = Field(description="format of the files")


class StreamFiles(RecordedFiles):
    """A capture of the realtime port."""

    format: Literal["realtime-stream"] = Field(description="format of the files")


class RtdeFiles(InUnits, RecordedFiles):
    """A CSV with RTDE names."""

    format: Literal["rtde-csv"] = Field(description="format of the files")


class RobotRows(Clocked):
    """Rows of a robot, which may be postures at rest."""

    still: bool = Field(
        False,
        description="postures at rest, without `time`: their currents tell torque constants by "
        "gravity; no friction and no force",
    )

    @property
    def cycle(self) -> float | None:
        """Return the time between two rows [s]; 1 for postures, which are counted; None where each
        row has its own time.
        """
        return 1.0 if self.still else super().cycle

    def instead_of_time(self) -> str:
        """Return the key that the entry has in place of `time`, "still" or "rate"; empty where each
        row has its own time.
        """
        return "still" if self.still else super().instead_of_time()

    @model_validator(mode="after")
    def _rests_without_time(self) -> Self:
        if self.still:
            needing = ("rate", "from_s", "to_s", "after", "force_sensor", "imu")
            timed = [key for key in needing if getattr(self, key, None) is not None]
            if timed:
                raise of_entry(f"is `still`, without time, but has `{timed[0]}`; remove one")
            if getattr(self, "role", "") == "contact":
                raise of_entry("is `still`, but has the role contact; give it the role fit")
        return self


class TableFiles(RobotRows, DeviceTable, WithSensors):
    """A delimited table with declared columns."""

    format: Literal["table-csv"] = Field(description="format of the files")


class ArrayFiles(RobotRows, StoredTable, Files):
    """Arrays of the robot, and of sensors in the same file."""

    joints: Annotated[list[int], AfterValidator(_each_once)] | None = Field(
        None,
        min_length=1,
        description="joint, from 1, of each column of the joints' arrays; default: in order",
    )
    force_sensor: StoredForceSensor | None = Field(
        None, description="arrays of the force sensor, if any"
    )
    imu: StoredTable | None = Field(None, description="arrays of the IMU, if any")


class StoredFiles(ArrayFiles):
    """Arrays in one file."""

    format: Literal["hdf5", "mat", "npz", "rosbag", "ros-echo", "parquet", "feather", "own"] = (
        Field(description="format of the files")
    )
    file: RunFile


class ChannelFiles(ArrayFiles):
    """A folder of text files with one array each."""

    format: Literal["channel-files"] = Field(description="format of the files")


Entry = Annotated[
    ThesisFiles | StreamFiles | RtdeFiles | TableFiles | StoredFiles | ChannelFiles,
    Field(discriminator="format"),
]
ENTRY: TypeAdapter[Entry] = TypeAdapter(Entry)


def of_entry(fault: str) -> PydanticCustomError:
    """Return the error of an entry as a whole; fault: the sentence without its subject."""
    return PydanticCustomError("of_entry", "{fault}", {"fault": fault})


def expand(columns: Sequence[str], joints: int = 6) -> list[str]:
    """Return the names of the single columns: actual_q becomes actual_q_0 .. actual_q_5.

    joints: of the arm. Raises InputError when a column is named twice.
    """
    names = [
        f"{SKIPPED_COLUMN}{index}" if column == SKIPPED_COLUMN else name
        for index, column in enumerate(columns)
        for name in columns_of(column, joints)
    ]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"`columns` name {twice[0]} twice; name each channel once")
    return names
