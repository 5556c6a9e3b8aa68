"""Contacts that hide in recordings to fit on: they count as no errors of a free arm."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.force_input import ForceInput
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.thresholds import alarms
from ur5lib.force.wrench_estimate import estimate_wrench, used_rows
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.premises import MARGIN
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span, inside_spans, within

MIN_DURATION = 0.3  # s; errors of friction at a stop or a reversal are shorter


class Fitted(NamedTuple):
    """A recording to fit on: its input, and the flange's pose."""

    input: ForceInput
    kinematics: Kinematics


def hidden_contacts(fitted: Fitted, model: ResidualModel, prior: ContactPrior) -> list[Span]:
    """Return the spans of contacts in a recording that should be free of them: alarms that last as
    long as a push, one with the typical force at least, the others with half of it.
    """
    run = fitted.input
    rows = used_rows(run.segment, run.period, model.cutoff)
    found = estimate_wrench(run, fitted.kinematics.anew(rows).jacobian, model, prior)
    force = np.nan_to_num(np.linalg.norm(found.wrench[:, :3], axis=1))
    sizes = {
        (first, last): float(force[first:last].max())
        for first, last in alarms(np.nan_to_num(found.log_odds, nan=-np.inf), 0.0)
        if (last - first) * run.period >= MIN_DURATION
    }
    if max(sizes.values(), default=0.0) < prior.force:
        return []
    return [span for span, size in sizes.items() if size >= prior.force / 2]


def without(run: ForceInput, contacts: Sequence[Span]) -> ForceInput:
    """Return an input whose torque is unknown in some contacts and MARGIN [s] around them."""
    margin = round(MARGIN / run.period)
    wider = [(max(first - margin, 0), last + margin) for first, last in contacts]
    touched = inside_spans(wider, len(run.torque))
    return replace(run, torque=np.where(touched[:, None], np.nan, run.torque))


def untouched_odds(odds: Array, time: Array, contacts: Sequence[tuple[float, float]]) -> Array:
    """Return log-odds (N,) of contact, minus infinity in contacts, from and to [s]; time: (N,)."""
    return np.where(within(time, contacts, MARGIN), -np.inf, odds)
