"""The parameters of an arm that recordings determine, and motions that would determine the rest."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations

import numpy as np
from scipy.linalg import eigh

from ur5lib.errors import Remark
from ur5lib.identification.base_parameters import (
    MAX_PRIOR_VARIANCE_SHARE,
    BaseParameters,
    Stack,
    prior_share,
    solve,
    total_factors,
)
from ur5lib.records.codes import CauseCode
from ur5lib.records.models import Excitation
from ur5lib.timeseries.arrays import Array, Mask

Motion = tuple[Array, Array, Array]

PARAMETER_GROUPS = {  # the words that begin the names of a group's parameters
    "gravity": "m ",
    "inertia": "I_",
    "rotors": "rotor inertia",
}


def candidate_motions(
    joints: int, speed: float, acceleration: float, count: int = 1000
) -> dict[str, Motion]:
    """Return motions of n joints by name, each as (q, q̇, q̈), (count, n) [rad, rad/s, rad/s²].

    No joint, one, two, or all move at a time, in random poses over the whole range, at random
    velocities up to `speed` and accelerations up to `acceleration`.
    """
    random = np.random.default_rng(0)
    limits = np.array([np.pi, speed, acceleration])[:, None, None]
    q, qd, qdd = random.uniform(-1, 1, (3, count, joints)) * limits
    motions = {"Holding still": (q, 0 * qd, 0 * qdd)}
    for number in (1, 2, joints):
        for moving_joints in combinations(range(joints), number):
            moving = np.isin(np.arange(joints), moving_joints)
            several = " and ".join(f"joint {k + 1}" for k in moving_joints)
            name = "all joints" if number == joints else several
            name = f"Moving {name} at up to {speed:g} rad/s and {acceleration:g} rad/s²"
            motions[name] = q, moving * qd, moving * qdd
    return motions


def check_excitation(
    data: Stack, base: BaseParameters, width: Array, noise: Array, candidates: dict[str, Array]
) -> Excitation:
    """Return which base parameters the data determine at a noise (n,) [Nm], and which motions would
    determine the others.

    The noise is independent between samples. width: (P,), standard deviations of the prior;
    candidates: regressors (N, n, P) of `candidate_motions`. A parameter is determined if less than
    MAX_PRIOR_VARIANCE_SHARE of its variance comes from the prior. A fit may determine less, because
    its errors are correlated.
    """
    rows = total_factors(data)
    undetermined = ~_determined_parameters(rows, base, width, noise)
    determined = {
        motion: _determined_parameters(
            np.concatenate([rows, _rows(regressor)], axis=1), base, width, noise
        )
        for motion, regressor in candidates.items()
    }
    return Excitation(
        condition=_condition(rows[..., :-1] / noise[:, None, None], base, width),
        combinations=_combinations(rows, base, width, noise),
        undetermined=[base.parameters[column] for column in base.columns[undetermined]],
        advice=[*_advice(base, undetermined, determined)],
    )


def _rows(regressor: Array) -> Array:
    """Return rows (n, N, P + 1) of each joint; the torques are zero, as they do not matter here."""
    return np.pad(regressor.swapaxes(0, 1), ((0, 0), (0, 0), (0, 1)))


def _determined_parameters(rows: Array, base: BaseParameters, width: Array, noise: Array) -> Mask:
    """Return which base parameters (B,) the rows (n, N, P + 1) determine."""
    _, spread = solve(rows, noise, np.zeros(len(width)), width)
    return prior_share(base.groups, spread, width) <= MAX_PRIOR_VARIANCE_SHARE


def _combinations(rows: Array, base: BaseParameters, width: Array, noise: Array) -> int:
    """Return how many independent combinations of base parameters have at most
    MAX_PRIOR_VARIANCE_SHARE of the prior's variance.
    """
    _, spread = solve(rows, noise, np.zeros(len(width)), width)
    prior_root, posterior_root = base.groups * width, base.groups @ spread
    ratio = eigh(posterior_root @ posterior_root.T, prior_root @ prior_root.T, eigvals_only=True)
    return int(np.sum(ratio <= MAX_PRIOR_VARIANCE_SHARE))


def _condition(weighted: Array, base: BaseParameters, width: Array) -> dict[str, float]:
    """Return, by group of parameters, the condition number of the columns, each scaled by the width
    of its parameter.
    """
    columns = (weighted * width).reshape(-1, len(width))
    members = {
        group: [column for column in base.columns if base.parameters[column].startswith(beginning)]
        for group, beginning in PARAMETER_GROUPS.items()
    }
    members["all"] = list(base.columns)
    return {
        group: float(np.linalg.cond(columns[:, columns_of_group]))
        for group, columns_of_group in members.items()
        if columns_of_group
    }


def _advice(base: BaseParameters, unknown: Mask, determined: dict[str, Mask]) -> Iterator[Remark]:
    """Yield remarks: the motion that determines most of the undetermined parameters, then the next
    one.
    """
    undetermined = unknown
    while undetermined.any():
        motion = max(determined, key=lambda name: int(np.sum(undetermined & determined[name])))
        gained = undetermined & determined[motion]
        if not gained.any():
            none = "at this noise, none of the motions tried would determine"
            yield Remark(CauseCode.NO_MOTION_DETERMINES, f"{none} {_by_owner(base, undetermined)}")
            return
        text = f"{motion} in many poses would determine {_by_owner(base, gained)}"
        yield Remark(CauseCode.MOTION_DETERMINES, text, motion=motion)
        undetermined = undetermined & ~gained


def _by_owner(base: BaseParameters, members: Mask) -> str:
    """Return in words the base parameters of a mask (B,), grouped by link or joint."""
    owners: dict[str, list[str]] = defaultdict(list)
    for column in base.columns[members]:
        name, owner = base.parameters[column].split(" of ")
        owners[owner].append(name)
    return "; ".join(f"{', '.join(names)} of {owner}" for owner, names in owners.items())
