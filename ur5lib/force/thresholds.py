"""Alarms above a threshold, and the threshold that raises few enough of them without contact."""

import numpy as np

from ur5lib.force.sensed_contact import RELEASE_FORCE, TOUCH_FORCE
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span, spans

ALARM_HYSTERESIS = 2.0  # an alarm ends this far below the threshold, in log-odds
THRESHOLD_STEP = 0.5  # N; the tried thresholds of forces are this far apart


def alarms(log_odds: Array, threshold: float) -> list[Span]:
    """Return the spans of alarms, from where log-odds of contact (N,) reach the threshold until
    they are ALARM_HYSTERESIS below it.
    """
    return spans(log_odds, threshold, threshold - ALARM_HYSTERESIS)


def force_alarms(force: Array, threshold: float) -> list[Span]:
    """Return the spans of alarms, in which a force reaches a threshold and stays above two thirds
    of it, as contacts do at the sensor (3 and 2 N).

    force: (N,) [N], not negative, NaN where unknown; threshold: [N].
    """
    return spans(np.nan_to_num(force), threshold, threshold * RELEASE_FORCE / TOUCH_FORCE)


def alarm_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Return the log-odds above which contact-free recordings raise few enough alarms.

    contact_free: log-odds (N,) of each recording, at its period [s]; per_minute: alarms allowed.
    The result is at least 0, even odds.
    """
    allowed = _allowed_alarms(contact_free, periods, per_minute)
    peaks = sorted(
        float(odds[slice(*alarm)].max()) for odds in contact_free for alarm in alarms(odds, 0.0)
    )
    # the highest peak of one alarm too many
    above = peaks[-allowed - 1] if allowed < len(peaks) else -np.inf
    return max(0.0, float(np.nextafter(above, np.inf)))


def force_threshold(contact_free: list[Array], periods: list[float], per_minute: float) -> float:
    """Return the lowest threshold [N] with which contact-free recordings raise few enough alarms.

    contact_free: force (N,) [N] of each recording, at its period [s]; per_minute: alarms allowed.
    Thresholds are tried from the largest force downwards, so that an alarm that never ends does not
    count as few. The result is at least TOUCH_FORCE.
    """
    allowed = _allowed_alarms(contact_free, periods, per_minute)
    largest = max(float(np.nan_to_num(force).max()) for force in contact_free)
    lowest = max(TOUCH_FORCE, np.ceil(largest / THRESHOLD_STEP) * THRESHOLD_STEP + THRESHOLD_STEP)
    for threshold in np.arange(lowest, TOUCH_FORCE - THRESHOLD_STEP / 2, -THRESHOLD_STEP):
        if sum(len(force_alarms(force, threshold)) for force in contact_free) > allowed:
            break
        lowest = threshold
    return float(lowest)


def _allowed_alarms(contact_free: list[Array], periods: list[float], per_minute: float) -> int:
    """Return the number of alarms that all recordings together may raise; contact_free: (N,) each;
    periods: [s].
    """
    pairs = zip(contact_free, periods, strict=True)
    return int(per_minute * sum(len(values) * period for values, period in pairs) / 60)
