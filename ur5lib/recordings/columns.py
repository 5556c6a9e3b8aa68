"""The columns that a study declares, and their units."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from ur5lib.channels import columns as columns_of
from ur5lib.errors import InputError

SKIPPED = "-"
RESERVED = ["time", "received", "epoch", "slot", "segment", "interpolated"]  # of frame repair
OPPOSITE = "opposite"  # SI, with the opposite sign: a wrench of the arm on its surroundings
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
    OPPOSITE: -1.0,
}


def expand(columns: Sequence[str]) -> list[str]:
    """Return the names of the single columns: actual_q becomes actual_q_0 .. actual_q_5.

    Raises InputError when a column is named twice or `time` is missing.
    """
    names = [
        f"{SKIPPED}{index}" if column == SKIPPED else name
        for index, column in enumerate(columns)
        for name in columns_of(column)
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
        names = columns_of(channel)
        if unit not in FACTORS or not set(names) <= set(table):
            raise InputError(
                f"`units` in the study give {channel} in {unit}; "
                f"use one of {', '.join(FACTORS)}, for channels that `columns` names"
            )
        table[names] = table[names] * FACTORS[unit]
    return table
