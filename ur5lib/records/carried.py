"""The payload of an arm: the actual one, and the one configured in its controller."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ur5lib.records.codes import Found
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import Finding
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array, Six

# Differences that matter: 0.05 kg changes the gravity torque of a long arm by 0.5 Nm.
MASS, MOMENT = 0.05, 0.005  # kg, kg m
PLACE, TURN = 0.005, 0.01  # m, rad


@dataclass(frozen=True)
class Carried:
    """The payload on the flange during a recording, its source, and the payload that the controller
    assumes.

    Currents contain the torque of `payload`, `target_moment` that of `configured`; None: no load.
    """

    payload: Payload | None
    source: Literal["study", "rtde", "none"]
    configured: Payload | None

    @property
    def mass(self) -> float:
        """Return the mass of the payload [kg], zero without one."""
        return self.payload.mass if self.payload else 0.0


def carried(declared: Payload | None, signals: Signals) -> Carried:
    """Return the payload of a recording's arm: from the study, else from RTDE's channels."""
    configured = configured_payload(signals)
    if declared is not None:
        return Carried(declared, "study", configured)
    return Carried(configured, "none" if configured is None else "rtde", configured)


def configured_payload(signals: Signals) -> Payload | None:
    """Return the payload configured in the controller, the medians of RTDE's channels.

    Centre of mass and inertia are zero if they were not recorded. None if no mass was recorded, or
    if it is zero.
    """
    if signals.payload is None:
        return None
    (mass,) = medians(signals.payload[:, None], 1)
    if mass <= 0:
        return None
    return Payload(
        mass=mass,
        center_of_mass=medians(signals.payload_cog, 3),
        inertia=medians(signals.payload_inertia, 6),
    )


def medians(values: Array | None, count: int) -> Any:
    """Return the medians (count,) of columns (N, count), or zeros if they were not recorded."""
    if values is None or not np.isfinite(values).any():
        return (0.0,) * count
    return tuple(np.nan_to_num(np.nanmedian(values, axis=0)).tolist())


def disagreements(declared: Payload | None, tcp: Six | None, signals: Signals) -> list[Finding]:
    """Return findings where the study's payload and tool centre point differ from the controller's.

    declared, tcp: of the study, None if undeclared; tcp: position [m] and rotation vector [rad] in
    frame 6. Quantities that were not recorded are not compared.
    """
    found = {
        Found.PAYLOAD: _other_payload(declared, signals),
        Found.CHANGING_PAYLOAD: _changing_payload(signals),
        Found.TOOL_CENTRE_POINT: _other_tcp(tcp, signals),
    }
    return [Finding("robot", code, "warning", 1, its) for code, its in found.items() if its]


def _other_payload(declared: Payload | None, signals: Signals) -> str:
    if declared is None or signals.payload is None:
        return ""
    known = configured_payload(signals)
    apart = declared.mass - (known.mass if known else 0.0)
    away = np.subtract(declared.center_of_mass, known.center_of_mass if known else 0.0)
    if abs(apart) <= MASS and (known is None or np.linalg.norm(away) * declared.mass <= MOMENT):
        return ""
    return (
        f"the study declares {_in_words(declared)}, but {_in_words(known)} is configured at the "
        "controller; the declared payload is used for the currents, the configured one for "
        "`target_moment`"
    )


def _in_words(payload: Payload | None) -> str:
    if payload is None:
        return "no payload"
    return f"{number(payload.mass, '.3g')} kg at ({as_written(payload.center_of_mass, '.3g')}) m"


def _changing_payload(signals: Signals) -> str:
    if (
        signals.payload is None
        or np.ptp(mass := signals.payload[np.isfinite(signals.payload)]) == 0
    ):
        return ""
    return (
        f"the payload configured at the controller changes from {number(mass.min(), '.3g')} to "
        f"{number(mass.max(), '.3g')} kg in the recording; its median is used throughout: cut the "
        "recording where it changes"
    )


def _other_tcp(tcp: Six | None, signals: Signals) -> str:
    if tcp is None or signals.tcp_offset is None:
        return ""
    configured = np.array(medians(signals.tcp_offset, 6))
    apart = np.abs(np.array(tcp) - configured)
    if apart[:3].max() <= PLACE and apart[3:].max() <= TURN:
        return ""
    return (
        f"the study declares [{as_written(tcp, 'g')}] (m, rad), but "
        f"[{as_written(configured, '.4g')}] is configured at the controller; correct the study, or "
        "the installation of the arm"
    )
