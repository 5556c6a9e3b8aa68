"""The payload of an arm: the actual one, and the one configured in its controller."""

from dataclasses import dataclass
from typing import Any, Literal

from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots import told
from ur5lib.robots.description import Payload


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
    given = told_payload(signals)
    if declared is not None:
        return Carried(declared, "study", given)
    return Carried(given, "none" if given is None else "rtde", given)


def told_payload(signals: Signals) -> Payload | None:
    """Return the payload that the controller was given; None where there is or was none."""
    return told.told_payload(signals.payload, signals.payload_cog, signals.payload_inertia)


def load_account(load: Carried) -> dict[str, Any]:
    """Return the payload, its source, and the controller's payload, as plain data."""
    payloads = {"payload": load.payload, "told": load.told}
    plain = {name: payload and payload.model_dump() for name, payload in payloads.items()}
    return plain | {"source": load.source}
