"""The rows of an arm's measured torques: links and rotors beside each joint's friction.

τ = Y π + F c, low-passed and thinned; what is left out together, a path or a stretch, is one unit.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.identification.base_parameters import MAX_BLOCKS, PARAMETERS_PER_JOINT
from ur5lib.identification.samples import (
    BLOCKS_PER_STRETCH,
    INDEPENDENT_STEP,
    MIN_UNITS,
    CurrentSamples,
    Smooth,
    blocks,
    record_paths,
)
from ur5lib.robots.friction import coefficient_names, friction_columns
from ur5lib.timeseries.arrays import Array, Labels

BALANCE = "balance"

Block = tuple[Array, Array]  # regressors (N, n, P) and torques (N, n) [Nm]


@dataclass(frozen=True)
class MeasuredRun:
    """A recording with torques [Nm] in place of currents, whose rigid-body torque is unknown.

    qdd: (N, n) [rad/s²]; regressor: returns Y (N, n, P) of q, q̇ and q̈, under its gravity.
    """

    samples: CurrentSamples
    qdd: Array
    regressor: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class TorqueRows:
    """What recordings of an arm of n joints show.

    units: blocks that are left out together; terms: of friction whose columns they have, after
    those of the links: of joint 1 an offset, the terms' and a balance's, then of joint 2.
    """

    units: Sequence[Block]
    terms: Sequence[str]

    @property
    def joints(self) -> int:
        """Return n."""
        return self.units[0][1].shape[1]

    def largest_torque(self) -> Array:
        """Return the largest torque (n,) [Nm]."""
        largest: Array = np.max([np.abs(torque).max(axis=0) for _, torque in self.units], axis=0)
        return largest

    def coefficients(self) -> list[str]:
        """Return the names of a joint's coefficients."""
        return ["offset", *coefficient_names([*self.terms, BALANCE])]

    def places(self, terms: Collection[str], balanced: Collection[int] = ()) -> list[int]:
        """Return the columns of the links, of the offset and terms of all joints, and of balances.

        balanced: joints from 1.
        """
        kept, balance = {"offset", *coefficient_names([*terms])}, {*coefficient_names([BALANCE])}
        names, first = self.coefficients(), PARAMETERS_PER_JOINT * self.joints
        return [
            *range(first),
            *(
                first + len(names) * joint + place
                for joint in range(self.joints)
                for place, name in enumerate(names)
                if name in kept or (name in balance and joint + 1 in balanced)
            ),
        ]


def torque_rows(runs: Sequence[MeasuredRun], terms: Sequence[str], smooth: Smooth) -> TorqueRows:
    """Return the rows of recordings."""
    paths = record_paths([run.samples for run in runs])
    has_paths = paths.max() + 1 >= MIN_UNITS
    parts: dict[int, list[Block]] = {}
    for run, path in zip(runs, paths.tolist(), strict=True):
        regressor, torque, stretch = run_rows(run, terms, smooth)
        unit = np.full_like(stretch, path) if has_paths else stretch + len(parts)
        for label in np.unique(unit).tolist():
            block = regressor[unit == label], torque[unit == label]
            parts.setdefault(label % MAX_BLOCKS, []).append(block)
    joined = [[*zip(*unit, strict=True)] for unit in parts.values()]
    return TorqueRows([(np.concatenate(Y), np.concatenate(tau)) for Y, tau in joined], [*terms])


def run_rows(run: MeasuredRun, terms: Sequence[str], smooth: Smooth) -> tuple[Array, Array, Labels]:
    """Return regressors (N, n, P), torques (N, n) [Nm] and labels (N,) of stretches of a recording.

    Where a sample is missing, there is no row.
    """
    known = replace(run.samples, balanced=range(run.samples.q.shape[1]))
    stride = max(1, round(INDEPENDENT_STEP / known.period))
    rigid = run.regressor(known.q, known.qd, run.qdd)
    of_joints = [own_columns(known, joint, terms) for joint in range(known.q.shape[1])]
    sources = [rigid.reshape(len(rigid), -1), *of_joints, known.current]
    rows = smooth(np.hstack(sources), known)[::stride]
    finite = np.isfinite(rows).all(axis=1)
    stretch = (blocks(known) // BLOCKS_PER_STRETCH)[::stride][finite]
    ends = np.cumsum([source.shape[1] for source in sources])[:-1]
    smoothed, *friction, torque = np.split(rows[finite], ends, axis=1)
    smoothed = smoothed.reshape(len(smoothed), *rigid.shape[1:])
    return np.concatenate([smoothed, block_diagonal(friction)], axis=2), torque, stretch


def own_columns(samples: CurrentSamples, joint: int, terms: Sequence[str]) -> Array:
    """Return the columns (N, C) of a joint's offset, friction and balance; joint: from 0."""
    motion = samples.joint(joint)
    return np.column_stack([np.ones_like(motion.q), friction_columns(motion, [*terms, BALANCE])])


def block_diagonal(parts: Sequence[Array]) -> Array:
    """Return (N, n, n C) of n parts (N, C): each in its own row and columns, zero elsewhere."""
    count, width = parts[0].shape
    whole = np.zeros((count, len(parts), len(parts) * width))
    for joint, part in enumerate(parts):
        whole[:, joint, joint * width : (joint + 1) * width] = part
    return whole
