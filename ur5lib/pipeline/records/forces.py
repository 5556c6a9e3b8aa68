"""Estimates of the contact wrench, the force sensor's wrenches, and both compared."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ur5lib.errors import Remark
from ur5lib.force.contact_figures import ContactErrors
from ur5lib.force.detection import Felt
from ur5lib.pipeline.estimators import GATED, NEW, PUBLISHED, Stated
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.table import JOINTS, WRENCH, SegmentedTable, channel, channels
from ur5lib.timeseries.arrays import Array, Float

REFERENCES = ("printed", "corrected", "compensated")


@dataclass(frozen=True, kw_only=True)
class Forces(SegmentedTable):
    """Contact wrenches from currents: the environment acting on the arm, base axes, frame 6's
    origin, (N, 6) [N, Nm].

    wrench and std, its standard deviation, by estimate; log_odds: that there is a contact, (N,),
    given all samples; causal_log_odds: given each sample and those before it; background:
    (N, 6) [Nm], slow external torque that is no contact.
    """

    wrench: dict[str, Array] = channels("{}", "N, Nm", WRENCH, tuple(NEW))
    std: dict[str, Array] = channels("{}_std", "N, Nm", WRENCH, tuple(NEW))
    log_odds: dict[str, Array] = channels("log_odds_{}", "1", (), tuple(GATED))
    causal_log_odds: Array | None = channel("causal_log_odds", "1", optional=True)
    background: Array | None = channel("tau_background", "Nm", JOINTS, optional=True)

    @classmethod
    def of(
        cls,
        motion: Motion,
        estimates: Mapping[str, Stated | None],
        background: Array | None,
        causal: Array | None,
    ) -> "Forces":
        """Return estimates by name, at the times of a motion; causal: `causal_log_odds`."""
        known = {name: one for name, one in estimates.items() if one is not None}
        odds = {name: one.log_odds for name, one in known.items()}
        return cls(
            time=motion.time,
            segment=motion.segment,
            wrench={name: one.wrench for name, one in known.items()},
            std={name: one.std for name, one in known.items()},
            log_odds={name: own for name, own in odds.items() if own is not None},
            background=background,
            causal_log_odds=causal,
        )


@dataclass(frozen=True, kw_only=True)
class PublishedForces(SegmentedTable):
    """The thesis's estimates Fu, F and F*, (N, 6) [N, Nm]: as its script printed them, and by its
    equations put right; the environment acting on the arm, base axes.
    """

    printed: dict[str, Array] = channels("printed_{}", "N, Nm", WRENCH, tuple(PUBLISHED))
    corrected: dict[str, Array] = channels("corrected_{}", "N, Nm", WRENCH, tuple(PUBLISHED))


@dataclass(frozen=True, kw_only=True)
class SensorWrenches(SegmentedTable):
    """The force sensor's wrench, (N, 6) [N, Nm], the environment acting on the arm, base axes.

    printed: the raw reading; corrected: less its mean at the start, both placed by start stamps;
    compensated: by the best clock, less bias and tool weight; the last two at frame 6's origin.
    """

    wrench: dict[str, Array] = channels("{}", "N, Nm", WRENCH, REFERENCES)


@dataclass(frozen=True, kw_only=True)
class OffsetAccount:
    """What was subtracted from a force sensor's reading, as in `ur5lib.force.sensor.SensorOffset`.

    free: share of the samples that are free of contact; start_bias: (6,) [N, Nm], mean at the
    start.
    """

    bias: Array
    bias_std: Array
    mass: Float
    mass_std: Float
    moment_arm: Array
    moment_arm_std: Array
    noise: Array
    free: float
    agreeing: float
    rival: float
    start_bias: Array


Figures = dict[str, dict[str, Float]]  # by name, then by component
ByPeriod = dict[str, Figures]  # in contact, free and all


@dataclass(frozen=True, kw_only=True)
class Compared:
    """forces.json: every estimate of the contact wrench beside the force sensor.

    std: median standard deviation by estimate and component; errors: by kind of reference,
    estimate and period; contacts: errors of each contact by estimate; felt: what the sensor felt;
    offset_doubt: why its bias may be a push; mounting_doubt: why its mounting may be wrong.
    """

    force_sensor: bool = False
    share_near_singularity: Float = float("nan")
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

    verdict: unknown, wrong or right, as by `ur5lib.pipeline.sensor_audit.row`; empty without an
    expected value.
    """

    quantity: str
    component: str
    value: Float
    std_error: Float
    low: Float
    high: Float
    unit: str
    expected: float | None
    verdict: str


@dataclass(frozen=True)
class Audit:
    """audit.json: what is wrong with the force sensor in an arm's wrist.

    free_s: contact-free time [s], None where there is nothing to audit.
    """

    free_s: float | None = None
    rows: list[AuditRow] = field(default_factory=list)


@dataclass(frozen=True)
class Ablated:
    """Errors of an estimate of the force in contact, (3,) each, in ablation.json by variant."""

    mae: Array
    coverage95: Array
    interval_score95: Array
