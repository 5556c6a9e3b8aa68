"""The rows of an arm's measured torques: links and rotors with each joint's friction.

τ = Y π + F c, low-passed and thinned; a unit is a path or a stretch, which is left out as a whole.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import MAX_BLOCKS, PARAMETERS_PER_JOINT
from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.identification.samples import (
    BLOCKS_PER_STRETCH,
    MIN_UNITS,
    CurrentSamples,
    blocks,
    record_paths,
)
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import numbered
from ur5lib.robots.drives import coupled_motors
from ur5lib.robots.friction import coefficient_names, friction_columns
from ur5lib.timeseries.arrays import Array, Labels, Mask

BALANCE, COUPLED = "balance", "coupled"
ROWS_PER_CUTOFF = 5  # rows per period of the cut-off: one each 0.1 s at 2 Hz

Block = tuple[Array, Array]  # regressors (N, n, P) and torques (N, n) [Nm]


@dataclass(frozen=True)
class MeasuredRun:
    """A recording with measured torques [Nm] in place of currents, of which the rigid bodies' part
    is unknown.

    qdd: (N, n) [rad/s²]; regressor: returns Y (N, n, P) of q, q̇ and q̈, under its gravity.
    """

    samples: CurrentSamples
    qdd: Array
    regressor: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class TorqueRows:
    """Rows of the torque regression from the recordings of an arm of n joints.

    units: regressors (N, n, P) and torques (N, n) [Nm] that are left out together; terms: of
    friction; their columns follow those of the links: joint 1's offset, terms and balance, then
    joint 2's; motors: those, from 1, that turn with two joints and brake both by one friction.
    """

    units: Sequence[Block]
    terms: Sequence[str]
    motors: Collection[int]

    @property
    def joints(self) -> int:
        """Return the number of joints, n."""
        return self.units[0][1].shape[1]

    def largest_torque(self) -> Array:
        """Return the largest torque (n,) [Nm]."""
        largest: Array = np.max([np.abs(torque).max(axis=0) for _, torque in self.units], axis=0)
        return largest

    def coefficients(self) -> list[str]:
        """Return the names of a joint's coefficients."""
        return coefficients(self.terms)

    def places(self, terms: Collection[str], balanced: Collection[int] = ()) -> list[int]:
        """Return the numbers of the columns of links, of the offset and `terms` of all joints, and
        of the balance of some; balanced: joints from 1.
        """
        of_joints = {"offset", *coefficient_names([*terms])}
        only = {**dict.fromkeys(coefficient_names([BALANCE]), balanced)}
        only |= dict.fromkeys(coefficient_names([COUPLED] * (COUPLED in terms)), self.motors)
        names, first = self.coefficients(), PARAMETERS_PER_JOINT * self.joints
        return [
            *range(first),
            *(
                first + len(names) * joint + place
                for joint in range(self.joints)
                for place, name in enumerate(names)
                if (joint + 1 in only[name] if name in only else name in of_joints)
            ),
        ]


def torque_rows(
    runs: Sequence[MeasuredRun], terms: Sequence[str], smooth: ZeroPhaseLowpass, shafts: Array
) -> TorqueRows:
    """Return the rows of recordings in units: paths, or else parts of them, or else blocks, of
    which there are at least MIN_UNITS.

    shafts: (n, n), turns of each motor (row) per turn of each joint, 1 for its own. Raises
    RefusalError where there are no rows, or a joint's torque never changes.
    """
    rows_of = ((run.samples, *run_rows(run, terms, smooth, shafts)) for run in runs)
    filled = [own for own in rows_of if len(own[-1])]
    if not filled:
        text = "no recording with the role “fit” has actual_torque in motion"
        raise RefusalError(CauseCode.NO_FIT_TORQUES, text)
    samples, regressor, torque, block = zip(*filled, strict=True)
    paths = record_paths(samples)
    path = np.repeat(paths, [len(rows) for rows in torque])
    firsts = np.cumsum([0, *(-(-(labels[-1] + 1) // BLOCKS_PER_STRETCH) for labels in block[:-1])])
    whole = np.concatenate(
        [labels + BLOCKS_PER_STRETCH * first for labels, first in zip(block, firsts, strict=True)]
    )
    parts = path, whole // BLOCKS_PER_STRETCH
    unit = next((part for part in parts if len(np.unique(part)) >= MIN_UNITS), whole) % MAX_BLOCKS
    rows, torques = np.concatenate(regressor), np.concatenate(torque)
    if len(still := 1 + np.flatnonzero(np.ptp(torques, axis=0) == 0)):
        torque_of = f"the torque of {numbered(still)}"
        text = f"{torque_of} does not change in any recording with the role “fit”"
        raise RefusalError(CauseCode.NO_TORQUE_OF_JOINTS, text)
    units = [(rows[unit == label], torques[unit == label]) for label in np.unique(unit)]
    motors = [*(1 + np.flatnonzero(coupled_motors(shafts)))]
    return TorqueRows(units, [*terms], motors)


def run_rows(
    run: MeasuredRun, terms: Sequence[str], smooth: ZeroPhaseLowpass, shafts: Array
) -> tuple[Array, Array, Labels]:
    """Return regressors (N, n, P), torques (N, n) [Nm] and labels (N,) of blocks of a recording,
    low-passed and thinned.

    There is no row where a sample is missing.
    """
    known = replace(run.samples, balanced=range(run.samples.q.shape[1]))
    stride = max(1, round(1 / (ROWS_PER_CUTOFF * smooth.cutoff * known.period)))
    rigid = run.regressor(known.q, known.qd, run.qdd)
    of_joints = [own_columns(known, joint, terms) for joint in range(known.q.shape[1])]
    sources = [rigid.reshape(len(rigid), -1), *of_joints, known.current]
    rows = smooth(np.hstack(sources), known)[::stride]
    finite = np.isfinite(rows).all(axis=1)
    block = blocks(known)[::stride][finite]
    ends = np.cumsum([source.shape[1] for source in sources])[:-1]
    smoothed, *friction, torque = np.split(rows[finite], ends, axis=1)
    smoothed = smoothed.reshape(len(smoothed), *rigid.shape[1:])
    is_shared = [name in coefficient_names([COUPLED]) for name in coefficients(terms)]
    columns = by_row(np.stack(friction, axis=1), np.array(is_shared), shafts)
    return np.concatenate([smoothed, columns], axis=2), torque, block


def own_columns(samples: CurrentSamples, joint: int, terms: Sequence[str]) -> Array:
    """Return the columns (N, C) of a joint's offset, friction and balance; joint: from 0."""
    motion = samples.joint(joint)
    return np.column_stack([np.ones_like(motion.q), friction_columns(motion, [*terms, BALANCE])])


def coefficients(terms: Sequence[str]) -> list[str]:
    """Return the names of a joint's coefficients in addition to the links' parameters."""
    return ["offset", *coefficient_names([*terms, BALANCE])]


def by_row(columns: Array, is_shared: Mask, shafts: Array) -> Array:
    """Return the columns (N, n, n C) of friction in the row of each joint, from each joint's own
    columns (N, n, C).

    A joint's columns are in its own row, a coupled motor's in the rows of all joints that it turns
    with: τ = Sᵀ τ_shaft, S = shafts (n, n). is_shared: which columns (C,) are a coupled motor's.
    """
    count, joints, width = columns.shape
    own = np.where(is_shared, 0.0, columns)
    of_shafts = np.where(is_shared & coupled_motors(shafts)[:, None], columns, 0.0)
    rows = np.einsum("jm,kmc->kjmc", np.eye(joints), own)
    rows += np.einsum("mj,kmc->kjmc", shafts, of_shafts)
    return rows.reshape(count, joints, joints * width)
