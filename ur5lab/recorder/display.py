"""The display during a recording, and its warnings."""

from collections.abc import Iterator, Mapping

import numpy as np
from rich.table import Table

from ur5lab.recorder.arm_state import SAFE_MODES
from ur5lab.recorder.capture import Status
from ur5lab.recorder.device import Identity
from ur5lab.recorder.net_ft import SATURATION_BIT
from ur5lab.rtde_variables import SafetyMode

MAX_LOST_SHARE = 0.001  # share of samples that may be lost
MIN_RATE_SHARE = 0.9  # least share of a device's nominal rate
RATE_SETTLING_TIME = 2.0  # s; rates are judged after this time
MIN_TURN_FOR_FRICTION = 0.5  # rad; least motion that identifies a joint's friction


def table(statuses: Mapping[str, Status]) -> Table:
    """Return a table with one row per device: samples, rate, losses, reading."""
    lines = Table("device", "samples", "rate [Hz]", "lost", "reads")
    for name, status in statuses.items():
        state = status.ended or reading(status.latest)
        lines.add_row(name, str(status.samples), f"{status.rate():.1f}", str(status.lost), state)
    return lines


def reading(latest: Mapping[str, float]) -> str:
    """Return a sample as one line of text: forces, specific force, or joints and temperature."""
    for first, label, unit in (("ft_fx", "force", "N"), ("imu_ax", "specific force", "m/s²")):
        if first in latest:
            size = np.linalg.norm([latest[f"{first[:-1]}{axis}"] for axis in "xyz"])
            return f"{label} {size:.1f} {unit}"
    if "actual_q_0" not in latest:
        return ""
    joints = " ".join(f"{latest[f'actual_q_{joint}']:.2f}" for joint in range(6))
    warm = [value for name, value in latest.items() if name.startswith("joint_temperatures")]
    return f"q {joints} rad" + (f", {max(warm):.0f} °C" if warm else "")


def warnings(statuses: Mapping[str, Status], identities: Mapping[str, Identity]) -> Iterator[str]:
    """Yield warnings on the devices, one sentence each; the words do not change while the cause
    lasts.
    """
    for name, status in statuses.items():
        if status.ended:
            yield f"{name} has ended: {status.ended}; the others go on"
        elif status.lost > MAX_LOST_SHARE * (status.samples + status.lost):
            yield f"{name} loses samples: check the network and what else the computer does"
        nominal = identities[name].rate_hz
        is_settled = status.seconds > RATE_SETTLING_TIME
        if nominal and is_settled and status.rate() < MIN_RATE_SHARE * nominal:
            yield f"{name} sends fewer than its {nominal:g} samples a second: check its cable"
        if int(status.latest.get("status", 0)) & SATURATION_BIT:
            yield f"{name} is saturated: its force is beyond its range"
        if int(status.latest.get("safety_mode", SafetyMode.NORMAL)) not in SAFE_MODES:
            yield "the arm is in a safety stop: look at its pendant"


def unmoved(status: Status) -> list[int]:
    """Return the joints, 1 to 6, that turned too little to identify their friction."""
    names = [f"actual_q_{joint}" for joint in range(6)]
    if not all(name in status.high for name in names):
        return []
    turns = [status.high[name] - status.low[name] for name in names]
    return [joint for joint, turn in enumerate(turns, 1) if turn < MIN_TURN_FOR_FRICTION]
