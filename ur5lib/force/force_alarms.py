"""Alarms of an estimate that states a force but no odds: its size passes a threshold."""

import numpy as np

from ur5lib.force.detection import Span, compare, spans
from ur5lib.force.sensed_contacts import RELEASE, TOUCH
from ur5lib.timeseries.arrays import Array

STEP = 0.5  # N, between the thresholds tried


def force_alarms(force: Array, threshold: float) -> list[Span]:
    """Return the stretches that reach a threshold and last above two thirds of it, as contacts do
    at the sensor (3 and 2 N).

    force: (N,) [N], not negative, NaN where unknown; threshold: [N].
    """
    return spans(np.nan_to_num(force), threshold, threshold * RELEASE / TOUCH)


def force_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Return the threshold [N] down to which contact-free recordings raise few enough alarms.

    contact_free: force (N,) [N] of each recording, at its period [s]; per_minute: alarms allowed.
    From the largest force downwards, so that an alarm that never ends does not count as few. At
    least what counts as touched at the sensor, 3 N.
    """
    pairs = zip(contact_free, periods, strict=True)
    allowed = int(per_minute * sum(len(force) * period for force, period in pairs) / 60)
    largest = max(float(np.nan_to_num(force).max()) for force in contact_free)
    lowest = max(TOUCH, np.ceil(largest / STEP) * STEP + STEP)
    for threshold in np.arange(lowest, TOUCH - STEP / 2, -STEP):
        if sum(len(force_alarms(force, threshold)) for force in contact_free) > allowed:
            break
        lowest = threshold
    return float(lowest)


def pushes_above(force: Array, sensed: Array, least: float, period: float) -> tuple[int, int]:
    """Return how many pushes reach a force at the sensor, and how many of them have an alarm of
    their own at this threshold.

    force, sensed: estimate and reading along one axis (N,) [N], NaN where unknown; least: [N];
    period: [s].
    """
    pushes = spans(np.nan_to_num(np.abs(sensed)), least, RELEASE)
    found = compare(force_alarms(np.abs(force), least), pushes, period)
    return found.contacts, found.found
