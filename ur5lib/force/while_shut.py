"""What is stated of the wrench while the gate is shut: its band, the band if nothing has touched,
and how large a contact could be hidden.
"""

from typing import Any, NamedTuple

import numpy as np

from ur5lib.force.contact_wrench import regularised_wrench, static_wrench
from ur5lib.force.external_torque import is_still
from ur5lib.force.gate import Observations, diagonal
from ur5lib.force.missed_contacts import (
    MISSED_DEVIATIONS,
    missed_contacts,
    mixture_std,
    probability_while_shut,
)
from ur5lib.records.forces import Forces
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import spans

# The mean background of a rest's first part stands for that before a press; s.
REFERENCE_DURATION = 1.0
# Not at all in rests of up to the first duration, whose beginning a press may fill; wholly from the
# second on; s.
SHORT_REST, LONG_REST = 2.0, 6.0
NORMAL99 = 2.576  # this many standard deviations to either side of the mean contain 99 %


class WhileShut(NamedTuple):
    """What is stated at each sample while the gate is shut.

    std: (n, 6) [N, Nm], standard deviation of the wrench of a free arm, of a missed contact, or of
    a press since the arm came to rest; untouched: (n, 3) [N], half of the 95 % band of the force if
    nothing has touched since then; hidden: (n, 3) [N], up to which contacts and presses since then
    are missed; hidden_at_all: (n, 3) [N], likewise those that began before. press: (n, 6) [N, Nm],
    the wrench of a slow press since the arm came to rest that would explain the background.
    """

    std: Array
    untouched: Array
    hidden: Array
    hidden_at_all: Array
    press: Array


def while_shut(
    observations: Observations, background: Array, contact_probability: Array, inside: Mask
) -> WhileShut:
    """Return what is stated while the gate is shut.

    background: (n, joints) [Nm]; contact_probability: of contact by the gate (n,); inside: which
    samples are in contacts (n,).
    """
    model, prior, noise = observations.model, observations.prior, observations.noise
    hiding = (model.doubt * MISSED_DEVIATIONS) ** 2 * noise.hiding()
    share, missed = missed_contacts(observations.jacobian, hiding, prior)
    probability = probability_while_shut(share, inside, observations.period, prior)
    free = np.diagonal(observations.quiet)
    mixture = mixture_std(np.maximum(probability, contact_probability[:, None]), missed, free)
    press = _slow_press(observations, _since_rest(observations, background))
    at_all = np.maximum(np.abs(press), np.abs(_slow_press(observations, background)))
    std = np.hypot(mixture, model.doubt * press)
    resting = noise.still.all(axis=1, keepdims=True)
    return WhileShut(
        std=std,
        untouched=NORMAL95
        * np.where(resting, np.minimum(_fast_error(observations), std), std)[:, :3],
        hidden=NORMAL99 * np.hypot(np.sqrt(missed), model.doubt * press)[:, :3],
        hidden_at_all=NORMAL99 * np.hypot(np.sqrt(missed), model.doubt * at_all)[:, :3],
        press=press,
    )


def usual_limits(forces: Forces) -> dict[str, Any]:
    """Return, as columns of `Detection`, what is stated at most samples without a contact: medians
    [N] of the largest axis; empty where nothing is stated.
    """
    stated = forces.untouched, forces.hidden, forces.hidden_at_all
    names = "untouched_n", "hidden_n", "hidden_at_all_n"
    return {
        name: float(np.median(limit[shut].max(axis=1)))
        for name, limit in zip(names, stated, strict=True)
        if limit is not None and forces.if_untouched is not None
        if (shut := forces.if_untouched & np.isfinite(limit).all(axis=1)).any()
    }


def _fast_error(observations: Observations) -> Array:
    """Return the deviation (n, 6) of a usual contact's wrench that the fast error leaves unknown.

    Without the prior, it would have no bound where the arm is singular.
    """
    quick = observations.model.doubt**2 * observations.noise.quick
    estimate = regularised_wrench(
        np.zeros_like(quick), observations.jacobian, diagonal(quick), observations.prior.usual()
    )
    return np.sqrt(np.linalg.diagonal(estimate.covariance))


def _since_rest(observations: Observations, background: Array) -> Array:
    """Return the change (n, joints) [Nm] of the background since the whole arm came to rest; of a
    short rest, the whole background.
    """
    resting = is_still(observations.states) & observations.posed
    samples = max(1, round(REFERENCE_DURATION / observations.period))
    changed = background.copy()
    for first, last in spans(resting.astype(float), 0.5, 0.5):
        duration, beginning = (last - first) * observations.period, slice(first, first + samples)
        share = np.interp(duration, (SHORT_REST, LONG_REST), (0.0, 1.0))
        changed[first:last] -= share * background[beginning].mean(axis=0)
    return changed


def _slow_press(observations: Observations, background: Array) -> Array:
    """Return the wrench (n, 6) of a slow press that would cause a background (n, joints) [Nm] while
    the whole arm rests without a tare; zero elsewhere.
    """
    resting = is_still(observations.states)
    wrench = np.zeros((len(background), 6))
    if resting.any():
        std = np.sqrt(observations.noise.spread[resting])
        wrench[resting], _ = static_wrench(
            background[resting],
            std,
            observations.jacobian[resting],
            observations.prior.force,
        )
    return wrench
