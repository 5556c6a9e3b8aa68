"""Channels that repeat one value to the last bit while the arm moves on: nobody measured them."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.channels import joint_count
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Device, Finding
from ur5lib.timeseries.arrays import Array

MIN_FROZEN_TIME = 1.0  # s; in right logs of eight arms, no value of a moving joint lasts for 0.25 s
MIN_FROZEN_ROWS = 10
# It is the ratio to how long values last that are rounded, or repeated until the next: nearly all
# others.
MIN_LENGTH_RATIO, USUAL_QUANTILE = 5.0, 0.99
MIN_VALUES = 20  # this many values of a column show how long they last
MIN_TRAVEL = 0.05  # rad, by which a joint moves meanwhile
MIN_SPEED = 0.1  # rad/s; drivers round smaller velocities to zero
JOINT_CHANNELS = ("actual_q", "actual_current", "actual_torque", "actual_current_as_torque")
WRENCHES = ("actual_TCP_force", "ft_raw_wrench")


class Frozen(NamedTuple):
    """A column, and rows in which its value stays the same."""

    column: str
    rows: slice


def without_frozen(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return frames with NaN where positions or efforts stay the same while their joints move.

    Velocities that stay the same while positions change are dropped, since slopes of positions
    replace them; wrenches are dropped if they stay the same to the end. frames: in order.
    """
    time, joints = frames["time"].to_numpy(float), range(joint_count(frames))
    if still := [*_of_joints(frames, "actual_qd")]:
        _report(findings, "robot", still, time)
        frames = frames.drop(columns=[name for name in frames if name.startswith("actual_qd_")])
    for frozen in [one for name in JOINT_CHANNELS for one in _of_joints(frames, name)]:
        _report(findings, "robot", [frozen], time)
        values = frames[frozen.column].to_numpy(float, copy=True)
        values[frozen.rows] = np.nan
        frames = frames.assign(**{frozen.column: values})
    for name in [name for name in WRENCHES if f"{name}_0" in frames]:
        columns = [f"{name}_{k}" for k in range(6)]
        first = frozen_end(frames[columns].to_numpy(float), time)
        if first is not None and any(_travels(frames[first:], joint) for joint in joints):
            report_frozen(findings, "robot", name, time, first)
            frames = frames.drop(columns=columns)
    return frames


def frozen_end(values: Array, time: Array) -> int | None:
    """Return the row from which on values (N, M) stay the same to the end, far longer than usual;
    None if they do not.

    time: (N,) [s].
    """
    rows = [*_lasting(values, time)]
    return rows[-1].start if rows and rows[-1].stop == len(values) else None


def report_frozen(
    findings: list[Finding], device: Device, name: str, time: Array, first: int
) -> None:
    """Add a finding on a channel that stays the same from row `first` on."""
    _report(findings, device, [Frozen(name, slice(first, len(time)))], time)


def _of_joints(frames: pd.DataFrame, name: str) -> Iterator[Frozen]:
    """Yield where a channel of a joint stays the same, though the joint moves."""
    time = frames["time"].to_numpy(float)
    for joint in range(joint_count(frames)):
        if (column := f"{name}_{joint}") in frames:
            for rows in _lasting(frames[column].to_numpy(float)[:, None], time):
                if _contradicts(frames, name, joint, rows):
                    yield Frozen(column, rows)


def _contradicts(frames: pd.DataFrame, name: str, joint: int, rows: slice) -> bool:
    """Return whether the joint moves in rows where its channel stays the same, so that it cannot be
    measured.
    """
    part = frames.iloc[rows]
    if name not in ("actual_q", "actual_qd"):
        efforts = part[[column for column in part if column.rpartition("_")[0] == name]]
        return _travels(part, joint) and bool(efforts.any(axis=None))  # an arm without power: none
    time, q = part["time"].to_numpy(float), part[f"actual_q_{joint}"].to_numpy(float)
    if f"actual_qd_{joint}" not in part:
        return False
    qd = part[f"actual_qd_{joint}"].to_numpy(float)
    if name == "actual_q":
        moved = np.nancumsum(qd[:-1] * np.diff(time))
        return _range(moved) > MIN_TRAVEL and float(np.nanmean(np.abs(qd))) > MIN_SPEED
    second = min(len(time) - 1, round(MIN_FROZEN_TIME * len(time) / np.ptp(time)))
    slopes = (q[second:] - q[:-second]) / (time[second:] - time[:-second])
    return float(np.nanmax(np.abs(slopes - qd[0]))) > 2 * MIN_SPEED


def _travels(frames: pd.DataFrame, joint: int) -> bool:
    return _range(frames[f"actual_q_{joint}"].to_numpy(float)) > MIN_TRAVEL


def _range(values: Array) -> float:
    return float(np.nanmax(values, initial=-np.inf) - np.nanmin(values, initial=np.inf))


def _lasting(values: Array, time: Array) -> Iterator[slice]:
    """Yield the rows in which values (N, M) stay the same for far longer than they usually do."""
    known = np.flatnonzero(np.isfinite(values).all(axis=1))
    changes = 1 + np.flatnonzero((np.diff(values[known], axis=0) != 0).any(axis=1))
    if len(changes) < MIN_VALUES:
        return
    bounds = np.concatenate([[0], changes, [len(known)]])
    lengths = np.diff(bounds)
    usual = np.quantile(lengths, USUAL_QUANTILE, method="lower")
    least = max(MIN_FROZEN_ROWS, MIN_LENGTH_RATIO * usual)
    for place in np.flatnonzero(lengths >= least):
        first, last = known[bounds[place]], known[bounds[place + 1] - 1]
        if time[last] - time[first] >= MIN_FROZEN_TIME:
            yield slice(int(first), int(last) + 1)


def _report(findings: list[Finding], device: Device, frozen: list[Frozen], time: Array) -> None:
    since, until = min(one.rows.start for one in frozen), max(one.rows.stop for one in frozen)
    names = ", ".join(sorted({one.column for one in frozen}))
    detail = (
        f"{names}: one value is repeated to the last bit from "
        f"{number(time[since] - time[0], '.4g')} s on, for "
        f"{number(np.ptp(time[since:until]), '.3g')} s: it was not measured, and is not used"
    )
    findings.append(Finding(device, Found.FROZEN_CHANNEL, "warning", until - since, detail))
