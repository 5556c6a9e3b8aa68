"""What a force sensor shows of the estimates, and of itself."""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.errors import Remark
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array, Six

WHOLE = "norm"  # the component of all three axes together


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Bias and tool of a force sensor, as its reading without contact shows them.

    bias: (6,) [N, Nm]; mass [kg]; moment_arm: mass times centre of mass, (3,) [kg m], sensor
    frame; *_std: their standard errors; mass and arm are NaN if the arm turned too little to
    separate weight from bias (the bias then contains both); noise: (6,), standard deviation of a
    free sample; agreeing: share of the samples that agree with this offset; rival: largest share
    of the others that agree on another offset. Of a sensor without moments, what needs them is NaN.
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


@dataclass(frozen=True)
class ContactErrors:
    """Peak, impulse and onset of a contact at the sensor, and the estimate's errors.

    component: an axis, or "norm" for all three; peak: the largest force [N]; impulse: the magnitude
    of the force's integral [N s]; errors: the estimate's component along the sensor's direction
    minus the sensor's value, negative if the estimate is too small, NaN if it is unknown or the
    sensor saturated in part of the contact; onset_error_s: of all three, delay with which the
    estimate passes the sensor's levels; mae: of all three, mean over the axes [N], of which
    mae_shut while no alarm is raised, and mae_gain that another gain of the whole recording would
    take off.
    """

    contact: int
    start_s: float
    end_s: float
    component: str
    peak: float
    peak_error: float
    impulse: float
    impulse_error: float
    onset_error_s: float | None = None
    mae: float | None = None
    mae_shut: float | None = None
    mae_gain: float | None = None


@dataclass(frozen=True)
class Felt:
    """What a force sensor reads: largest [N], at_s: the time of the largest force [s]; contact: the
    share of the recording in contact; contacts: their number.
    """

    largest: float
    at_s: float
    contact: float
    contacts: int


@dataclass(frozen=True, kw_only=True)
class OffsetAccount(Offset):
    """What was subtracted from a force sensor's reading.

    pull_at: (3,) [m], the point of frame 6 whose acceleration pulls on the tool: its centre of
    mass, the sensor where that is unknown; clock_std: [s], error of the sensor's clock, over which
    this pull is averaged; inertia: of the tool, xx yy zz xy xz yz [kg m²], None where it was
    neglected; free: share of the samples that are free of contact; start_bias: (6,) [N, Nm], mean
    at the start; drift: (3,) [N/min], of the bias of the forces, and drift_std, its standard error,
    NaN where they are unknown.
    """

    pull_at: Array
    clock_std: float
    inertia: Six | None
    free: float
    start_bias: Array
    drift: Array = field(default_factory=lambda: np.full(3, np.nan))
    drift_std: Array = field(default_factory=lambda: np.full(3, np.nan))


Figures = dict[str, dict[str, float]]  # by name, then by component
ByPeriod = dict[str, Figures]  # in contact, free and all


@dataclass(frozen=True, kw_only=True)
class Compared:
    """beside_sensor.json: every estimate of the contact wrench beside the force sensor; empty
    without one.

    errors: by kind of reference, estimate and period; contacts: errors of each contact by estimate;
    felt: what the sensor felt; offset_doubt: why its bias may be a push; mounting_doubt: why its
    mounting may be wrong.
    """

    offset: OffsetAccount | None = None
    offset_doubt: Remark | None = None
    mounting_doubt: Remark | None = None
    felt: Felt | None = None
    errors: dict[str, dict[str, ByPeriod]] = field(default_factory=dict)
    contacts: dict[str, list[ContactErrors]] = field(default_factory=dict)

    def findings(self) -> list[Finding]:
        """Return why the sensor's mounting and bias may be wrong."""
        found = []
        if self.mounting_doubt is not None:
            detail = self.mounting_doubt.text
            found.append(Finding("force", "mounting", "warning", 1, detail))
        if self.offset_doubt is not None:
            detail = (
                f"{self.offset_doubt.text}: a steady push may have been taken for bias; "
                "record some seconds in which nothing touches the tool"
            )
            found.append(Finding("force", "offset", "warning", 1, detail))
        return found
