"""The contacts that each estimate detects."""

from dataclasses import dataclass, field
from typing import Literal, get_args

from ur5lib.timeseries.arrays import Array

SPEEDS = {0.0: "at rest", 0.01: "slow", 0.25: "fast"}  # of the flange, from [m/s] on
Fate = Literal["found", "merged", "missed"]  # by an alarm of its own, within another one's, by none
FATES: tuple[Fate, ...] = get_args(Fate)
Cause = Literal["late_alarm", "constants", "stiction", "friction"]  # of an error in contact
Kind = Literal["contact", "load", "off_flange", "false"]  # of an alarm
OFF_FLANGE: Kind = "off_flange"
OF_CONTACTS: list[Kind] = ["contact", OFF_FLANGE]  # neither loads nor false


@dataclass(frozen=True)
class Alarm:
    """An alarm: start, end and time of the largest force [s], this force (3,) [N] and its standard
    deviation, and the joints (n,) [rad] there; the flange's mean speed [m/s]; whether it is a
    contact or a load, and the mass of a load [kg]; whether the torques exclude that the contact is
    at the flange; at_sensor: whether it overlaps a touch at the force sensor, None without one.
    """

    start: float
    end: float
    peak: float
    force: Array
    force_std: Array
    q: Array
    flange_speed: float = float("nan")
    kind: Literal["contact", "load"] = "contact"
    load_mass: float | None = None
    load_mass_std: float | None = None
    off_flange: bool = False
    at_sensor: bool | None = None


@dataclass(frozen=True)
class OnAxis:
    """An estimate with the thesis's fixed threshold on one axis.

    force: the threshold [N]; time_above: share of the recording; pushes: that reach the threshold
    at the sensor; found: of these. None without a sensor.
    """

    force: float
    time_above: float
    pushes: int | None = None
    found: int | None = None


@dataclass(frozen=True)
class ForceClass:
    """The contacts that reach a force at the sensor [N], how many are found, how late [s], and how
    many more lie within the alarm of another one.
    """

    force: float
    contacts: int
    found: int
    recall: float
    median_delay: float | None
    merged: int = 0


@dataclass(frozen=True, kw_only=True)
class Matched:
    """Alarms a minute, and how they match the contacts at a sensor; None without one.

    classes: by the force that a contact reaches; precision: share of alarms that are contacts;
    false_per_min: alarms in no contact, or that go on long after it, without loads and contacts off
    the flange, which the sensor does not feel; extra: further alarms in a contact.
    """

    alarms_per_min: float
    classes: list[ForceClass] = field(default_factory=list)
    precision: float = float("nan")
    false_per_min: float | None = None
    extra: int | None = None


@dataclass(frozen=True, kw_only=True)
class Detected(Matched):
    """The contacts that an estimate detects.

    time_in_alarm, free_time_in_alarm: shares of all samples and of those without contact; axes:
    with the thesis's threshold; roc_area: under the receiver's curve.
    """

    threshold: float
    raised: list[Alarm]
    time_in_alarm: float
    axes: dict[str, OnAxis]
    free_time_in_alarm: float | None = None
    roc_area: float | None = None
