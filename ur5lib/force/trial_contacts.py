"""Trial contacts on contact-free recordings: which the gate finds, by axis, speed and size."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import PAUSE, PUSH, Span, alarms, overlap, pushes
from ur5lib.force.external_torque import STILL, States, finite_rows
from ur5lib.force.force_input import ForceInput, Gears
from ur5lib.force.gate import Observations
from ur5lib.force.missed_contacts import largest_missed
from ur5lib.force.residual_model import MISSED_TO, ResidualModel
from ur5lib.force.wrench_estimate import thinning, used_rows
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.sampling import STEP

LEAST, MOST = 5.0, 100.0  # N, of trial pushes


@dataclass(frozen=True)
class Trials:
    """Peaks (M,) [N] of trial pushes, along x, y or z of the base (M,), 0 to 2, the flange's mean
    speed (M,) [m/s] meanwhile, and which were detected (M,).
    """

    force: Array
    axis: Labels
    speed: Array
    found: Mask

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Return the trials of several recordings."""
        names = ("force", "axis", "speed", "found")
        return cls(*(np.concatenate([getattr(own, name) for own in parts]) for name in names))

    def within(self, low: float, high: float) -> "Trials":
        """Return the trials at speeds from `low` to below `high` [m/s]."""
        return self._where((self.speed >= low) & (self.speed < high))

    def along(self, axis: int) -> "Trials":
        """Return the trials along one axis."""
        return self._where(self.axis == axis)

    def _where(self, chosen: Mask) -> "Trials":
        return Trials(self.force[chosen], self.axis[chosen], self.speed[chosen], self.found[chosen])


def felt_push(
    torque: Array,
    time: Array,
    states: States,
    gears: Gears | None,
    most: Array,
    random: np.random.Generator,
) -> Array:
    """Return what the motors feel of the torque (N, 6) [Nm] of pushes: less what friction bears.

    In motion, gears lose a part of it; at rest, dry friction bears a share of what it can, drawn
    for each push and joint. time: (N,) [s]; most: (6,) [Nm], that friction bears.
    """
    push = (time // (PUSH + PAUSE)).astype(np.int64)
    bears = random.uniform(size=(push.max(initial=0) + 1, len(most)))[push] * most
    resting = torque - np.clip(torque, -bears, bears)
    moving = torque if gears is None else gears.where_moving(states).felt(torque)
    return np.where(states == STILL, resting, moving)


def try_each_place(
    log_odds_of: Callable[[Array], Array],
    jacobian: Array,
    speed: Array,
    period: float,
    threshold: float,
    raised: list[Span],
    random: np.random.Generator,
) -> Trials:
    """Push once at each place of a contact-free recording, along the base's x, y or z.

    log_odds_of: log-odds (N,) of contact with an additional external torque (N, 6) [Nm]; jacobian:
    (N, 6, 6); speed: of the flange (N,) [m/s]; period: [s]; raised: alarms of the recording itself,
    during which no push is tried; random: deals out peaks and axes.
    """
    profile, places = pushes(len(jacobian), period)
    means = [float(speed[slice(*place)].mean()) for place in places]
    free = [
        (place, mean)
        for place, mean in zip(places, means, strict=True)
        if np.isfinite(mean) and not any(overlap(alarm, place) for alarm in raised)
    ]
    peaks = random.permutation(np.geomspace(LEAST, MOST, len(free)))
    axes = random.permutation((random.integers(3) + np.arange(len(free))) % 3)
    force = np.zeros((len(profile), 3))
    for (place, _), peak, axis in zip(free, peaks, axes, strict=True):
        force[slice(*place), axis] = peak * profile[slice(*place)]
    torque = np.matvec(jacobian[:, :3].mT, force)
    answers = alarms(log_odds_of(torque), threshold) if free else []
    found = [any(overlap(alarm, place) for alarm in answers) for place, _ in free]
    return Trials(peaks, axes, np.array([mean for _, mean in free]), np.array(found, bool))


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
    seen = Observations.of(run.thinned(thinning(run.period), rows), jacobian, model, prior)
    time = np.asarray(rows * run.period + random.uniform(0, PUSH + PAUSE), np.float64)
    # torque x of the contact, and what motors feel of it
    wrench = _drawn(time, prior, random)
    torque = np.matvec(seen.jacobian.mT, wrench)
    gears = None if run.gears is None else run.gears.at(rows)
    felt = np.zeros_like(run.torque)
    felt[rows] = felt_push(
        torque, time, seen.states, gears, prior.stiction * model.breakaway, random
    )
    # z² = xᵀ S⁻¹ x, and where the gate is shut
    weighted = np.linalg.solve(seen.noise.hiding(), torque[..., None])[..., 0]
    size = np.sqrt(np.vecdot(torque, weighted))
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
