"""Alarms matched with contacts: what was found, missed and false."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import Span, overlap


@dataclass(frozen=True)
class Detection:
    """Counts of alarms and of a sensor's contacts, matched one to one.

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
    """Return the counts of alarms and contacts matched one to one; period: [s]."""
    pairs = match(alarm, contact)
    late = np.array([alarm[i][0] - contact[j][0] for i, j in pairs], dtype=float)
    false = sum(not any(overlap(a, c) for c in contact) for a in alarm)
    extra = len(alarm) - false - len(pairs)
    merged = sum(any(overlap(a, c) for a in alarm) for c in contact) - len(pairs)
    return Detection(len(contact), len(pairs), merged, len(alarm), extra, false, late * period)


def match(alarm: list[Span], contact: list[Span]) -> list[tuple[int, int]]:
    """Return pairs (i, j) of alarms i and contacts j that overlap in time, each in at most one
    pair.

    The assignment has as many pairs as possible, and among those, the longest overlaps. So an alarm
    that never ends finds one contact, and of ten alarms in one contact nine are extra.
    """
    if not alarm or not contact:
        return []

    shared = np.array([[overlap(a, c) for c in contact] for a in alarm])
    value = np.where(shared > 0, shared + shared.sum(), 0)  # one more pair is worth any overlap
    pairs = np.transpose(linear_sum_assignment(value, maximize=True)).tolist()
    return [(i, j) for i, j in pairs if shared[i, j]]


def receiver_curve(log_odds: Array, contact: Mask) -> tuple[Array, Array]:
    """Return the ROC curve by sample: rates of false alarms and of detection (N + 1,), from the
    highest threshold to the lowest.
    """
    order = np.argsort(-log_odds)
    hits = np.concatenate([[0], np.cumsum(contact[order])])
    misses = np.concatenate([[0], np.cumsum(~contact[order])])
    return misses / max(misses[-1], 1), hits / max(hits[-1], 1)
