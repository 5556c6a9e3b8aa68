"""The estimates' errors against a force sensor, and the sensor's own readings."""

from dataclasses import dataclass, field

from ur5lib.errors import Remark
from ur5lib.records.codes import Found
from ur5lib.records.contacts import ContactError
from ur5lib.records.quality import Finding
from ur5lib.records.sensor_offset import OffsetAccount
from ur5lib.records.verdicts import Reason, Use


@dataclass(frozen=True, kw_only=True)
class ForceError:
    """A row of force_mae.csv: the error of one component of an estimate of the contact wrench
    against the force sensor [N, Nm].

    kind: of the sensor's wrench, see `SensorWrenches`, compensated without bias and tool; during:
    all samples, contact (above 5 N at the sensor), free (below 1 N, 0.5 s away from 3 N), missed
    (contacts in which the estimate is zero throughout), none of them where the sensor is saturated;
    mae, max: mean absolute and largest error, with those of an estimate of zero; slope: estimate
    over sensor, empty for a mean force below 1 N or moment below 0.1 Nm; skill: 1 - mae / zero's;
    coverage50 to coverage95: shares in its bands, in missed contacts of the time in a band that is
    valid only if nothing touches the arm; width95: mean width of the 95 % band; interval_score95:
    its width and 40 times what lies outside; zero_interval_score95: the same of zero with the even
    width that contains 95 % of these readings; even_interval_score95: of this estimate with that
    which contains 95 % of the free ones; band_factor95: multiple of this band that contains 95 %;
    zero_in_band95: share of the time in which it contains zero on all axes; mae_missed, mae_shut,
    mae_gain: parts of `mae` by missed contacts, late alarms and another gain; mae_low, mae_high:
    its 95 % interval; skill_low: lower end of the skill's; determined: whether the skill in contact
    is above zero; use, reason: whether an error of a force in contact may be relied on, and why
    not, or with which doubt.
    """

    kind: str
    estimate: str
    during: str
    component: str
    mae: float | None = None
    max: float | None = None
    zero_mae: float | None = None
    zero_max: float | None = None
    mean_force: float | None = None
    slope: float | None = None
    skill: float | None = None
    correlation: float | None = None
    coverage50: float | None = None
    coverage80: float | None = None
    coverage95: float | None = None
    interval_score95: float | None = None
    zero_interval_score95: float | None = None
    even_interval_score95: float | None = None
    width95: float | None = None
    band_factor95: float | None = None
    zero_in_band95: float | None = None
    mae_missed: float | None = None
    mae_shut: float | None = None
    mae_gain: float | None = None
    mae_low: float | None = None
    mae_high: float | None = None
    skill_low: float | None = None
    determined: bool | None = None
    use: Use | None = None
    reason: Reason = ""


@dataclass(frozen=True, kw_only=True)
class Sensed:
    """A row of sensed.csv: what a force sensor reads.

    largest_force_n: [N], at_s: its time [s]; share_in_contact: of the recording; contacts: their
    number; bias, drift: without contact, x, y, z [N, N/min], with standard errors.
    """

    largest_force_n: float
    at_s: float
    share_in_contact: float
    contacts: int
    bias_x: float | None = None
    bias_y: float | None = None
    bias_z: float | None = None
    bias_std_x: float | None = None
    bias_std_y: float | None = None
    bias_std_z: float | None = None
    drift_x: float | None = None
    drift_y: float | None = None
    drift_z: float | None = None
    drift_std_x: float | None = None
    drift_std_y: float | None = None
    drift_std_z: float | None = None


@dataclass(frozen=True, kw_only=True)
class SensorAccount:
    """What was subtracted from a force sensor's reading, None without a sensor.

    offset_doubt: why its bias may be a push; mounting_doubt: why its mounting may be wrong.
    """

    offset: OffsetAccount | None = None
    offset_doubt: Remark | None = None
    mounting_doubt: Remark | None = None

    def findings(self) -> list[Finding]:
        """Return findings with the reasons why the sensor's mounting and bias may be wrong."""
        found = []
        if self.mounting_doubt is not None:
            detail = self.mounting_doubt.text
            found.append(Finding("force", Found.MOUNTING, "warning", 1, detail))
        if self.offset_doubt is not None:
            detail = (
                f"{self.offset_doubt.text}: a steady push may have been taken for bias; "
                "record some seconds in which nothing touches the tool"
            )
            found.append(Finding("force", Found.OFFSET, "warning", 1, detail))
        return found


@dataclass(frozen=True, kw_only=True)
class Compared(SensorAccount):
    """beside_sensor.json: every estimate of the contact wrench against the force sensor; empty
    without one.

    sensed: what the sensor reads; errors: rows of force_mae.csv; contacts: of contact_errors.csv,
    without fate.
    """

    sensed: Sensed | None = None
    errors: list[ForceError] = field(default_factory=list)
    contacts: list[ContactError] = field(default_factory=list)
