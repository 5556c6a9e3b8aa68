"""The contacts that each estimate detects."""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

import pandas as pd

from ur5lib.records.codes import Found
from ur5lib.records.contact_place import PlaceRow
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import Finding

Cause = Literal["late_alarm", "constants", "stiction", "friction"]  # of an error in contact
WHOLE = "norm"  # the component of all three axes together


class Fate(StrEnum):
    """What becomes of a contact at the sensor: a code, as in the column `fate`."""

    FOUND = "found"  # by an alarm of its own
    MERGED = "merged"  # within the alarm of another contact
    MISSED = "missed"


class Kind(StrEnum):
    """What an alarm is: a code, as in the column `kind`."""

    CONTACT = "contact"
    LOAD = "load"
    OFF_FLANGE = "off_flange"
    FALSE = "false"


OF_CONTACTS = [Kind.CONTACT, Kind.OFF_FLANGE]  # kinds of alarms by a contact


@dataclass(frozen=True, kw_only=True)
class ContactError:
    """A row of contact_errors.csv: peak, impulse and onset of a contact at the sensor, and an
    estimate's errors.

    component: an axis, or "norm" for all three; peak: the largest force [N]; impulse: the magnitude
    of the force's integral [N s]; errors: the estimate's component along the sensor's direction
    minus the sensor's value, negative if the estimate is too small, NaN if it is unknown or the
    sensor saturated in part of the contact. The row "norm" alone has: onset_error_s, the delay with
    which the estimate passes the sensor's levels; mae [N], mean over the axes; mae_shut, the part
    of it while no alarm is raised; mae_gain, the part that one gain of the whole recording would
    remove; largest, the largest size of the estimate before it is averaged at rest, and
    largest_band, half of its 95 % band [N]; of an estimate that raises alarms, fate (found by an
    alarm of its own, merged within that of another contact, or missed), cause of most of mae
    (late_alarm, by mae_shut; constants, by mae_gain; else friction, at rest stiction), and the band
    [N], see `ur5lib.force.fates.Outcome`. All rows are in `tables/contact_errors.csv` of a study's
    results.
    """

    estimate: str
    contact: int
    start_s: float
    end_s: float
    component: str
    peak: float
    peak_error: float
    impulse: float
    impulse_error: float
    largest: float | None = None
    largest_band: float | None = None
    onset_error_s: float | None = None
    mae: float | None = None
    mae_shut: float | None = None
    mae_gain: float | None = None
    fate: Fate | None = None
    cause: Cause | None = None
    band: float | None = None


@dataclass(frozen=True, kw_only=True)
class Detection:
    """A row of detection.csv: the contacts at a sensor that reach a force, and how many of them an
    estimate finds; without a sensor, no force and no contacts.

    threshold: of its odds, or of the force [N] where it states none; force_class_n: [N]; merged:
    within the alarm of another contact; precision: share of alarms that are contacts; recall: found
    of contacts; false_alarms_per_min: alarms in no contact, or that go on long after it, without
    loads and contacts off the flange, which the sensor does not feel; extra_alarms: further ones in
    a contact; time_in_alarm, free_time_in_alarm: shares of all samples and of those without
    contact; median_delay_s: of the found ones [s]; roc_area: under the receiver's curve. Where the
    leading estimate finds no contact, medians of the largest axis [N]: untouched_n, half of the
    band if nothing has touched since the arm came to rest; hidden_n, up to which a contact since
    then could be hidden; hidden_at_all_n, also one that began before. Of the leading estimate, in
    the longest rest: unseen_link_2_n, unseen_link_3_n, below which a push on the middle of the link
    may raise no alarm (nine of ten harder ones do, whatever their direction).
    """

    estimate: str
    threshold: float
    force_class_n: float | None = None
    contacts: int | None = None
    found: int | None = None
    merged: int | None = None
    precision: float = float("nan")
    recall: float | None = None
    false_alarms_per_min: float | None = None
    extra_alarms: int | None = None
    time_in_alarm: float
    free_time_in_alarm: float | None = None
    median_delay_s: float | None = None
    alarms: int
    alarms_per_min: float
    roc_area: float | None = None
    untouched_n: float | None = None
    hidden_n: float | None = None
    hidden_at_all_n: float | None = None
    unseen_link_2_n: float | None = None
    unseen_link_3_n: float | None = None


@dataclass(frozen=True, kw_only=True)
class FixedThreshold:
    """A row of fixed_threshold.csv: an estimate with the thesis's fixed threshold on one axis.

    force_n: the threshold [N]; pushes: that reach it at the sensor, None without one; found: of
    these; time_above: share of the recording.
    """

    estimate: str
    component: str
    force_n: float
    pushes: int | None = None
    found: int | None = None
    time_above: float


@dataclass(frozen=True, kw_only=True)
class Contact:
    """A row of contacts.csv: an alarm of an estimate.

    start_s, end_s, peak_s: of the largest force [s]; Fx to Fz: this force and its standard
    deviations [N]; largest: size of the force where it is largest before it is averaged at rest,
    with half of its 95 % band [N]; posture_deg: the joints there [°]; flange_speed: mean [m/s];
    kind, the first that is true: load, a grasped one; contact, where the sensor reads a touch (3
    N); false, where without a sensor the role denies contacts and no undeclared load is found;
    off_flange; false, where a sensor reads nothing; else contact; load_mass: of a load [kg];
    off_flange: whether, by the torques, the contact is not at the flange, and the probability of
    that; link: the likeliest, from 1, of a contact in motion: at rest, friction hides it.
    """

    estimate: str
    start_s: float
    end_s: float
    peak_s: float
    Fx: float
    Fx_std: float
    Fy: float
    Fy_std: float
    Fz: float
    Fz_std: float
    largest: float = float("nan")
    largest_band: float = float("nan")
    posture_deg: str
    flange_speed: float
    kind: Kind
    load_mass: float | None = None
    load_mass_std: float | None = None
    off_flange: bool = False
    link: int | None = None
    off_flange_probability: float | None = None


@dataclass(frozen=True, kw_only=True)
class Contacts:
    """contacts.json: the contacts of one recording by each estimate, as rows of contact_errors.csv,
    detection.csv, fixed_threshold.csv, contacts.csv and contact_place.csv.
    """

    errors: list[ContactError] = field(default_factory=list)
    detections: list[Detection] = field(default_factory=list)
    fixed_thresholds: list[FixedThreshold] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    places: list[PlaceRow] = field(default_factory=list)

    def findings(self) -> list[Finding]:
        """Return a finding if a sensor shows another place of contacts than the assumed one."""
        return [found for row in self.places if (found := _other_place(row))]


def _other_place(row: PlaceRow) -> Finding | None:
    if row.sensed_x_m is None or row.sensed_y_m is None or row.sensed_z_m is None:
        return None
    sensed = row.sensed_x_m, row.sensed_y_m, row.sensed_z_m
    away = math.dist(sensed, (row.x_m, row.y_m, row.z_m))
    if away <= row.within_m + (row.sensed_within_m or 0.0):
        return None
    detail = (
        f"by the sensor's moments, contacts are {number(100 * away, '.0f')} cm from where they are "
        f"assumed: state `contact_place: {{position_m: [{as_written(sensed, '.2f')}]}}`"
    )
    return Finding("force", Found.OTHER_CONTACT_PLACE, "warning", 1, detail)


def with_sharp_peaks(rows: pd.DataFrame) -> pd.DataFrame:
    """Return contacts at a sensor with the errors of the peaks before forces are averaged at rest,
    where both are known.
    """
    sharp = rows["largest"].astype(float) - rows["peak"].astype(float)
    known = sharp.notna() & rows["peak_error"].notna()
    return rows.assign(peak_error=rows["peak_error"].where(~known, sharp))
