"""Sensors placed on the robot's clock by the stamps of the computer that recorded all devices.

A stamp is made when a sample arrives: late by a delay that varies and is rarely zero. So the
relation of two clocks is the line below the stamps, through those with almost no delay. The least
delay of a device, about half of the least round trip to it, does not show in its stamps.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import scipy  # loads scipy.spatial at its first use

from ur5lib.recordings.plausibility import before_reset
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.starts import Span, robot_coverage
from ur5lib.timeseries.arrays import Array

COUNTER = "counter"  # column of a sensor's own count of its samples
MIN_DRIFT_TIME = 4.0  # s; a shorter recording of the robot determines no drift
STAMP_RESOLUTION = 1e-6  # s, of stamps
ERROR_RANK = 5  # rank of the residual that serves as the error of a half
MIN_ROUND_TRIP = 0.002  # s, the least one to a device, assumed because stamps do not show it
# In s: least delays of two devices differ by half of the round trip to either side, at most.
DELAY_STD = MIN_ROUND_TRIP / 2 / np.sqrt(3)  # evenly distributed
MIN_STAMPS = 4  # stamps that determine a line
UNDETERMINED_RATE_STD = 1e-3  # default standard error of an undetermined rate


@dataclass(frozen=True)
class Line:
    """The relation of a device's clock or count to its host's time, host = offset + slope * own
    [s]; slope_std: standard error of the slope.
    """

    offset: float
    slope: float
    slope_std: float

    def host(self, device: Array) -> Array:
        """Return the host's time (N,) [s] at times or counts of the device (N,)."""
        return self.offset + self.slope * device

    def own(self, host: Array) -> Array:
        """Return the device's time or count (N,) at times of the host (N,) [s]."""
        return (host - self.offset) / self.slope


def least_delayed(device: Array, host: Array, nominal: float | None = None) -> Line:
    """Return the line below the stamps that leaves the least mean delay.

    device: (N,) time [s] or count of the device, increasing; host: (N,) [s], stamps at arrival;
    nominal: slope assumed if the record is too short to determine one, None to fit it anyway. No
    delay is negative, so the best line is a linear program; its solution is the edge of the lower
    convex hull of the stamps under their mean (S. B. Moon, P. Skelly, D. Towsley: Estimation and
    removal of clock skew from network delay measurements, INFOCOM 1999). Samples with almost no
    delay determine it, however late and however many the others are.
    """
    elapsed, since = device - device[0], host - host[0]
    if nominal is not None and since[-1] <= MIN_DRIFT_TIME:
        offset = float((since - nominal * elapsed).min())
        return Line(float(host[0] + offset - nominal * device[0]), nominal, UNDETERMINED_RATE_STD)
    trend = float(np.polyfit(elapsed, since, 1)[0])
    delay = since - trend * elapsed  # up to a constant, and small, so that the hull is exact
    first, last = _edge_below(elapsed, delay)
    steeper = float((delay[last] - delay[first]) / (elapsed[last] - elapsed[first]))
    offset = float(delay[first] - steeper * elapsed[first])
    std = _slope_std(elapsed, delay - offset - steeper * elapsed)
    slope = trend + steeper
    return Line(float(host[0] + offset - slope * device[0]), slope, std)


def _edge_below(elapsed: Array, delay: Array) -> tuple[int, int]:
    """Return the numbers of the two samples between which the lower convex hull passes under the
    mean time.
    """
    height = max(float(np.ptp(delay)), STAMP_RESOLUTION)
    stamps = np.column_stack([elapsed / elapsed[-1], (delay - delay.min()) / height])
    above = [[0.0, 2.0], [1.0, 2.0]]  # above all stamps, so that no hull is flat
    ends = scipy.spatial.ConvexHull(np.vstack([stamps, above])).simplices
    ends = ends[(ends < len(stamps)).all(axis=1)]
    ends = np.take_along_axis(ends, elapsed[ends].argsort(axis=1), axis=1)
    begin, end = elapsed[ends].T
    mean = elapsed.mean()
    first, last = ends[np.flatnonzero((begin < mean) & (mean <= end))[0]].tolist()
    return first, last


def _slope_std(elapsed: Array, delay: Array) -> float:
    """Return the standard error of the slope, by the next least delays of each half, which could
    shift it.
    """
    early = elapsed < elapsed.mean()
    halves = delay[early], delay[~early]
    if min(map(len, halves)) <= ERROR_RANK:
        return UNDETERMINED_RATE_STD
    room, other = (float(np.partition(half, ERROR_RANK)[ERROR_RANK]) for half in halves)
    return max(float(np.hypot(room, other)), STAMP_RESOLUTION) / float(elapsed[-1] / 2)


def without_delays(table: pd.DataFrame) -> pd.DataFrame:
    """Return a sensor's table with delays removed from its `time`, if it counts its samples.

    The column `counter`, the sensor's own count, is dropped. A count that does not increase
    throughout is not used.
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
    """Return a recording with its sensors on the robot's clock, as far as they have stamps of the
    robot's host.

    The robot's table has the host's stamps as `received`, a sensor's has them as its `time`.
    """
    table, start = raw.robot.table, raw.robot.start
    sensors = {n: s for n, s in raw.sensors.items() if s.start and s.start.since == "host_s"}
    if not sensors or "received" not in table or start is None:
        return raw
    stamped = table.loc[before_reset(table["time"].to_numpy()), ["time", "received"]].dropna()
    if len(stamped) < MIN_STAMPS:
        return raw
    own, host = stamped["time"].to_numpy(), stamped["received"].to_numpy()
    line = least_delayed(own, host, nominal=1.0)
    placed = {name: _placed(one, line, start) for name, one in sensors.items()}
    spans = [_span(one) for one in placed.values()]
    together = min(begin for begin, _ in spans), max(end for _, end in spans)
    findings = robot_coverage(_span(raw.robot), together)
    return replace(raw, sensors=raw.sensors | placed, findings=raw.findings + findings)


def _span(device: DeviceRecord) -> Span:
    """Return when a device with a start stamp recorded its first and its last sample [s]."""
    assert device.start is not None
    time = device.table["time"]
    return device.start.seconds + float(time.min()), device.start.seconds + float(time.max())


def _placed(sensor: DeviceRecord, robot: Line, start: Stamp) -> DeviceRecord:
    """Return a sensor's record with its times by the robot's clock; robot, start: the robot's line
    and start stamp.
    """
    assert sensor.start is not None
    host = sensor.start.seconds + sensor.table["time"].to_numpy()
    time = robot.own(host)
    table = sensor.table.assign(time=time - time[0])
    stamp = Stamp(start.seconds + float(time[0]), DELAY_STD, start.since, robot.slope_std)
    return replace(sensor, table=table, start=stamp)
