"""Which recordings pass the same trajectory: those are one sample of the world, not two."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ur5lib.timeseries.arrays import Array, Labels, Mask

NEAR_POSITION, NEAR_VELOCITY = 0.02, 0.1  # rad, rad/s: the root sum of squares over all joints
SLOW = 0.03  # rad/s, below which a joint may as well rest
SAME = 0.9  # share of a run that the other passes too


def place(q: Array, qd: Array) -> Array:
    """States (N, 12) in which a distance of one is as far as two may lie apart.

    q, qd: (N, 6) [rad, rad/s].
    """
    return np.concatenate([q / NEAR_POSITION, qd / NEAR_VELOCITY], axis=1)


def nearest(places: Array, of: Array) -> tuple[Mask, NDArray[np.intp]]:
    """Whether each state (N, 12) lies near one of others (M, 12), and which is nearest (N,)."""
    distance, index = cKDTree(of).query(places, distance_upper_bound=1.0)
    return np.isfinite(distance), index


@dataclass(frozen=True)
class Passed:
    """What a run passes: `place` at samples in motion, or of a run that rests all along at rest.

    every: of how many samples one is looked for along another run; that one shows all of its own,
    for fast runs pass far more than a distance of one between samples that are thinned.
    """

    places: Array
    moves: bool
    every: int = 1

    @classmethod
    def of(cls, q: Array, qd: Array, every: int = 1) -> "Passed":
        """Of positions and velocities (N, 6) at all samples; NaN rows are left out."""
        known = np.isfinite(q + qd).all(axis=1)
        moving = known & (np.abs(qd) > SLOW).any(axis=1)
        rows = moving if moving.any() else known
        return cls(place(q[rows], qd[rows]), bool(moving.any()), every)

    @cached_property
    def tree(self) -> cKDTree:
        """The places, to be searched."""
        return cKDTree(self.places)

    def same(self, other: "Passed") -> bool:
        """Whether one passes nearly all of what the other does."""
        if self.moves != other.moves or not len(self.places) or not len(other.places):
            return False
        return max(self.within(other), other.within(self)) >= SAME

    def within(self, other: "Passed") -> float:
        """Share of this run that the other passes too."""
        distance, _ = other.tree.query(self.places[:: self.every], distance_upper_bound=1.0)
        return float(np.isfinite(distance).mean())


def group_by_path(runs: Sequence[Passed]) -> Labels:
    """Labels (R,) of runs by trajectory, from 0.

    A part of a longer run is of its trajectory, and so is what is the same by way of a third.
    """
    labels = np.arange(len(runs))
    for one in range(len(runs)):
        for other in range(one):
            if labels[one] != labels[other] and runs[one].same(runs[other]):
                labels[labels == labels[one]] = labels[other]
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)
