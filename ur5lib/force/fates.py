"""What became of each contact at a force sensor, and what each alarm is.

A contact is found by an alarm of its own, merged within the alarm of another contact, or missed:
found + merged + missed is the number of contacts, as `matching.compare` counts them.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.force.alarms import Alarm, std_of_size
from ur5lib.force.matching import match
from ur5lib.records.contacts import WHOLE, Cause, Contact, ContactError, Fate, Kind
from ur5lib.records.pushes import SPEEDS
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span, overlap

TICK = 1e-6  # s; any sampling period is longer
SLOW = min(speed for speed in SPEEDS if speed > 0)  # m/s; below it, a flange rests


class Outcome(NamedTuple):
    """Whether a contact was found, and why its error is what it is.

    fate: found, merged or missed; cause: of the largest part of its error; band: half-width [N] of
    the 95 % interval of its alarm's largest force; both None if the contact is not found or they
    are unknown.
    """

    fate: Fate
    cause: Cause | None = None
    band: float | None = None


def with_fates(rows: Iterable[ContactError], alarms: Sequence[Alarm]) -> list[ContactError]:
    """Return an estimate's rows; those of component "norm" with fate, cause and band of the
    contact.

    alarms: of the same estimate.
    """
    rows = [*rows]
    whole = [one for one in rows if one.component == WHOLE]
    met = dict(zip((one.contact for one in whole), outcomes(whole, alarms), strict=True))
    return [
        replace(one, **met[one.contact]._asdict()) if one.component == WHOLE else one
        for one in rows
    ]


def contact_rows(estimate: str, alarms: Iterable[Alarm], is_free: bool) -> Iterator[Contact]:
    """Yield the alarms of an estimate as rows of contacts.csv; is_free: as of `kind_of`."""
    for alarm in alarms:
        force = dict(zip(("Fx", "Fy", "Fz"), alarm.force.tolist(), strict=True))
        std = dict(zip(("Fx_std", "Fy_std", "Fz_std"), alarm.force_std.tolist(), strict=True))
        yield Contact(
            estimate=estimate,
            start_s=alarm.start,
            end_s=alarm.end,
            peak_s=alarm.peak,
            **force,
            **std,
            largest=alarm.largest,
            largest_band=alarm.largest_band,
            posture_deg=" ".join(f"{angle:z.1f}" for angle in np.degrees(alarm.q)),
            flange_speed=alarm.flange_speed,
            kind=kind_of(alarm, is_free),
            load_mass=alarm.load_mass,
            load_mass_std=alarm.load_mass_std,
            off_flange=alarm.off_flange,
            link=alarm.link,
            off_flange_probability=alarm.off_flange_probability,
        )


def outcomes(contacts: Sequence[ContactError], alarms: Sequence[Alarm]) -> list[Outcome]:
    """Return the outcome of each contact at a sensor; contacts: rows with the component "norm"."""
    raised = [stretch(one.start, one.end) for one in alarms]
    touches = [stretch(one.start_s, one.end_s) for one in contacts]
    own = {contact: alarms[alarm] for alarm, contact in match(raised, touches)}
    return [
        Outcome(fate, cause_of(contact, own[k]), band_of(own[k])) if k in own else Outcome(fate)
        for k, (contact, fate) in enumerate(zip(contacts, fates(raised, touches), strict=True))
    ]


def fates(alarm: Sequence[Span], contact: Sequence[Span]) -> list[Fate]:
    """Return whether each contact is found, merged or missed."""
    own = {k for _, k in match([*alarm], [*contact])}
    felt = [any(overlap(one, touch) for one in alarm) for touch in contact]
    others = (Fate.MERGED if one else Fate.MISSED for one in felt)
    return [Fate.FOUND if k in own else other for k, other in enumerate(others)]


def stretch(start: float, end: float) -> Span:
    """Return the span in ticks from the time of a first sample to that of a last one [s], both
    included.

    Spans overlap if and only if they share a sample.
    """
    return round(start / TICK), round(end / TICK) + 1


def band_of(alarm: Alarm) -> float | None:
    """Return the half-width [N] of the 95 % interval of an alarm's |force|, None if unknown."""
    std = std_of_size(alarm.force, alarm.force_std) if alarm.force.any() else float("nan")
    return NORMAL95 * std if np.isfinite(std) else None


def cause_of(contact: ContactError, alarm: Alarm) -> Cause | None:
    """Return the largest part of the error of a contact that an alarm finds, None without an error.

    What neither a late alarm nor a gain explains is friction, or stiction if the flange rests.
    """
    each = contact.mae, contact.mae_shut, contact.mae_gain
    mae, late, gain = np.nan_to_num([part or 0.0 for part in each]).tolist()
    friction: Cause = "stiction" if alarm.flange_speed < SLOW else "friction"
    parts: dict[Cause, float] = {
        friction: mae - late - gain,
        "late_alarm": late,
        "constants": gain,
    }
    largest = max(parts, key=parts.__getitem__)
    return largest if parts[largest] > 0 else None


def kind_of(alarm: Alarm, is_free: bool) -> Kind:
    """Return what an alarm is: load, contact, false, or a contact off the flange.

    is_free: whether the recording's role means that nothing touches the arm. The sensor decides
    before the role. It does not feel contacts off the flange, so these are not false.
    """
    if alarm.kind == Kind.LOAD:
        return Kind.LOAD
    if alarm.at_sensor:
        return Kind.CONTACT
    if alarm.at_sensor is None and is_free:  # of the whole arm
        return Kind.FALSE
    if alarm.off_flange:
        return Kind.OFF_FLANGE
    return Kind.CONTACT if alarm.at_sensor is None else Kind.FALSE
