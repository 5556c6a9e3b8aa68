"""The live estimator's answers to a recording, and the rows of its tables."""

from dataclasses import dataclass

import numpy as np

from ur5lib.records.forces import AXES
from ur5lib.records.pushes import SmallestPush
from ur5lib.records.table import WRENCH, SegmentedTable, channel
from ur5lib.records.verdicts import FalseAlarms
from ur5lib.timeseries.arrays import Array, Mask


@dataclass(frozen=True, kw_only=True)
class LiveForces(SegmentedTable):
    """The live estimator's answers to a recording, fed sample by sample; None without a force.

    wrench, std: as in `Forces`, (N, 6) [N, Nm]; evidence: (N,), log-odds of a contact; contact:
    (N,), whether a contact is stated; known: (N,), whether contact is decided; untouched, hidden,
    hidden_at_all: (N, 3) [N], as of `Answer`; link, off_flange: (N,), as of it, NaN without a
    contact in motion.
    """

    wrench: Array | None = channel("live", "N, Nm", WRENCH, optional=True)
    std: Array | None = channel("live_std", "N, Nm", WRENCH, optional=True)
    evidence: Array | None = channel("evidence", "1", optional=True)
    contact: Mask | None = channel("contact", "1", optional=True, dtype=np.bool_)
    known: Mask | None = channel("known", "1", optional=True, dtype=np.bool_)
    untouched: Array | None = channel("untouched", "N", AXES, optional=True)
    hidden: Array | None = channel("hidden", "N", AXES, optional=True)
    hidden_at_all: Array | None = channel("hidden_at_all", "N", AXES, optional=True)
    link: Array | None = channel("link", "1", optional=True)
    off_flange: Array | None = channel("off_flange", "1", optional=True)


@dataclass(frozen=True, kw_only=True)
class LiveDetection:
    """A row of live_detection.csv: contacts at the sensor of a recording that reach a force, and
    how many of them the live estimator finds; without a sensor, no force and no contacts.

    force_class_n: [N]; merged: within the alarm of another contact; median_delay_s: [s] of the
    found ones; false_alarms_per_min, alarms_per_min: of the whole recording; unknown: share of the
    time in which the estimator does not know; hidden_n: [N], while no contact is stated, the median
    contact along an axis that could be hidden, and hidden_at_all_n, also one that began earlier.
    """

    force_class_n: float | None = None
    contacts: int | None = None
    found: int | None = None
    merged: int | None = None
    median_delay_s: float | None = None
    false_alarms_per_min: float | None = None
    alarms_per_min: float
    unknown: float
    hidden_n: float | None = None
    hidden_at_all_n: float | None = None


@dataclass(frozen=True, kw_only=True)
class LiveFalseAlarms(FalseAlarms):
    """A row of live_false_alarms.csv: alarms of the live estimator where nothing touches the arm.

    minutes: in which it knows; unknown: share of the time in which it does not.
    """

    unknown: float


@dataclass(frozen=True, kw_only=True)
class LivePush(SmallestPush):
    """A row of live_pushes.csv: as in pushes.csv, the push along an axis that the live estimator
    finds with 95 % while it lasts.

    blind: of the trials, those where joints feel almost no push, or the estimator knows nothing.
    """
