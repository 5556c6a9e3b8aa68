"""The threshold of each estimate at which contact-free recordings raise few alarms.

It is on the log-odds of contact or, for the controller's and the thesis's estimates, on |F| [N].
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from ur5lib.force.controller import further_or_controller
from ur5lib.force.estimators import GATED, PUBLISHED
from ur5lib.force.hidden_contacts import untouched_odds
from ur5lib.force.residual_model import Residuals
from ur5lib.force.thresholds import alarm_threshold, force_threshold
from ur5lib.records.forces import Forces, FurtherForces
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

Evidence = list[tuple[Mapping[str, Array], float]]  # by estimate, and period [s]; by recording


@step("arm", "threshold.json", recordings="fit", arm="described")
def set_threshold(
    forces: Mapping[str, Forces],
    signals: Mapping[str, Signals],
    residuals: Residuals,
    arm: Robot,
    false_alarms_per_min: float,
    further: Mapping[str, FurtherForces] | None = None,
) -> dict[str, float]:
    """Return by estimate the threshold above which it raises an alarm.

    forces, signals, further: of the arm's `fit` recordings; without `further`, the controller's
    estimate takes its place. Contacts that hide in them, by `residuals`, do not count.
    """
    odds: Evidence = [
        (_free_odds(one, residuals.contacts.get(name, [])), one.period)
        for name, one in forces.items()
    ]
    rate = false_alarms_per_min
    found = thresholds(GATED, odds, alarm_threshold, rate)
    # without odds of contact, no force is stated, and there is nothing to compare with the
    # published ones
    if found:
        known = further or {}
        sizes: Evidence = []
        for name, one in forces.items():
            stated = further_or_controller(known.get(name), arm, signals[name])
            sizes.append((force_sizes(stated.corrected), one.period))
        found |= thresholds([*PUBLISHED], sizes, force_threshold, rate)
    return found


def _free_odds(forces: Forces, contacts: Sequence[tuple[float, float]]) -> dict[str, Array]:
    """Return the log-odds of each estimate without some contacts, from and to [s]."""
    since = forces.time - forces.time[0]
    return {name: untouched_odds(own, since, contacts) for name, own in forces.log_odds.items()}


def force_sizes(wrenches: Mapping[str, Array]) -> dict[str, Array]:
    """Return the magnitudes (N,) [N] of the forces of wrenches (N, 6), by name."""
    return {name: np.linalg.norm(own[:, :3], axis=1) for name, own in wrenches.items()}


def thresholds(
    names: Iterable[str],
    evidence: Evidence,
    of: Callable[[list[Array], list[float], float], float],
    rate: float,
) -> dict[str, float]:
    """Return the threshold of each estimate that any recording has.

    evidence: for each recording, log-odds or forces (N,) by estimate, and its period [s]; of:
    function that returns the threshold from these of all recordings; rate: allowed alarms a minute.
    """
    result = {}
    for name in sorted(names):
        known = [(one[name], period) for one, period in evidence if name in one]
        if known:
            values, periods = zip(*known, strict=True)
            result[name] = of([*values], [*periods], rate)
    return result
