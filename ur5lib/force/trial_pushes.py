"""Trial pushes on a contact-free motion: which are detected, by the speed of the flange."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.force.detection import Span, alarms, overlap, pushes
from ur5lib.timeseries.arrays import Array, Mask

LEAST, MOST = 5.0, 100.0  # N, of trial pushes


@dataclass(frozen=True)
class Trials:
    """Peaks (M,) [N] of trial pushes, the flange's mean speed (M,) [m/s] meanwhile, and which were
    detected (M,).
    """

    force: Array
    speed: Array
    found: Mask

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Return the trials of several recordings."""
        names = ("force", "speed", "found")
        return cls(*(np.concatenate([getattr(own, name) for own in parts]) for name in names))

    def within(self, low: float, high: float) -> "Trials":
        """Return the trials at speeds from `low` to below `high` [m/s]."""
        chosen = (self.speed >= low) & (self.speed < high)
        return Trials(self.force[chosen], self.speed[chosen], self.found[chosen])


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
    during which no push is tried; random: deals out peaks and axes. Dry friction, which bears a
    part of a push at rest, is not simulated.
    """
    profile, places = pushes(len(jacobian), period)
    means = [float(speed[slice(*place)].mean()) for place in places]
    free = [
        (place, mean)
        for place, mean in zip(places, means, strict=True)
        if np.isfinite(mean) and not any(overlap(alarm, place) for alarm in raised)
    ]
    peaks = random.permutation(np.geomspace(LEAST, MOST, len(free)))
    axes = random.permutation(np.arange(len(free)) % 3)
    force = np.zeros((len(profile), 3))
    for (place, _), peak, axis in zip(free, peaks, axes, strict=True):
        force[slice(*place), axis] = peak * profile[slice(*place)]
    torque = np.matvec(jacobian[:, :3].mT, force)
    answers = alarms(log_odds_of(torque), threshold) if free else []
    found = [any(overlap(alarm, place) for alarm in answers) for place, _ in free]
    return Trials(peaks, np.array([mean for _, mean in free]), np.array(found, bool))
