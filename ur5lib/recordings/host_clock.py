"""Sensors placed on the robot's clock by the stamps of the computer that recorded all devices.

A stamp is made when a sample arrives: late by a delay that varies and is rarely zero. So the
relation of two clocks is the line below the stamps, through those that were hardly delayed.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ur5lib.recordings.coverage import Span, robot_coverage
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.timeseries.arrays import Array

COUNTER = "counter"  # column of a sensor's own count of its samples
BLOCK, BLOCKS = 1.0, 8  # s; in each, the least delayed sample counts; so many at least
SHORT, TINY = 4.0, 1e-3  # s; what is shorter determines no drift; what is tiny came at once
DELAY = 0.0005  # s, standard uncertainty of the least delay of a device
FEWEST, SHORT_STD = 4, 1e-3  # blocks that determine a line; error of a rate that nothing tells


@dataclass(frozen=True)
class Line:
    """host = offset + slope * own [s]; slope_std: its standard error."""

    offset: float
    slope: float
    slope_std: float

    def host(self, own: Array) -> Array:
        """Return the host's time (N,) [s] at times or counts of the device (N,)."""
        return self.offset + self.slope * own

    def own(self, host: Array) -> Array:
        """Return the device's time (N,) at times of the host (N,) [s]."""
        return (host - self.offset) / self.slope


def least_delayed(own: Array, host: Array, nominal: float | None = None) -> Line:
    """Return the line below the stamps: of the least delayed sample of each block.

    own: (N,) time [s] or count of the device, increasing; host: (N,) [s], stamps at arrival;
    nominal: slope of a record that is too short to tell, None for that of all its samples.
    Residuals of a line through all samples tell the delays up to a constant; the samples with
    the least of each block are fitted by least squares.
    """
    elapsed, since = own - own[0], host - host[0]
    known = nominal if since[-1] <= SHORT else None
    slope = float(np.polyfit(elapsed, since, 1)[0]) if known is None else known
    delay = since - slope * elapsed
    block = np.floor(since / max(min(BLOCK, since[-1] / BLOCKS), TINY))
    best = pd.Series(delay).groupby(block).idxmin().to_numpy()
    if len(best) < FEWEST or known is not None:
        return Line(float(host[0] + delay.min() - slope * own[0]), slope, SHORT_STD)
    (slope, offset), covariance = np.polyfit(elapsed[best], since[best], 1, cov="unscaled")
    spread = np.std(since[best] - offset - slope * elapsed[best], ddof=2)
    std = float(spread * np.sqrt(covariance[0, 0]))
    return Line(float(host[0] + offset - slope * own[0]), float(slope), std)


def without_delays(table: pd.DataFrame) -> pd.DataFrame:
    """Return a sensor's table without the delays in its `time`, if it counts its samples.

    `counter`: the sensor's own count, which is left out. A count that does not increase throughout
    tells nothing.
    """
    if COUNTER not in table:
        return table
    count, stamped = table[COUNTER].to_numpy(), table.drop(columns=COUNTER)
    known = np.isfinite(count) & np.isfinite(stamped["time"].to_numpy())
    if known.sum() < 2 or (np.diff(count[known]) <= 0).any():
        return stamped
    line = least_delayed(count[known], stamped["time"].to_numpy()[known])
    return stamped.assign(time=line.host(count))


def on_robot_clock(raw: RawRecording) -> RawRecording:
    """Return a recording whose sensors with stamps of the robot's host are on the robot's clock.

    The robot's table has its stamps as `received`, a sensor's are its `time`.
    """
    table, start = raw.robot.table, raw.robot.start
    sensors = {name: one for name, one in raw.sensors.items() if on_host(one)}
    if not sensors or "received" not in table or start is None:
        return raw
    stamped = table[["time", "received"]].dropna()
    if len(stamped) < FEWEST:
        return raw
    own, host = stamped["time"].to_numpy(), stamped["received"].to_numpy()
    line = least_delayed(own, host, nominal=1.0)
    placed = {name: _placed(one, line, start) for name, one in sensors.items()}
    spans = [_span(one) for one in placed.values()]
    together = min(begin for begin, _ in spans), max(end for _, end in spans)
    findings = robot_coverage(_span(raw.robot), together)
    return replace(raw, sensors=raw.sensors | placed, findings=raw.findings + findings)


def on_host(sensor: DeviceRecord) -> bool:
    """Return whether a sensor's stamps are those of the robot's host."""
    return sensor.start is not None and sensor.start.since == "host_s"


def _span(device: DeviceRecord) -> Span:
    """Return when a device with a start stamp recorded its first and its last sample [s]."""
    assert device.start is not None
    time = device.table["time"]
    return device.start.seconds + float(time.min()), device.start.seconds + float(time.max())


def _placed(sensor: DeviceRecord, robot: Line, start: Stamp) -> DeviceRecord:
    """Return a sensor's record with times of the robot's clock."""
    assert sensor.start is not None
    host = sensor.start.seconds + sensor.table["time"].to_numpy()
    time = robot.own(host)
    table = sensor.table.assign(time=time - time[0])
    stamp = Stamp(start.seconds + float(time[0]), DELAY, start.since, robot.slope_std)
    return replace(sensor, table=table, start=stamp)
