"""The alarms of an estimate, and their comparison with the contacts at a force sensor."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from ur5lib.force.estimators import Stated
from ur5lib.force.matching import compare, receiver_curve
from ur5lib.force.sensed_contact import (
    CONTACT_CLEARANCE,
    CONTACT_FORCE,
    RELEASE_FORCE,
    TOUCH_FORCE,
    contacts,
    is_free,
)
from ur5lib.force.thresholds import alarms, force_alarms
from ur5lib.records.contacts import Detection, FixedThreshold
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.table import WRENCH
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span, inside_spans, overlap, spans

# Contacts are counted by class: those that reach each of these forces at the sensor.
FORCE_CLASSES = [TOUCH_FORCE, CONTACT_FORCE, 10.0, 15.0]  # N
MIN_FORCE = 1e-12  # N; replaces a zero divisor
RELIABLE_FORCE_OF_THESIS = 10.0  # N; Section 6 claims reliable detection along z from this force on


@dataclass(frozen=True)
class Alarm:
    """A span in which an estimate shows a contact.

    start, end, peak: times [s] of its first and last sample, and of its largest force; force,
    force_std: that force (3,) [N], base axes, and its standard deviation; largest, largest_band:
    the largest size of the force before it is averaged, and half of its 95 % band [N]; q: joints
    then (n,) [rad]; flange_speed: mean during the alarm [m/s]; kind: contact or grasped load;
    load_mass, load_mass_std: [kg], None for a contact; link: the likeliest, from 1, None at
    rest; off_flange_probability: that it is not the last one, off_flange: whether that is
    likely; at_sensor: whether it overlaps a touch at the force sensor, None without
    a sensor.
    """

    start: float
    end: float
    peak: float
    force: Array
    force_std: Array
    q: Array
    largest: float = float("nan")
    largest_band: float = float("nan")
    flange_speed: float = float("nan")
    kind: Literal["contact", "load"] = "contact"
    load_mass: float | None = None
    load_mass_std: float | None = None
    link: int | None = None
    off_flange_probability: float | None = None
    off_flange: bool = False
    at_sensor: bool | None = None


Named = Callable[[Span, Alarm], Alarm]


@dataclass(frozen=True)
class Matched:
    """How alarms match the contacts at a sensor; the fields have the names of `Detection`'s
    columns.

    classes: counts for the contacts that reach each of FORCE_CLASSES; empty without a sensor.
    """

    alarms_per_min: float
    precision: float = float("nan")
    false_alarms_per_min: float | None = None
    extra_alarms: int | None = None
    classes: list[dict[str, Any]] = field(default_factory=list)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each force class, with the figures over all contacts; these alone
        without classes.
        """
        whole = {name: value for name, value in vars(self).items() if name != "classes"}
        return [whole | own for own in self.classes or [{}]]


class Alarms(NamedTuple):
    """The alarms of one estimate. evidence: (N,) log-odds, or size of the force [N], from which
    they follow; raised: their spans; wrench, std: the estimate (N, 6); unsmoothed: the force
    for peaks (N, 3) [N].
    """

    evidence: Array
    raised: list[Span]
    wrench: Array
    std: Array
    unsmoothed: Array


def alarms_of(estimate: Stated, threshold: float) -> Alarms:
    """Return the alarms of an estimate by its odds of contact, or, where it states a force alone,
    by the size of the force; the threshold is then in N.
    """
    wrench, odds = estimate.wrench, estimate.log_odds
    std = np.full_like(wrench, np.nan) if estimate.std is None else estimate.std
    if odds is not None:
        return Alarms(odds, alarms(odds, threshold), wrench, std, estimate.sharp)
    size = np.nan_to_num(np.linalg.norm(wrench[:, :3], axis=1))
    return Alarms(size, force_alarms(size, threshold), wrench, std, estimate.sharp)


def all_alarms(
    estimates: Mapping[str, Stated], thresholds: Mapping[str, float]
) -> dict[str, Alarms]:
    """Return, by name, the alarms of each estimate of a recording that has a threshold."""
    return {
        name: alarms_of(estimates[name], threshold)
        for name, threshold in thresholds.items()
        if name in estimates
    }


def raised(
    own: Alarms, sensor: SensorWrenches, q: Array, speed: Array, named: Named
) -> list[Alarm]:
    """Return each alarm of an estimate with its largest force, kind and place.

    own: the estimate's alarms; q: (N, n) [rad]; speed: of the flange (N,) [m/s]; named: sets the
    kind of an alarm, contact or load.
    """
    felt = touches(sensor)
    return [
        replace(
            named(span, strongest(span, sensor.time, q, own)),
            flange_speed=float(speed[slice(*span)].mean()),
            at_sensor=None if felt is None else overlaps(span, felt),
        )
        for span in own.raised
    ]


def detections(
    estimate: str, own: Alarms, alarms: Sequence[Alarm], sensor: SensorWrenches, threshold: float
) -> Iterator[Detection]:
    """Yield for each class of contacts at the sensor how the alarms of an estimate match it."""
    about: dict[str, Any] = {
        "estimate": estimate,
        "threshold": threshold,
        "alarms": len(alarms),
        "time_in_alarm": float(inside_spans(own.raised, len(sensor.time)).mean()),
        "free_time_in_alarm": free_time_in_alarm(own, sensor),
        "roc_area": roc_area(own, sensor),
    }
    for row in matched(own.raised, sensor, not_felt(own.raised, alarms)).rows():
        yield Detection(**about, **row)


def not_felt(raised: Sequence[Span], alarms: Sequence[Alarm]) -> list[Span]:
    """Return the spans of alarms that a force sensor would not feel: loads, and contacts away from
    the flange.
    """
    pairs = zip(raised, alarms, strict=True)
    return [span for span, one in pairs if one.kind == "load" or one.off_flange]


def fixed_thresholds(
    estimate: str, own: Alarms, sensor: SensorWrenches
) -> Iterator[FixedThreshold]:
    """Yield, for each axis, how many pushes an estimate finds by the thesis's fixed threshold."""
    for axis, component in enumerate(WRENCH[:3]):
        force, least = own.wrench[:, axis], RELIABLE_FORCE_OF_THESIS
        pushes = found = None
        if "compensated" in sensor.wrench:
            sensed = sensor.wrench["compensated"][:, axis]
            pushes, found = pushes_above(force, sensed, least, sensor.period)
        yield FixedThreshold(
            estimate=estimate,
            component=component,
            force_n=least,
            pushes=pushes,
            found=found,
            time_above=float(np.mean(np.nan_to_num(np.abs(force)) >= least)),
        )


def strongest(span: Span, time: Array, q: Array, own: Alarms) -> Alarm:
    """Return the alarm in a span, described by its largest force; time: (N,) [s], q: (N, n)
    [rad].
    """
    first, last = span
    peak = peak_of(span, own)
    times = float(time[first]), float(time[last - 1]), float(time[peak])
    largest = largest_force(own.unsmoothed[first:last], own.std[first:last, :3])
    return Alarm(*times, own.wrench[peak, :3], own.std[peak, :3], q[peak], *largest)


def largest_force(force: Array, std: Array) -> tuple[float, float]:
    """Return the largest size [N] of a force (M, 3), and half of its 95 % band then [N]; NaN
    without a force. std: (M, 3) [N].
    """
    size = np.linalg.norm(force, axis=1)
    if not np.isfinite(size).any():
        return float("nan"), float("nan")
    at = int(np.nanargmax(size))
    return float(size[at]), NORMAL95 * std_of_size(force[at], std[at])


def std_of_size(force: Array, std: Array) -> float:
    """Return the standard deviation [N] of the size of a force; force, std: (3,) [N]."""
    # d|F| = F · dF / |F|
    return float(np.linalg.norm(force * std)) / max(float(np.linalg.norm(force)), MIN_FORCE)


def peak_of(span: Span, own: Alarms) -> int:
    """Return the index of the sample with the largest force in an alarm."""
    force = own.wrench[slice(*span), :3]
    return span[0] + int(np.argmax(np.nan_to_num(np.linalg.norm(force, axis=1))))


def free_time_in_alarm(own: Alarms, sensor: SensorWrenches) -> float | None:
    """Return the share of contact-free samples that are in alarm; None without a sensor or such
    samples.
    """
    if (force := sensed_force(sensor)) is None:
        return None
    free = is_free(force, sensor.period)
    return float(inside_spans(own.raised, len(force))[free].mean()) if free.any() else None


def roc_area(own: Alarms, sensor: SensorWrenches) -> float | None:
    """Return the area under the ROC curve over samples, None without a sensor."""
    if (force := sensed_force(sensor)) is None:
        return None
    wrong, right = receiver_curve(own.evidence, force >= TOUCH_FORCE)
    return float(np.trapezoid(right, wrong))


def sensed_force(sensor: SensorWrenches) -> Array | None:
    """Return the magnitude (N,) [N] of the force at the sensor; None without a sensor or any
    reading.
    """
    if "compensated" not in sensor.wrench:
        return None
    force = np.linalg.norm(sensor.wrench["compensated"][:, :3], axis=1)
    return force if np.isfinite(force).any() else None


def touches(sensor: SensorWrenches) -> list[Span] | None:
    """Return the spans of touches at a sensor, None without a sensor."""
    return None if (force := sensed_force(sensor)) is None else contacts(force)


def overlaps(span: Span, others: Iterable[Span]) -> bool:
    """Return whether a span shares a sample with any of the others."""
    return any(overlap(span, one) for one in others)


def false_per_min(
    raised: Sequence[Span], sensor: SensorWrenches, unfelt: Sequence[Span] = ()
) -> float | None:
    """Return the number of false alarms per minute, None without a sensor.

    An alarm is false if it overlaps no touch, or covers more than CONTACT_CLEARANCE [s] of
    contact-free time: otherwise, an alarm that never ends would find a contact and never be false.
    unfelt: spans of contacts that the sensor does not feel.
    """
    force, step = sensed_force(sensor), sensor.period
    if force is None:
        return None
    felt = [*contacts(force), *unfelt]
    free = is_free(force, step) & ~inside_spans(unfelt, len(force))
    count = sum(
        not overlaps(own, felt) or free[slice(*own)].sum() * step > CONTACT_CLEARANCE
        for own in raised
    )
    return count / (len(force) * step / 60)


def matched(raised: list[Span], sensor: SensorWrenches, unfelt: Sequence[Span] = ()) -> Matched:
    """Count the alarms, and match them with the contacts at a sensor.

    unfelt: spans of contacts that the sensor does not feel.
    """
    step = sensor.period
    minutes = len(sensor.time) * step / 60
    if (force := sensed_force(sensor)) is None:
        return Matched(alarms_per_min=len(raised) / minutes)
    any_contact = compare(raised, contacts(force), step)
    return Matched(
        alarms_per_min=len(raised) / minutes,
        precision=any_contact.precision(),
        false_alarms_per_min=false_per_min(raised, sensor, unfelt),
        extra_alarms=any_contact.extra,
        classes=[by_class(least, force, raised, step) for least in FORCE_CLASSES],
    )


def by_class(least: float, force: Array, raised: list[Span], step: float) -> dict[str, Any]:
    """Return counts, recall and median delay [s] of the alarms for contacts that reach a force [N],
    as columns of `Detection`.

    force: (N,) [N], of the sensor; step: sampling period [s].
    """
    found = compare(raised, contacts(force, least), step)
    return {
        "force_class_n": least,
        "contacts": found.contacts,
        "found": found.found,
        "merged": found.merged,
        "recall": found.recall(),
        "median_delay_s": float(np.median(found.delays)) if len(found.delays) else None,
    }


def pushes_above(force: Array, sensed: Array, least_force: float, period: float) -> tuple[int, int]:
    """Return how many pushes reach a force at the sensor, and how many of these have an alarm of
    their own with that force as threshold.

    force, sensed: estimate and reading along one axis (N,) [N], NaN where unknown; least_force:
    [N]; period: [s].
    """
    pushes = spans(np.nan_to_num(np.abs(sensed)), least_force, RELEASE_FORCE)
    detection = compare(force_alarms(np.abs(force), least_force), pushes, period)
    return detection.contacts, detection.found
