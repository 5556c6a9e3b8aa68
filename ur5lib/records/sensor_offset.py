"""Bias and tool of a force sensor."""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.timeseries.arrays import Array, Six


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Bias and tool of a force sensor, estimated from its reading without contact.

    bias: (6,) [N, Nm]; mass [kg]; moment_arm: mass times centre of mass, (3,) [kg m], sensor
    frame; *_std: their standard errors; mass and arm are NaN if the arm turned too little to
    separate weight from bias (the bias then contains both); noise: (6,), standard deviation of a
    sample without contact; agreeing: share of the samples that agree with this offset; rival:
    largest share of the others that agree on another offset. Values that need moments are NaN for
    a sensor without them.
    """

    bias: Array
    bias_std: Array
    mass: float
    mass_std: float
    moment_arm: Array
    moment_arm_std: Array
    noise: Array
    agreeing: float
    rival: float


@dataclass(frozen=True, kw_only=True)
class OffsetAccount(Offset):
    """What was subtracted from a force sensor's reading: bias, weight and inertial force of the
    tool.

    pull_at: (3,) [m], frame 6, the point at which the inertial force acts: the tool's centre of
    mass, or the sensor if that is unknown; clock_std: [s], error of the sensor's clock, over which
    this force is averaged; inertia: of the tool, xx yy zz xy xz yz [kg m²], None if neglected;
    free: share of the samples without contact; start_bias: (6,) [N, Nm], mean at the start; drift,
    drift_std: (3,) [N/min], of the forces' bias, and its standard error, NaN if unknown.
    """

    pull_at: Array
    clock_std: float
    inertia: Six | None
    free: float
    start_bias: Array
    drift: Array = field(default_factory=lambda: np.full(3, np.nan))
    drift_std: Array = field(default_factory=lambda: np.full(3, np.nan))
