"""What a force sensor shows of the estimates, and of itself."""

from dataclasses import dataclass, field

from ur5lib.errors import Remark
from ur5lib.force.contact_figures import ContactErrors
from ur5lib.force.detection import Felt
from ur5lib.force.sensor import Offset
from ur5lib.robots.description import Six
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True, kw_only=True)
class OffsetAccount(Offset):
    """What was subtracted from a force sensor's reading.

    pull_at: (3,) [m], the point of frame 6 whose acceleration pulls on the tool: its centre of
    mass, the sensor where that is unknown; clock_std: [s], error of the sensor's clock, over which
    this pull is averaged; inertia: of the tool, xx yy zz xy xz yz [kg m²], None where it was
    neglected; free: share of the samples that are free of contact; start_bias: (6,) [N, Nm], mean
    at the start.
    """

    pull_at: Array
    clock_std: float
    inertia: Six | None
    free: float
    start_bias: Array


Figures = dict[str, dict[str, float]]  # by name, then by component
ByPeriod = dict[str, Figures]  # in contact, free and all


@dataclass(frozen=True, kw_only=True)
class Compared:
    """Every estimate of the contact wrench beside the force sensor.

    std: median standard deviation by estimate and component; errors: by kind of reference,
    estimate and period; contacts: errors of each contact by estimate; felt: what the sensor felt;
    offset_doubt: why its bias may be a push; mounting_doubt: why its mounting may be wrong.
    """

    force_sensor: bool = False
    share_near_singularity: float = float("nan")
    std: Figures = field(default_factory=dict)
    offset: OffsetAccount | None = None
    offset_doubt: Remark | None = None
    mounting_doubt: Remark | None = None
    felt: Felt | None = None
    errors: dict[str, dict[str, ByPeriod]] = field(default_factory=dict)
    contacts: dict[str, list[ContactErrors]] = field(default_factory=dict)


@dataclass(frozen=True)
class AuditRow:
    """A value in the audit of a wrist's force sensor, with its 95 % interval from low to high.

    verdict: unknown, wrong or right, as by `ur5lib.steps.judge_audit.row`; empty without an
    expected value.
    """

    quantity: str
    component: str
    value: float
    std_error: float
    low: float
    high: float
    unit: str
    expected: float | None
    verdict: str


@dataclass(frozen=True)
class Audit:
    """What is wrong with the force sensor in an arm's wrist.

    free_s: contact-free time [s], None where there is nothing to audit.
    """

    free_s: float | None = None
    rows: list[AuditRow] = field(default_factory=list)
