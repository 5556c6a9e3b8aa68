"""The payload of an arm: the actual one, and the one configured in its controller."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class Carried:
    """The payload on the flange, its source, and the one configured in the controller.

    Currents contain the torque of `payload`, `target_moment` that of `told`. None: no payload.
    """

    payload: Payload | None
    source: Literal["study", "rtde", "none"]
    told: Payload | None


def carried(declared: Payload | None, signals: Signals) -> Carried:
    """Return the payload of a recording's arm: from the study, else from RTDE's channels."""
    told = told_payload(signals)
    if declared is not None:
        return Carried(declared, "study", told)
    return Carried(told, "none" if told is None else "rtde", told)


def told_payload(signals: Signals) -> Payload | None:
    """Return the payload that the controller was given, the medians of RTDE's channels.

    Centre of mass and inertia are zero where they were not recorded. None where no mass was
    recorded, or none is carried.
    """
    if signals.payload is None:
        return None
    (mass,) = _medians(signals.payload[:, None], 1)
    if mass <= 0:
        return None
    return Payload(
        mass=mass,
        center_of_mass=_medians(signals.payload_cog, 3),
        inertia=_medians(signals.payload_inertia, 6),
    )


def _medians(values: Array | None, count: int) -> Any:
    """Return the median of each of some columns, zero where it was not recorded."""
    if values is None or not np.isfinite(values).any():
        return (0.0,) * count
    return tuple(np.nan_to_num(np.nanmedian(values, axis=0)).tolist())


def load_account(load: Carried) -> dict[str, Any]:
    """Return the payload, its source, and the controller's payload, as plain data."""
    payloads = {"payload": load.payload, "told": load.told}
    plain = {name: payload and payload.model_dump() for name, payload in payloads.items()}
    return plain | {"source": load.source}
