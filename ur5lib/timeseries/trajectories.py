"""Grouping of recordings by trajectory: recordings of one path are not independent."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy  # loads scipy.spatial at its first use
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Labels, Mask

# Up to these root sums of squares over all joints, two states count as equal.
POSITION_TOLERANCE = 0.02  # rad
VELOCITY_TOLERANCE = 0.1  # rad/s
REST_SPEED = 0.03  # rad/s; below it, a joint rests or Coulomb friction changes its sign
MIN_COMMON_SHARE = 0.9  # two runs along one path have this share of states in common


def scaled_states(q: Array, qd: Array) -> Array:
    """Return scaled states (N, 2 n); states at a distance below 1 count as equal.

    q, qd: (N, n) [rad, rad/s].
    """
    return np.concatenate([q / POSITION_TOLERANCE, qd / VELOCITY_TOLERANCE], axis=1)


def nearest(places: Array, other_places: Array) -> tuple[Mask, NDArray[np.intp]]:
    """Return whether each state (N, 2 n) is near one of others (M, 2 n), and the nearest (N,)."""
    distance, index = scipy.spatial.cKDTree(other_places).query(places, distance_upper_bound=1.0)
    return np.isfinite(distance), np.asarray(index)


@dataclass(frozen=True)
class PathStates:
    """States (`scaled_states`) that a run passes in motion, or all its states if it rests.

    places: these states; moves: whether the run moves; every: stride of the states that are
    searched in another run. The other run is not thinned, because thinned samples of fast runs are
    further apart than 1.
    """

    places: Array
    moves: bool
    every: int = 1

    @classmethod
    def from_motion(cls, q: Array, qd: Array, stride: int = 1) -> "PathStates":
        """Return the path of q, q̇ (N, n) [rad, rad/s], without NaN rows; stride: its `every`."""
        finite = np.isfinite(q + qd).all(axis=1)
        moving = finite & (np.abs(qd) > REST_SPEED).any(axis=1)
        rows = moving if moving.any() else finite
        return cls(scaled_states(q[rows], qd[rows]), bool(moving.any()), stride)

    @cached_property
    def extent(self) -> Array:
        """Return the lowest and the highest value of each scaled state (2, 2 n)."""
        return np.array([self.places.min(axis=0), self.places.max(axis=0)])

    @cached_property
    def tree(self) -> "scipy.spatial.cKDTree":
        """Return the search tree of the places."""
        return scipy.spatial.cKDTree(self.places)

    def is_part_of(self, other: "PathStates") -> bool:
        """Return whether the other run contains nearly all states of this one."""
        if self.moves != other.moves or not len(self.places) or not len(other.places):
            return False
        low, high = other.extent
        states = self.places[:: self.every]
        inside = ((states >= low - 1) & (states <= high + 1)).all(axis=1)
        # quick, then exact
        return bool(inside.mean() >= MIN_COMMON_SHARE) and self.within(other) >= MIN_COMMON_SHARE

    def within(self, other: "PathStates") -> float:
        """Return the share of this run's states that the other contains."""
        distance, _ = other.tree.query(self.places[:: self.every], distance_upper_bound=1.0)
        return float(np.isfinite(distance).mean())


def group_by_path(runs: Iterable[PathStates]) -> Labels:
    """Return labels (R,) of runs by trajectory, from 0.

    A part of a longer run belongs to its trajectory; the relation is transitive. A run that is no
    part of an earlier one represents its trajectory: only representatives are compared with later
    runs, so that of thousands of repetitions few are kept.
    """
    labels, representatives = list[int](), list[tuple[int, PathStates]]()
    for place, run in enumerate(runs):
        alike = [
            other for other, representative in representatives if run.is_part_of(representative)
        ]
        if not alike:
            alike = [
                other for other, representative in representatives if representative.is_part_of(run)
            ]
            representatives.append((place, run))
        # a run that is like several trajectories makes them one
        joined = {labels[other] for other in alike}
        label_of_run = min(joined, default=place)
        if len(joined) > 1:
            labels = [label_of_run if label in joined else label for label in labels]
        labels.append(label_of_run)
    return np.unique(np.array(labels, dtype=np.int64), return_inverse=True)[1].astype(np.int64)
