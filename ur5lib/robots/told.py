"""The payload that the controller was given, from RTDE's channels."""

from typing import Any

import numpy as np

from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array


def told_payload(mass: Array | None, center: Array | None, inertia: Array | None) -> Payload | None:
    """Return the medians of the channels `payload`, `payload_cog` and `payload_inertia`.

    mass: (N,) [kg]; center: (N, 3) [m], inertia: (N, 6) [kg m²], frame 6; zero where they were not
    recorded. None where no mass was recorded, or none is carried.
    """
    if mass is None:
        return None
    (weight,) = _medians(mass[:, None], 1)
    if weight <= 0:
        return None
    return Payload(mass=weight, center_of_mass=_medians(center, 3), inertia=_medians(inertia, 6))


def _medians(values: Array | None, count: int) -> Any:
    """Return the median of each of some columns, zero where it was not recorded."""
    if values is None or not np.isfinite(values).any():
        return (0.0,) * count
    return tuple(np.nan_to_num(np.nanmedian(values, axis=0)).tolist())
