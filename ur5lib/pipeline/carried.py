"""What an arm carries beyond its description: in truth, and as its controller was told."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from ur5lib.robots.description import Payload
from ur5lib.tables import columns


@dataclass(frozen=True)
class Carried:
    """The payload that hangs on the flange, who says so, and the one the controller reckons with.

    Currents feel `payload`; `target_moment` contains `told`. None: nothing.
    """

    payload: Payload | None
    source: Literal["study", "rtde", "none"]
    told: Payload | None


def carried(declared: Payload | None, signals: pd.DataFrame) -> Carried:
    """What a recording's arm carries: what the study declares, else what RTDE's channels say."""
    told = told_payload(signals)
    if declared is not None:
        return Carried(declared, "study", told)
    return Carried(told, "none" if told is None else "rtde", told)


def told_payload(signals: pd.DataFrame) -> Payload | None:
    """The payload that the controller was told, by RTDE's channels (their medians).

    `payload` [kg], `payload_cog` [m, frame 6], `payload_inertia` [kg m²], the last two zero where
    they were not recorded. None where no mass was recorded, or none is carried.
    """
    mass = _median(signals, ["payload"])[0]
    if not mass > 0:
        return None
    x, y, z = _median(signals, columns("payload_cog", 3))
    xx, yy, zz, xy, xz, yz = _median(signals, columns("payload_inertia"))
    return Payload(mass=mass, center_of_mass=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))


def _median(signals: pd.DataFrame, names: list[str]) -> list[float]:
    """The median of each column, zero where it was not recorded."""
    recorded = signals.reindex(columns=names).median().to_numpy(dtype=float)
    return [float(value) for value in np.nan_to_num(recorded)]
