"""Signals with a dimension `joint`, for xarray, which is an extra."""

import re
from typing import TYPE_CHECKING

import pandas as pd

from ur5lib.workspace.beside import of_extra

if TYPE_CHECKING:
    import xarray

OF_A_JOINT = re.compile(r"(.+)_(\d+)")


def by_joint(frame: pd.DataFrame) -> "xarray.Dataset":
    """Return a frame by `time` as a data set: columns `actual_q_0` ... are one variable (time,
    joint), with joints from 1 as in tables; units are in `attrs["units"]` of each.

    Raises InputError without xarray.
    """
    xarray = of_extra("xarray", "xarray", "to_xarray")
    units, parts = frame.attrs.get("units", {}), dict[str, list[str]]()
    for name in map(str, frame.columns):
        found = OF_A_JOINT.fullmatch(name)
        parts.setdefault(found[1] if found else name, []).append(name)
    most = max(map(len, parts.values()), default=0)
    data = {
        stem: (
            ("time", "joint")[: 1 + (len(names) > 1)],
            frame[names].to_numpy() if len(names) > 1 else frame[names[0]].to_numpy(),
            {"units": units.get(names[0], "")},
        )
        for stem, names in parts.items()
        if len(names) in (1, most)
    }
    return xarray.Dataset(data, {"time": frame.index.to_numpy(), "joint": range(1, most + 1)})
