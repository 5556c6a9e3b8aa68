"""The contacts that the live estimator finds in a recording, compared with those at the sensor."""

from dataclasses import fields
from typing import Any

import numpy as np

from ur5lib.force.alarms import matched
from ur5lib.force.estimators import LEADING
from ur5lib.records.contacts import Contact, Contacts
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.step import step
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import Span, runs
from ur5lib.topics.live.rows import LiveDetection, LiveForces

NAMES = [field.name for field in fields(LiveDetection)]


@step("recording", "live_detection.csv", live="live_forces")
def count_live_contacts(
    live: LiveForces, sensor: SensorWrenches, contacts: Contacts
) -> list[LiveDetection]:
    """Return the numbers of contacts at the sensor and of found ones, by the force that they reach.

    contacts: by the offline estimates; the leading one also finds loads and contacts off the
    flange, which a sensor does not feel. Empty if the estimator states nothing.
    """
    if live.contact is None or live.known is None:
        return []
    unfelt = [
        samples_of(one, live.time)
        for one in contacts.contacts
        if one.estimate == LEADING and (one.kind == "load" or one.off_flange)
    ]
    raised = [(first, last) for first, last in runs(live.contact).tolist()]
    own: Any = {"unknown": 1.0 - float(live.known.mean())}
    own |= hidden(live, live.known & ~live.contact)
    return [
        LiveDetection(**{name: row[name] for name in NAMES if name in row}, **own)
        for row in matched(raised, sensor, unfelt).rows()
    ]


def hidden(live: LiveForces, free: Mask) -> dict[str, float]:
    """Return the median contact [N] that could be hidden at free samples, by column; empty without
    such samples.

    free: (N,), where no contact is stated.
    """
    limits = {"hidden_n": live.hidden, "hidden_at_all_n": live.hidden_at_all}
    return {
        name: float(np.median(limit.max(axis=1)[free]))
        for name, limit in limits.items()
        if limit is not None and free.any()
    }


def samples_of(alarm: Contact, time: Array) -> Span:
    """Return first and last sample of an alarm; time: (N,) [s]."""
    return int(np.searchsorted(time, alarm.start_s)), int(np.searchsorted(time, alarm.end_s)) + 1
