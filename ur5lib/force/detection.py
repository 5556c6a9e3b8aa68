"""Contact or not: alarms, how they compare with a sensor, and the smallest force they find."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array, Mask

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


def raised_live(log_odds: Array, threshold: float) -> list[Span]:
    """Alarms as they are raised while a recording runs: from where the odds reach the threshold.

    log_odds: (N,), causal. `alarms` start earlier, where the odds began to rise.
    """
    return [
        (first + int(np.argmax(log_odds[first:last] >= threshold)), last)
        for first, last in alarms(log_odds, threshold)
    ]


def alarm_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Log-odds above which contact-free recordings raise at most so many alarms a minute.

    contact_free: log-odds (N,) of each recording, at its period [s]. At least 0: no contact is
    called where it is the less likely of both.
    """
    pairs = zip(contact_free, periods, strict=True)
    minutes = sum(len(odds) * period for odds, period in pairs) / 60
    allowed = int(per_minute * minutes)
    peaks = sorted(peak for odds in contact_free for peak in _peaks(odds))
    above = peaks[-allowed - 1] if allowed < len(peaks) else -np.inf
    return max(0.0, float(np.nextafter(above, np.inf)))


def _peaks(log_odds: Array) -> list[float]:
    """Largest value of each alarm there would be at a threshold of 0."""
    return [float(log_odds[first:last].max()) for first, last in alarms(log_odds, 0.0)]


@dataclass(frozen=True)
class Detection:
    """Alarms against contacts that a sensor saw, matched one to one.

    contacts, found: how many there were, and how many of them have an alarm of their own; alarms:
    how many there were, of them extra: within contacts, without one of their own; false: in no
    contact; delays: of each contact found, from its start to its alarm's [s], negative where the
    alarm is first (an offline estimate).
    """

    contacts: int
    found: int
    alarms: int
    extra: int
    false: int
    delays: Array

    def recall(self) -> float:
        """Share of contacts found."""
        return self.found / self.contacts if self.contacts else float("nan")

    def precision(self) -> float:
        """Share of alarms that are each a contact."""
        return self.found / self.alarms if self.alarms else float("nan")


def compare(alarm: list[Span], contact: list[Span], period: float) -> Detection:
    """Count which contacts have an alarm of their own, and which alarms have no contact.

    period: [s].
    """
    pairs = match(alarm, contact)
    late = np.array([alarm[i][0] - contact[j][0] for i, j in pairs], dtype=float)
    false = sum(not any(overlap(a, c) for c in contact) for a in alarm)
    extra = len(alarm) - false - len(pairs)
    return Detection(len(contact), len(pairs), len(alarm), extra, false, late * period)


def match(alarm: list[Span], contact: list[Span]) -> list[tuple[int, int]]:
    """As many pairs (i, j) of an alarm and a contact as overlap in time, each in one pair only.

    Of several ways, the one with the longest overlaps. So an alarm that never ends finds one
    contact, and what rings ten times in one contact rings nine times too often.
    """
    if not alarm or not contact:
        return []
    from scipy.optimize import linear_sum_assignment  # slow to import; most recordings need none

    shared = np.array([[overlap(a, c) for c in contact] for a in alarm])
    value = np.where(shared > 0, shared + shared.sum(), 0)  # one more pair is worth any overlap
    pairs = np.transpose(linear_sum_assignment(value, maximize=True)).tolist()
    return [(i, j) for i, j in pairs if shared[i, j]]


def overlap(one: Span, other: Span) -> int:
    """How many samples two stretches share."""
    return max(0, min(one[1], other[1]) - max(one[0], other[0]))


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
    places = [place for place in places if not any(overlap(alarm, place) for alarm in raised)]
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
            found[trial] = any(overlap(alarm, place) for alarm in told)
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
