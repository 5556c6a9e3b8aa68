"""The columns that a study declares, and their units."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from ur5lib.errors import InputError

SKIPPED = "-"
RESERVED = ["time", "received", "epoch", "slot", "segment", "interpolated"]  # of frame repair
SIX = [f"_{index}" for index in range(6)]
XYZ = ["x", "y", "z"]
SUFFIXES = {  # of vector channels; all other channels have one column
    "actual_q": SIX,
    "actual_qd": SIX,
    "actual_current": SIX,
    "actual_TCP_pose": SIX,
    "actual_TCP_speed": SIX,
    "actual_TCP_force": SIX,
    "actual_joint_voltage": SIX,
    "actual_current_as_torque": SIX,
    "target_q": SIX,
    "target_qd": SIX,
    "target_qdd": SIX,
    "target_current": SIX,
    "target_moment": SIX,
    "target_TCP_pose": SIX,
    "target_TCP_speed": SIX,
    "joint_temperatures": SIX,
    "joint_control_output": SIX,
    "ft_raw_wrench": SIX,
    "actual_tool_accelerometer": SIX[:3],
    "elbow_position": SIX[:3],
    "elbow_velocity": SIX[:3],
    "payload_cog": SIX[:3],
    "payload_inertia": SIX,
    "tcp_offset": SIX,
    "ft": ["_fx", "_fy", "_fz", "_tx", "_ty", "_tz"],
    "ft_f": XYZ,
    "ft_t": XYZ,
    "imu_a": XYZ,
    "imu_g": XYZ,
    "imu_m": XYZ,
}
JOINT_CHANNELS = [  # a column for each joint; the other vectors of six are poses and wrenches
    "actual_q",
    "actual_qd",
    "actual_current",
    "actual_joint_voltage",
    "actual_current_as_torque",
    "target_q",
    "target_qd",
    "target_qdd",
    "target_current",
    "target_moment",
    "joint_temperatures",
    "joint_control_output",
]
FACTORS = {  # from these units to SI
    "deg": np.pi / 180,
    "deg/s": np.pi / 180,
    "deg/s2": np.pi / 180,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "mA": 1e-3,
    "mm": 1e-3,
    "mNm": 1e-3,
    "g": 9.80665,
}


def expand(columns: Sequence[str]) -> list[str]:
    """Return the names of the single columns: actual_q becomes actual_q_0 .. actual_q_5.

    Raises InputError when a column is named twice or `time` is missing.
    """
    names = [
        f"{SKIPPED}{index}" if column == SKIPPED else column + suffix
        for index, column in enumerate(columns)
        for suffix in SUFFIXES.get(column, [""])
    ]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or "time" not in names:
        fault = f"name {twice[0]} twice" if twice else "lack `time`"
        raise InputError(f"`columns` in the study {fault}; name `time` and each channel once")
    return names


def to_si(table: pd.DataFrame, units: Mapping[str, str]) -> pd.DataFrame:
    """Return a table with its channels in SI units and without the columns to skip.

    units: by channel, with or without suffix. Raises InputError for an unknown channel or unit.
    """
    table = table.drop(columns=[name for name in table if name.startswith(SKIPPED)])
    for channel, unit in units.items():
        names = [channel + suffix for suffix in SUFFIXES.get(channel, [""])]
        if unit not in FACTORS or not set(names) <= set(table):
            raise InputError(
                f"`units` in the study give {channel} in {unit}; "
                f"use one of {', '.join(FACTORS)}, for channels that `columns` names"
            )
        table[names] = table[names] * FACTORS[unit]
    return table
