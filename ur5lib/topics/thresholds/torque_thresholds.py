"""Torque thresholds for contact: quantiles of |τ_ext| by joint, speed and acceleration.

The threshold of a rate r is the ⌈(1 - r) n⌉-th smallest of a joint's external torques |τ_ext| in n
samples without contact: at most the share r exceeds it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import DEAD_ZONE

# Rates: shares of samples without contact beyond the thresholds of a contact and of a collision.
LEVELS = {"lower": 0.01, "upper": 0.001}
FAST_SHARE = 0.5  # from this share of its largest speed on, a joint is fast
ACCELERATING_SHARE = 0.1  # from this share of the largest acceleration on, a joint accelerates
LARGEST = 0.999  # this quantile counts as the largest acceleration: beyond it is noise
UNITS = "Nm, rad/s, rad/s^2; joints from 1; rates: share of samples, of each joint by itself"


class Free(NamedTuple):
    """The samples of a recording without contact, (N, n) each.

    torque: |τ_ext| [Nm], NaN where unknown; speed: |q̇| [rad/s]; acceleration: |q̈| [rad/s²].
    """

    torque: Array
    speed: Array
    acceleration: Array


@dataclass(frozen=True)
class Thresholds:
    """Thresholds of an arm of n joints [Nm].

    edges: (3, n) [rad/s], lower edges of the speed classes rest, slow, fast; by_speed: of each
    level, (3, n); accelerating: (n,) [rad/s²], from which on motion counts as acceleration, below
    it as nominal; nominal, acceleration: of each level, (n,), below and above this edge; counts:
    (3, n), samples; left_out: of each level, the share beyond thresholds from the other recordings,
    over all and on the worst recording, NaN with a single recording.
    """

    robot: str
    cutoff: float
    recordings: list[str]
    edges: Array
    counts: Array
    by_speed: Mapping[str, Array]
    accelerating: Array
    nominal: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    left_out: Mapping[str, tuple[float, float]]

    def in_json(self) -> dict[str, Any]:
        """Return the thresholds as plain data, also in the terms of `setCollisionBehavior`."""
        behaviour = {
            f"{level}_torque_thresholds_{phase}": getattr(self, phase)[level].tolist()
            for phase in ("acceleration", "nominal")
            for level in LEVELS
        }
        return {
            "format": "ur5lib thresholds 1",
            "robot": self.robot,
            "units": UNITS,
            "torque": f"tau_ext of currents.parquet, low-passed at {self.cutoff:g} Hz",
            "false_alarm_rates": LEVELS,
            "left_out": {
                level: {"mean": mean, "worst": worst}
                for level, (mean, worst) in self.left_out.items()
            },
            "recordings": self.recordings,
            "accelerating_from": self.accelerating.tolist(),
            "collision_behavior": behaviour,
            "by_speed": [*self._rows()],
        }

    def _rows(self) -> list[dict[str, float | None]]:
        ends = np.vstack([self.edges[1:], np.full(self.edges.shape[1], np.nan)])
        return [
            {"joint": joint + 1, "from": self.edges[k, joint], "to": _or_none(ends[k, joint])}
            | {"samples": int(self.counts[k, joint])}
            | {level: self.by_speed[level][k, joint] for level in LEVELS}
            for joint in range(self.edges.shape[1])
            for k in range(len(self.edges))
        ]


def thresholds_of(study: StudyFiles, robot: str) -> Thresholds:
    """Return the thresholds of an arm from the contact-free recordings of a study.

    Raises InputError if they have too few samples for the smallest rate.
    """
    free = free_samples(study, robot)
    together = _joined([*free.values()])
    least = min(np.isfinite(together.torque).sum(axis=0), default=0)
    if least * min(LEVELS.values()) < 1:
        raise InputError(
            f"{robot} has external torques in {least} samples without contact, but a rate of "
            f"{min(LEVELS.values()):g} needs {1 / min(LEVELS.values()):.0f}; record longer"
        )
    edges = speed_edges(together)
    limit = ACCELERATING_SHARE * np.nanquantile(together.acceleration, LARGEST, axis=0)
    faster, classes = together.acceleration > limit, speed_classes(together, edges)
    return Thresholds(
        robot,
        study.configuration().settings.lowpass.cutoffs_hz()["currents"],
        [*free],
        edges,
        np.array([(one & np.isfinite(together.torque)).sum(axis=0) for one in classes]),
        {level: quantiles(together.torque, classes, rate) for level, rate in LEVELS.items()},
        limit,
        {level: quantiles(together.torque, [~faster], r)[0] for level, r in LEVELS.items()},
        {level: quantiles(together.torque, [faster], r)[0] for level, r in LEVELS.items()},
        {level: left_out([*free.values()], edges, rate) for level, rate in LEVELS.items()},
    )


def free_samples(study: StudyFiles, robot: str) -> dict[str, Free]:
    """Return by recording the samples of an arm without contact that have an external torque.

    In a fit recording, this torque comes from the fit without its path. Raises InputError if no
    recording has such samples.
    """
    found = dict[str, Free]()
    for entry in study.configuration().recordings:
        if entry.role == "contact" or entry.at_rest or entry.arm.known_as != robot:
            continue
        torque = study.record(Currents, entry.name).external_torque
        motion = study.record(Motion, entry.name)
        if torque is not None:
            found[entry.name] = Free(*map(np.abs, (torque, motion.qd, motion.qdd)))
    if not found:
        raise InputError(
            f"{study.folder} has no external torque of {robot} without contact; its report says why"
        )
    return found


def speed_edges(free: Free) -> Array:
    """Return the lower edges (3, n) [rad/s] of each joint's speed classes: rest, slow, fast."""
    fastest = np.nanmax(free.speed, axis=0)
    resting, slow = np.zeros_like(fastest), np.full_like(fastest, DEAD_ZONE)
    return np.stack([resting, slow, np.maximum(slow, FAST_SHARE * fastest)])


def speed_classes(free: Free, edges: Array) -> list[Mask]:
    """Return for each speed class a mask (N, n) of its samples."""
    above = [free.speed > edge for edge in edges[1:]]
    return [~above[0], above[0] & ~above[1], above[1]]


def quantiles(torque: Array, classes: Sequence[Mask], rate: float) -> Array:
    """Return for each class the torques (C, n) [Nm] that the share `rate` of its samples exceeds.

    torque, classes: (N, n). A class with too few samples for the rate gets the quantile of all.
    """
    every = np.ones_like(torque, bool)
    return np.array(
        [
            [
                _quantile(torque[own[:, k], k], torque[every[:, k], k], rate)
                for k in range(torque.shape[1])
            ]
            for own in classes
        ]
    )


def left_out(free: Sequence[Free], edges: Array, rate: float) -> tuple[float, float]:
    """Return the share of a recording's samples beyond thresholds from the other recordings: over
    all recordings, and on the worst one. NaN with a single recording.
    """
    beyond, known = list[int](), list[int]()
    for k, own in enumerate(free if len(free) > 1 else []):
        others = _joined([*free[:k], *free[k + 1 :]])
        limits = quantiles(others.torque, speed_classes(others, edges), rate)
        pairs = zip(speed_classes(own, edges), limits, strict=True)
        beyond.append(sum(int(np.sum(one & (own.torque > limit))) for one, limit in pairs))
        known.append(int(np.isfinite(own.torque).sum()))
    shares = [above / count for above, count in zip(beyond, known, strict=True) if count]
    return (sum(beyond) / sum(known), max(shares)) if shares else (np.nan, np.nan)


def _quantile(own: Array, every: Array, rate: float) -> float:
    own = own[np.isfinite(own)]
    taken = own if len(own) * rate >= 1 else every[np.isfinite(every)]
    return float(np.quantile(taken, 1 - rate, method="inverted_cdf"))


def _joined(free: Sequence[Free]) -> Free:
    return Free(*(np.concatenate(parts) for parts in zip(*free, strict=True)))


def _or_none(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
