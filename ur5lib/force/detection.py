"""Contact or not: alarms, how they compare with a sensor, and the smallest force they find."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Span = tuple[int, int]  # first sample, and the one after the last

HYSTERESIS = 2.0  # in log-odds: what an alarm may lose before it ends
PUSH, PAUSE = 1.0, 2.0  # s, of trial pushes
STEEPNESS = 1.5  # log of the logistic slope: from 25 to 75 % found within a factor of 1.6


def spans(signal: Array, on: float, off: float) -> list[Span]:
    """Stretches that reach `on`, as far as they stay above `off` on both sides. signal: (N,)."""
    above = np.concatenate([[False], signal > off, [False]])
    edges = np.flatnonzero(np.diff(above.astype(np.int64)))
    stretches = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(first, last) for first, last in stretches if signal[first:last].max() >= on]


def alarms(log_odds: Array, threshold: float) -> list[Span]:
    """Contacts by their log-odds (N,)."""
    return spans(log_odds, threshold, threshold - HYSTERESIS)


def alarm_threshold(contact_free: list[Array], period: float, per_minute: float) -> float:
    """Log-odds above which contact-free recordings raise at most so many alarms a minute.

    contact_free: log-odds (N,) of each recording; period: [s]. At least 0: no contact is called
    where it is the less likely of both.
    """
    minutes = sum(len(odds) for odds in contact_free) * period / 60
    allowed = int(per_minute * minutes)
    peaks = sorted(peak for odds in contact_free for peak in _peaks(odds))
    above = peaks[-allowed - 1] if allowed < len(peaks) else -np.inf
    return max(0.0, float(np.nextafter(above, np.inf)))


def _peaks(log_odds: Array) -> list[float]:
    """Largest value of each alarm there would be at a threshold of 0."""
    return [float(log_odds[first:last].max()) for first, last in alarms(log_odds, 0.0)]


@dataclass(frozen=True)
class Detection:
    """Alarms against contacts that a sensor saw.

    contacts, found: how many there were, and how many of them an alarm overlaps; alarms, false:
    how many alarms, and how many of them no contact overlaps; delays: of each contact found, from
    its start to its alarm [s], negative where the alarm is first (the estimate is offline).
    """

    contacts: int
    found: int
    alarms: int
    false: int
    delays: Array

    def recall(self) -> float:
        """Share of contacts found."""
        return self.found / self.contacts if self.contacts else float("nan")

    def precision(self) -> float:
        """Share of alarms that are contacts."""
        return 1 - self.false / self.alarms if self.alarms else float("nan")


def compare(
    alarm: list[Span], strong: list[Span], any_contact: list[Span], period: float
) -> Detection:
    """Count what was found of the strong contacts, and alarms that meet no contact at all."""
    hits = [[a for a in alarm if _overlap(a, contact)] for contact in strong]
    late = [meet[0][0] - contact[0] for contact, meet in zip(strong, hits, strict=True) if meet]
    false = sum(not any(_overlap(a, contact) for contact in any_contact) for a in alarm)
    return Detection(len(strong), len(late), len(alarm), false, np.array(late) * period)


def _overlap(one: Span, other: Span) -> bool:
    return one[0] < other[1] and other[0] < one[1]


def receiver_curve(log_odds: Array, contact: Mask) -> tuple[Array, Array]:
    """ROC by sample: false alarm rate and detection rate, (N + 1,) each, thresholds falling."""
    order = np.argsort(-log_odds)
    hits = np.concatenate([[0], np.cumsum(contact[order])])
    misses = np.concatenate([[0], np.cumsum(~contact[order])])
    return misses / max(misses[-1], 1), hits / max(hits[-1], 1)


@dataclass(frozen=True)
class SmallestForce:
    """Force [N] that is found with the stated probability, and its standard error."""

    force: float
    std: float


def pushes(count: int, period: float) -> tuple[Array, list[Span]]:
    """Raised-cosine pushes of height 1, one after each pause: profile (N,), and where they are."""
    length, every = round(PUSH / period), round((PUSH + PAUSE) / period)
    profile = np.zeros(count)
    shape = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    starts = range(every - length, count - length, every)
    for start in starts:
        profile[start : start + length] = shape
    return profile, [(start, start + length) for start in starts]


def try_pushes(
    log_odds_of: Callable[[Array], Array],
    jacobian: Array,
    direction: Array,
    force: Array,
    period: float,
    threshold: float,
    raised: list[Span],
) -> Mask:
    """Which of the trial pushes put onto a contact-free recording raise an alarm: (M,).

    log_odds_of: log-odds (N,) of the recording with an external torque (N, 6) added to its own;
    jacobian: (N, 6, 6); direction: wrench (6,) of 1 N, base axes, at the origin of frame 6; force:
    (M,) [N], at the height of each push; period: [s]; raised: alarms of the recording as it is, at
    which none is tried: where it always is in alarm, none is found. It takes as many rounds as the
    pushes need.
    Stiction, which hides pushes at rest, is not simulated: the recording should be in motion.
    """
    profile, places = pushes(len(jacobian), period)
    places = [place for place in places if not any(_overlap(alarm, place) for alarm in raised)]
    found = np.zeros(len(force), bool)
    if not places:
        return found
    unit = profile[:, None] * (jacobian.mT @ direction)
    for first in range(0, len(force), len(places)):
        size = np.zeros(len(profile))
        part = range(first, min(first + len(places), len(force)))
        for trial, place in zip(part, places, strict=False):
            size[slice(*place)] = force[trial]
        told = alarms(log_odds_of(size[:, None] * unit), threshold)
        for trial, place in zip(part, places, strict=False):
            found[trial] = any(_overlap(alarm, place) for alarm in told)
    return found


def smallest_force(force: Array, found: Mask, wanted: float = 0.95) -> SmallestForce:
    """Where a logistic curve over the logarithm of the force reaches the wanted probability.

    force: (M,) [N], of trial pushes; found: (M,). Infinite when none was found; the standard
    error follows from the likelihood's curvature (delta method).
    """
    if not found.any():
        return SmallestForce(np.inf, np.nan)
    from scipy.optimize import minimize  # as slow to import as pandas; most recordings need none

    x = np.log(force)
    best = minimize(_cost, np.array([np.median(x[found]), STEEPNESS]), args=(x, found))
    middle, steepness = best.x
    reach = np.log(wanted / (1 - wanted)) * np.exp(-steepness)
    slope = np.array([1.0, -reach])
    place = np.exp(middle + reach)
    return SmallestForce(float(place), float(place * np.sqrt(slope @ best.hess_inv @ slope)))


def _cost(parameters: Array, x: Array, found: Mask) -> float:
    """Negative log-likelihood, with a weak prior that keeps perfect separation finite."""
    middle, steepness = parameters
    logit = np.exp(steepness) * (x - middle)
    likelihood = np.logaddexp(0, np.where(found, -logit, logit)).sum()
    return float(likelihood + 0.5 * (steepness - STEEPNESS) ** 2)
