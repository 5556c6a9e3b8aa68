"""The relation of a device's clock to the robot's, and the drift that a host's devices share."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

import numpy as np

from ur5lib.records.clocks import ClockRelation, HostDrift, OwnClock, SettledClock
from ur5lib.timeseries.arrays import Array

# Deviation of a clock from a straight line, which a jackknife within one recording cannot show.
CLOCK_WANDER = 0.004  # s
# Sources of a clock.
STAMPS_METHOD = "start stamps"
MOTION_METHOD = "angular rate"
HOST_METHOD = "host's stamps"
SHARED_METHOD = "robot's clock"


def clock_from_stamps(offset: float, std: float, drift_std: float | None = None) -> ClockRelation:
    """Return the clock of a device by start stamps that are `offset` [s] apart.

    drift_std: error of the clock's rate if the robot's host stamps the samples, 0 if the device
    shares the robot's clock, None if its drift is unknown.
    """
    if drift_std is None:
        return ClockRelation(offset, std, None, None, STAMPS_METHOD)
    return ClockRelation(offset, std, 0.0, drift_std, HOST_METHOD if drift_std else SHARED_METHOD)


def pool_drifts(
    clocks: Mapping[str, Mapping[str, OwnClock]], hosts: Mapping[str, Sequence[str]]
) -> dict[str, HostDrift]:
    """Return the drift and start of each host, from its clocks that were estimated by motion.

    clocks: by recording and device; hosts: the devices of each host. Hosts without such a clock are
    left out.
    """
    drifts = {}
    for host, devices in hosts.items():
        moved_clocks = {
            recording: devices_clocks[device]
            for recording, devices_clocks in clocks.items()
            for device in devices
            if device in devices_clocks and devices_clocks[device].method == MOTION_METHOD
        }
        if moved_clocks:
            names = ("drift", "drift_std", "offset", "offset_std", "stamps")
            drift, std, offset, offset_std, stamps = (
                np.array([getattr(clock, name) for clock in moved_clocks.values()])
                for name in names
            )
            # the error of the robot's own start stamp is common to all devices
            start = pool(offset - stamps, offset_std)
            drifts[host] = HostDrift(list(devices), *pool(drift, std), *start, list(moved_clocks))
    return drifts


def pool(value: Array, std: Array) -> tuple[float, float, float]:
    """Return mean, standard error and spread of K values, random effects (DerSimonian, Laird 1986).

    value, std: (K,), with their own standard errors. The spread is the standard deviation that
    these do not explain; of a single value, it is its standard error.
    """
    if len(value) == 1:
        return float(value[0]), float(std[0]), float(std[0])
    # spread² = (χ² - (K - 1)) / (Σ w - Σ w² / Σ w), w = 1 / std²
    weight = std**-2.0
    misfit = weight @ (value - np.average(value, weights=weight)) ** 2
    scale = weight.sum() - (weight**2).sum() / weight.sum()
    spread = float(np.sqrt(max(0.0, (misfit - len(value) + 1) / scale)))
    # mean with w = 1 / (std² + spread²)
    weight = 1 / (std**2 + spread**2)
    return float(np.average(value, weights=weight)), float(weight.sum() ** -0.5), spread


def settle_clocks(
    clocks: Mapping[str, OwnClock], drifts: Mapping[str, HostDrift], duration: float
) -> dict[str, SettledClock]:
    """Return the clocks of a recording's devices, by device.

    clocks: of each device, from its own start stamp or motion; drifts: of the hosts, by host;
    duration: of the recording [s]. A clock estimated by motion stays; one by start stamps takes the
    start and drift of its host if there are any.
    """
    settled = {}
    for device, clock in clocks.items():
        host = next((host for host in drifts.values() if device in host.devices), None)
        if host is not None and clock.method == STAMPS_METHOD:
            # errors of the mean, the spread between recordings, and the wander
            start = clock.offset_std, host.start_std_error, host.start_spread
            drift = host.std_error, host.spread, CLOCK_WANDER / duration
            clock = replace(
                clock,
                offset=clock.offset + host.start,
                offset_std=float(np.linalg.norm(start)),
                drift=host.drift,
                drift_std=float(np.linalg.norm(drift)),
                method=f"{clock.method}, start and drift of its host",
            )
        clock_fields = {field.name: getattr(clock, field.name) for field in fields(ClockRelation)}
        end_std = clock.std_after(duration)
        settled[device] = SettledClock(**clock_fields, warning=clock.warning, end_std=end_std)
    return settled
