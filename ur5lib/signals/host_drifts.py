"""What the clocks of all devices of one host share, from the recordings that tell it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from ur5lib.signals.clocks import BY_MOTION, WANDER, Clock
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class HostDrift:
    """How a host's clock runs against the robot's.

    devices: those on this host; drift: its mean over recordings, std_error: of that mean, spread:
    standard deviation from one recording to the next, all dimensionless; start, start_std_error,
    start_spread: the same of how much later a device's clock begins than start stamps say [s];
    recordings: names of those that tell.
    """

    devices: list[str]
    drift: float
    std_error: float
    spread: float
    start: float
    start_std_error: float
    start_spread: float
    recordings: list[str]


def pool_drifts(
    clocks: Mapping[str, Mapping[str, Any]], hosts: Mapping[str, Sequence[str]]
) -> dict[str, HostDrift]:
    """Each host's drift, from those of its devices' clocks that motion told.

    clocks: by recording and device, as in own_clocks.json; hosts: the devices of each host. A
    clock of start stamps tells no drift, and an IMU that felt another motion tells no clock. Hosts
    of which nothing is told are left out.
    """
    found = {}
    for host, devices in hosts.items():
        told = dict(_told(clocks, devices))
        if told:
            names = ("drift", "drift_std", "offset", "offset_std", "stamps")
            drift, std, offset, offset_std, stamps = (
                np.array([clock[name] for clock in told.values()]) for name in names
            )
            # The robot's own start stamp is off too, by what all devices of a host then share.
            start = pool(offset - stamps, offset_std)
            found[host] = HostDrift(list(devices), *pool(drift, std), *start, list(told))
    return found


def _told(
    clocks: Mapping[str, Mapping[str, Any]], devices: Sequence[str]
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Recordings in which motion told the clock of one of the devices, and that clock."""
    for recording, own in clocks.items():
        for device in devices:
            if device in own and own[device]["method"] == BY_MOTION:
                yield recording, own[device]


def pool(value: Array, std: Array) -> tuple[float, float, float]:
    """Mean, its standard error, and the spread of what K recordings tell (DerSimonian, Laird 1986).

    value, std: (K,), with their own standard errors. The spread is what the values differ beyond
    those; a single recording shows none, and its own error stands for it.
    """
    if len(value) == 1:
        return float(value[0]), float(std[0]), float(std[0])
    weight = std**-2.0
    misfit = weight @ (value - np.average(value, weights=weight)) ** 2
    scale = weight.sum() - (weight**2).sum() / weight.sum()
    spread = float(np.sqrt(max(0.0, (misfit - len(value) + 1) / scale)))
    weight = 1 / (std**2 + spread**2)
    return float(np.average(value, weights=weight)), float(weight.sum() ** -0.5), spread


def settle_clocks(
    own: Mapping[str, Mapping[str, Any]], drifts: Mapping[str, HostDrift], duration: float
) -> dict[str, dict[str, Any]]:
    """The clocks of a recording's devices, as in clocks.json.

    own: what each device's start stamp and motion tell, as in own_clocks.json; drifts: of the
    hosts; duration: of the recording [s]. A clock that motion told stays; one of start stamps
    takes the drift of its host where that is known. `end_std` is what it may be off at the end [s].
    """
    settled = {}
    for device, entry in own.items():
        clock = read_clock(entry)
        for host in drifts.values():
            if device in host.devices:
                clock = _with_drift(clock, host, duration)
        added = {"end_std": clock.end_std(duration), "warning": entry["warning"]}
        settled[device] = asdict(clock) | added
    return settled


def read_clock(entry: Mapping[str, Any]) -> Clock:
    """The clock of an entry of clocks.json or own_clocks.json."""
    return Clock(**{field.name: entry[field.name] for field in fields(Clock)})


def _with_drift(clock: Clock, host: HostDrift, duration: float) -> Clock:
    """A clock of start stamps with its host's start and drift; any other as it is.

    Those of this one recording are off by the mean's error, by the spread, and by the wander.
    """
    if clock.method == BY_MOTION:
        return clock
    std = float(np.hypot(np.hypot(host.std_error, host.spread), WANDER / duration))
    start = clock.offset_std, host.start_std_error, host.start_spread
    return replace(
        clock,
        offset=clock.offset + host.start,
        offset_std=float(np.linalg.norm(start)),
        drift=host.drift,
        drift_std=std,
        method=f"{clock.method}, start and drift of its host",
    )
