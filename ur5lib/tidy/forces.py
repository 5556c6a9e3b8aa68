"""Rows of tables about forces: errors beside a sensor, alarms, contacts, the wrist sensor."""

from collections.abc import Iterator, Mapping

import numpy as np

from ur5lib.force.estimators import STATIC
from ur5lib.force.fates import Outcome, kind_of, outcomes
from ur5lib.records.contacts import Detected
from ur5lib.records.force_errors import WHOLE, Compared
from ur5lib.records.verdicts import Reason
from ur5lib.tidy import WORDS, Row

FORCES = ("Fx", "Fy", "Fz")
JUDGED = ("contact", "missed")  # periods by which a force is judged
STDS = ("Fx_std", "Fy_std", "Fz_std")


def force_mae(forces: Compared, role: str = "") -> Iterator[Row]:
    """Yield the errors of the force estimates against the sensor, and whether those in contact may
    be relied on; role: of the recording.
    """
    for kind, estimates in forces.errors.items():
        for estimate, periods in estimates.items():
            contact = periods.get("contact", {})  # determined: the skill there is above zero
            skills = contact.get("skill_low", contact.get("skill", {}))
            determined = {name: (skill or 0) > 0 for name, skill in skills.items()}
            for during, figures in periods.items():
                about = {"kind": kind, "estimate": estimate, "during": during}
                for component in figures["mae"]:
                    yield about | {
                        "component": component,
                        "determined": determined.get(component),
                        **{name: values[component] for name, values in figures.items()},
                        **used({**about, "component": component}, forces, role),
                    }


def used(row: Row, forces: Compared, role: str) -> Row:
    """Return whether an error of a force in contact may be relied on, and why not, or with which
    doubt; nothing of other errors.
    """
    during, component = row["during"], row["component"]
    if row["kind"] != "compensated" or during not in JUDGED or component not in FORCES:
        return {}
    reason: Reason = "uncalibrated" if row["estimate"] == STATIC else ""
    if role == "fit":
        reason = "fitted"
    elif forces.offset_doubt is not None:
        reason = "sensor_bias"
    return {"use": WORDS[reason in ("", "uncalibrated")], "reason": reason}


def contact_errors(
    forces: Compared, detection: Mapping[str, Detected] | None = None
) -> Iterator[Row]:
    """Yield the errors of each estimate by contact at the sensor, and of estimates that raise
    alarms, what became of the contact.
    """
    for estimate, contacts in forces.contacts.items():
        met = dict[int, Outcome]()
        if (found := (detection or {}).get(estimate)) is not None:
            whole = [one for one in contacts if one.component == WHOLE]
            numbers = [one.contact for one in whole]
            met = dict(zip(numbers, outcomes(whole, found.raised), strict=True))
        for one in contacts:
            row = vars(one) | {"estimate": estimate}
            own = met.get(one.contact) if one.component == WHOLE else None
            yield row | (own._asdict() if own else {})


def sensed(forces: Compared) -> Iterator[Row]:
    """Yield the largest reading of a force sensor, its contacts, and its bias without contact, with
    its drift.
    """
    if felt := forces.felt:
        row = vars(felt) | {"largest_force_n": felt.largest, "share_in_contact": felt.contact}
        if (offset := forces.offset) is not None:
            for name in ("bias", "bias_std", "drift", "drift_std"):
                values = zip("xyz", getattr(offset, name), strict=False)
                row |= {f"{name}_{axis}": value for axis, value in values}
        yield row


def detection(detection: dict[str, Detected]) -> Iterator[Row]:
    """Yield contacts detected by each estimate, by the force that they reach.

    Without a force sensor, one row an estimate and no force.
    """
    for estimate, found in detection.items():
        row = vars(found) | {
            "estimate": estimate,
            "false_alarms_per_min": found.false_per_min,
            "extra_alarms": found.extra,
            "alarms": len(found.raised),
        }
        if not found.classes:
            yield row
        for reached in found.classes:
            yield row | {
                **vars(reached),
                "force_class_n": reached.force,
                "median_delay_s": reached.median_delay,
            }


def fixed_threshold(detection: dict[str, Detected]) -> Iterator[Row]:
    """Yield the pushes found above the thesis's fixed threshold, and the share of time above it."""
    for estimate, found in detection.items():
        for axis, own in found.axes.items():
            about = {"estimate": estimate, "component": f"F{axis}", "force_n": own.force}
            yield vars(own) | about


def contacts(detection: dict[str, Detected], is_free: bool = False) -> Iterator[Row]:
    """Yield each alarm: times, largest force and the posture there, its kind, mass of a load,
    whether the flange is excluded; is_free: see `kind_of`.
    """
    for estimate, found in detection.items():
        for alarm in found.raised:
            yield vars(alarm) | {
                "estimate": estimate,
                "kind": kind_of(alarm, is_free),
                **{f"{name}_s": getattr(alarm, name) for name in ("start", "end", "peak")},
                **dict(zip(FORCES, alarm.force, strict=True)),
                **dict(zip(STDS, alarm.force_std, strict=True)),
                "posture_deg": " ".join(f"{angle:z.1f}" for angle in np.degrees(alarm.q)),
            }
