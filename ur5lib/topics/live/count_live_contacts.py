"""The contacts that the live estimator states in a recording, beside those at the sensor."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ur5lib.force.alarms import matched, not_felt
from ur5lib.force.estimators import LEADING
from ur5lib.records.contacts import Alarm, Detected, Matched
from ur5lib.records.forces import SensorWrenches
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span, runs
from ur5lib.topics.live.rows import LiveDetection, LiveForces


def count_live_contacts(
    live: LiveForces, sensor: SensorWrenches, contacts: Mapping[str, Detected]
) -> list[LiveDetection]:
    """Return how many contacts at the sensor are found, by the force that they reach.

    contacts: by all estimates of the whole recording, whose leading one finds loads and contacts
    off the flange, which a sensor does not feel. Empty where the estimator states nothing.
    """
    if live.contact is None or live.known is None:
        return []
    alarms = contacts[LEADING].raised if LEADING in contacts else []
    unfelt = not_felt([*_spans(alarms, live.time)], alarms)
    raised = [(first, last) for first, last in runs(live.contact).tolist()]
    return [*_rows(matched(raised, sensor, unfelt), 1.0 - float(live.known.mean()))]


def _spans(alarms: Iterable[Alarm], time: Array) -> Iterator[Span]:
    """Yield the samples of alarms; time: (N,) [s]."""
    for alarm in alarms:
        yield int(np.searchsorted(time, alarm.start)), int(np.searchsorted(time, alarm.end)) + 1


def _rows(found: Matched, unknown: float) -> Iterator[LiveDetection]:
    rates: Any = {"alarms_per_min": found.alarms_per_min, "unknown": unknown}
    rates |= {"false_alarms_per_min": found.false_per_min}
    if not found.classes:
        yield LiveDetection(**rates)
    for reached in found.classes:
        yield LiveDetection(
            force_class_n=reached.force,
            contacts=reached.contacts,
            found=reached.found,
            merged=reached.merged,
            median_delay_s=reached.median_delay,
            **rates,
        )
