"""Contact detection: contacts at a force sensor, alarms, and the smallest detectable force."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.optimize import linear_sum_assignment, minimize

from ur5lib.records.force_errors import Felt
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

Span = tuple[int, int]  # first sample, and the one after the last

ALARM_HYSTERESIS = 2.0  # in log-odds: an alarm ends this far below the threshold
THRESHOLD_STEP = 0.5  # N, between the thresholds of forces that are tried
PUSH_DURATION = 1.0  # s, of trial pushes
PAUSE_DURATION = 2.0  # s, between them
LOG_STEEPNESS = 1.5  # of the logistic curve: from 25 to 75 % found within a factor of 1.6
# At the sensor, a contact reaches the first force and lasts above the second.
TOUCH_FORCE = 3.0  # N
RELEASE_FORCE = 2.0  # N
CONTACT_FORCE = 5.0  # N, above which a sample is in contact
FREE_FORCE = 1.0  # N, below which a sample is free, if it is far from any touch
CONTACT_CLEARANCE = 0.5  # s, of a free sample from any touch


def spans(signal: Array, on: float, off: float) -> list[Span]:
    """Return the stretches above `off` that reach `on`. signal: (N,)."""
    stretches = runs(signal > off).tolist()
    return [(first, last) for first, last in stretches if signal[first:last].max() >= on]


def alarms(log_odds: Array, threshold: float) -> list[Span]:
    """Return the alarms of log-odds of contact (N,)."""
    return spans(log_odds, threshold, threshold - ALARM_HYSTERESIS)


def alarm_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Return the log-odds above which contact-free recordings raise few enough alarms a minute.

    contact_free: log-odds (N,) of each recording, at its period [s]. The result is at least 0,
    even odds.
    """
    allowed = _allowed_alarms(contact_free, periods, per_minute)
    peaks = sorted(
        float(odds[slice(*alarm)].max()) for odds in contact_free for alarm in alarms(odds, 0.0)
    )
    # the highest peak of one alarm too many
    above = peaks[-allowed - 1] if allowed < len(peaks) else -np.inf
    return max(0.0, float(np.nextafter(above, np.inf)))


def _allowed_alarms(contact_free: list[Array], periods: list[float], per_minute: float) -> int:
    """Return how many alarms recordings (N,), each at its period [s], may raise together."""
    pairs = zip(contact_free, periods, strict=True)
    return int(per_minute * sum(len(values) * period for values, period in pairs) / 60)


@dataclass(frozen=True)
class Detection:
    """Alarms and a sensor's contacts, matched one to one.

    contacts: number of contacts; found: of these, with an alarm of their own; merged: of these,
    within the alarm of another one; alarms: number of alarms; extra: of these, additional ones in a
    contact; false: of these, in no contact; delays: from the start of each contact found to that of
    its alarm [s], negative where the alarm is earlier (the estimate is offline).
    """

    contacts: int
    found: int
    merged: int
    alarms: int
    extra: int
    false: int
    delays: Array

    def recall(self) -> float:
        """Return the share of contacts found."""
        return self.found / self.contacts if self.contacts else float("nan")

    def precision(self) -> float:
        """Return the share of alarms that are matched to a contact."""
        return self.found / self.alarms if self.alarms else float("nan")


def compare(alarm: list[Span], contact: list[Span], period: float) -> Detection:
    """Count which contacts have an alarm of their own, and which alarms have no contact.

    period: [s].
    """
    pairs = match(alarm, contact)
    late = np.array([alarm[i][0] - contact[j][0] for i, j in pairs], dtype=float)
    false = sum(not any(overlap(a, c) for c in contact) for a in alarm)
    extra = len(alarm) - false - len(pairs)
    merged = sum(any(overlap(a, c) for a in alarm) for c in contact) - len(pairs)
    return Detection(len(contact), len(pairs), merged, len(alarm), extra, false, late * period)


def match(alarm: list[Span], contact: list[Span]) -> list[tuple[int, int]]:
    """Match alarms (i) and contacts (j) that overlap in time, one to one: pairs (i, j).

    The assignment has as many pairs as possible, and among those, the longest overlaps. So an alarm
    that never ends finds one contact, and of ten alarms in one contact nine are extra.
    """
    if not alarm or not contact:
        return []

    shared = np.array([[overlap(a, c) for c in contact] for a in alarm])
    value = np.where(shared > 0, shared + shared.sum(), 0)  # one more pair is worth any overlap
    pairs = np.transpose(linear_sum_assignment(value, maximize=True)).tolist()
    return [(i, j) for i, j in pairs if shared[i, j]]


def overlap(first: Span, second: Span) -> int:
    """Return the number of samples that two stretches share."""
    return max(0, min(first[1], second[1]) - max(first[0], second[0]))


def receiver_curve(log_odds: Array, contact: Mask) -> tuple[Array, Array]:
    """Return the ROC by sample: false alarm and detection rates (N + 1,), thresholds falling."""
    order = np.argsort(-log_odds)
    hits = np.concatenate([[0], np.cumsum(contact[order])])
    misses = np.concatenate([[0], np.cumsum(~contact[order])])
    return misses / max(misses[-1], 1), hits / max(hits[-1], 1)


def trial_pushes(count: int, period: float) -> tuple[Array, list[Span]]:
    """Return raised-cosine pushes of height 1, one after each pause: profile (N,) and spans."""
    length = round(PUSH_DURATION / period)
    interval = round((PUSH_DURATION + PAUSE_DURATION) / period)
    profile = np.zeros(count)
    shape = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    starts = range(interval - length, count - length, interval)
    for start in starts:
        profile[start : start + length] = shape
    return profile, [(start, start + length) for start in starts]


def smallest_force(force: Array, detected: Mask, probability: float = 0.95) -> tuple[float, float]:
    """Return the force [N] at which a logistic curve over log force reaches the wanted probability,
    and its standard error, by the likelihood's curvature (delta method).

    force: (M,) [N], of trial pushes; detected: (M,). Infinite if none was found.
    """
    if not detected.any():
        return np.inf, np.nan

    x = np.log(force)
    best = minimize(_cost, np.array([np.median(x[detected]), LOG_STEEPNESS]), args=(x, detected))
    middle, steepness = best.x
    # p = 1 / (1 + exp(-e^s (x - m))), solved for x = m + log(p / (1 - p)) e^-s
    reach = np.log(probability / (1 - probability)) * np.exp(-steepness)
    # dx/dm = 1, dx/ds = -log(p / (1 - p)) e^-s, and the force is e^x
    slope = np.array([1.0, -reach])
    place = np.exp(middle + reach)
    return float(place), float(place * np.sqrt(slope @ best.hess_inv @ slope))


def _cost(parameters: Array, x: Array, detected: Mask) -> float:
    """Return the negative log-likelihood, with a weak prior against perfect separation."""
    middle, steepness = parameters
    logit = np.exp(steepness) * (x - middle)
    likelihood = np.logaddexp(0, np.where(detected, -logit, logit)).sum()
    return float(likelihood + 0.5 * (steepness - LOG_STEEPNESS) ** 2)


def contacts(force: Array, least_force: float = TOUCH_FORCE) -> list[Span]:
    """Return contacts that reach a force. force: (N,) [N], of the sensor, NaN where unknown."""
    return spans(np.nan_to_num(force), least_force, RELEASE_FORCE)


def in_contact(force: Array) -> Mask:
    """Return the samples (N,) in contact; force: (N,) [N], of the sensor, NaN where unknown."""
    return np.asarray(force > CONTACT_FORCE)


def sensed_contact(force: Array, time: Array) -> Felt | None:
    """Return what a sensor reads, None if it has no reading.

    force: (N,) [N], of the sensor, NaN where unknown; time: (N,) [s].
    """
    if not np.isfinite(force).any():
        return None
    peak = int(np.nanargmax(force))
    share = float(in_contact(force).mean())
    return Felt(float(force[peak]), float(time[peak]), share, len(contacts(force, CONTACT_FORCE)))


def is_free(force: Array, period: float) -> Mask:
    """Return the samples (N,) without contact and half a second away from any.

    force: (N,) [N], of the sensor, NaN where unknown; period: [s].
    """
    reach = 2 * round(CONTACT_CLEARANCE / period) + 1
    touched = maximum_filter1d((force >= TOUCH_FORCE).astype(np.int8), reach, mode="nearest")
    return np.asarray((force < FREE_FORCE) & (touched == 0))


def force_alarms(force: Array, threshold: float) -> list[Span]:
    """Return the stretches that reach a threshold and last above two thirds of it, as contacts do
    at the sensor (3 and 2 N).

    force: (N,) [N], not negative, NaN where unknown; threshold: [N].
    """
    return spans(np.nan_to_num(force), threshold, threshold * RELEASE_FORCE / TOUCH_FORCE)


def force_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Return the threshold [N] down to which contact-free recordings raise few enough alarms.

    contact_free: force (N,) [N] of each recording, at its period [s]; per_minute: alarms allowed.
    From the largest force downwards, so that an alarm that never ends does not count as few. At
    least what counts as touched at the sensor, 3 N.
    """
    allowed = _allowed_alarms(contact_free, periods, per_minute)
    largest = max(float(np.nan_to_num(force).max()) for force in contact_free)
    lowest = max(TOUCH_FORCE, np.ceil(largest / THRESHOLD_STEP) * THRESHOLD_STEP + THRESHOLD_STEP)
    for threshold in np.arange(lowest, TOUCH_FORCE - THRESHOLD_STEP / 2, -THRESHOLD_STEP):
        if sum(len(force_alarms(force, threshold)) for force in contact_free) > allowed:
            break
        lowest = threshold
    return float(lowest)


def pushes_above(force: Array, sensed: Array, least_force: float, period: float) -> tuple[int, int]:
    """Return how many pushes reach a force at the sensor, and how many of them have an alarm of
    their own at this threshold.

    force, sensed: estimate and reading along one axis (N,) [N], NaN where unknown; least_force:
    [N]; period: [s].
    """
    pushes = spans(np.nan_to_num(np.abs(sensed)), least_force, RELEASE_FORCE)
    detection = compare(force_alarms(np.abs(force), least_force), pushes, period)
    return detection.contacts, detection.found
