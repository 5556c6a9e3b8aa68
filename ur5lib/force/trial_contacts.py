"""Trial contacts on a contact-free run: which of them the gate misses, by their size."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import PAUSE, PUSH
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import Noise
from ur5lib.force.missed_contacts import hiding, largest_missed
from ur5lib.force.residual_model import MISSED_TO, ResidualModel
from ur5lib.force.trial_pushes import felt_push
from ur5lib.force.wrench_estimate import STEP, used_rows
from ur5lib.timeseries.arrays import Array, Mask


class Tried(NamedTuple):
    """Samples in trial contacts: their size z (M,), and which were missed (M,)."""

    size: Array
    missed: Mask


def try_contacts(
    wrench_under: Callable[[Array], Array],
    run: ForceInput,
    jacobian: Array,
    model: ResidualModel,
    prior: ContactPrior,
    random: np.random.Generator,
) -> Tried:
    """Touch a contact-free run every three seconds with contacts of the usual size.

    wrench_under: estimate (N, 6) under an additional external torque (N, 6) [Nm]; jacobian:
    (M, 6, 6), at `used_rows`. Wrenches are drawn from the prior, and grow and fall as a
    raised cosine. At rest, dry friction bears up to a share of the breakaway torque, drawn for each
    contact and joint; in motion, gears take their part.
    """
    rows = used_rows(run.segment, run.period)
    states, posed = run.states[rows], finite_rows(jacobian.reshape(-1, 36))
    time = np.asarray(rows * run.period + random.uniform(0, PUSH + PAUSE), np.float64)
    # torque x of the contact, and what motors feel of it
    wrench = _drawn(time, prior, random)
    torque = np.matvec(np.where(posed[:, None, None], jacobian, 0.0).mT, wrench)
    gears = None if run.gears is None else run.gears.at(rows)
    felt = np.zeros_like(run.torque)
    felt[rows] = felt_push(torque, time, states, gears, prior.stiction * model.breakaway, random)
    # z² = xᵀ S⁻¹ x, and where the gate is shut
    load_std = np.zeros(states.shape) if run.doubt is None else np.nan_to_num(run.doubt[rows])
    hidden = hiding(states, Noise.of(states, model, prior, load_std))
    size = np.sqrt(np.vecdot(torque, np.linalg.solve(hidden, torque[..., None])[..., 0]))
    missed: Mask = ~np.asarray(wrench_under(felt)[rows].any(axis=1))
    touched: Mask = np.asarray(size > 0) & finite_rows(run.torque[rows])
    return Tried(size[touched], missed[touched])


def largest_of_trials(tried: Sequence[Tried]) -> float:
    """Return κ of the trials on several runs. All samples of one contact count as one trial."""
    size, missed = (np.concatenate(part) for part in zip(*tried, strict=True))
    return largest_missed(size, missed, STEP / PUSH, MISSED_TO)


def _drawn(time: Array, prior: ContactPrior, random: np.random.Generator) -> Array:
    """Return wrenches (M, 6) of trial contacts at some times (M,) [s]."""
    contact, after = np.divmod(time, PUSH + PAUSE)
    height = 0.5 - 0.5 * np.cos(2 * np.pi * np.maximum(after - PAUSE, 0.0) / PUSH)
    peaks = random.normal(size=(int(contact.max()) + 1, 6)) * np.sqrt(np.diag(prior.usual()))
    return height[:, None] * peaks[contact.astype(np.int64)]
