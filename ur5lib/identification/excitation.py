"""What recordings can tell of an arm's parameters, before any fit, in words."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import eigh

from ur5lib.identification.base_parameters import (
    LARGEST_SHARE,
    NAMES,
    BaseParameters,
    Stack,
    prior_share,
    solve,
    total,
)
from ur5lib.timeseries.arrays import Array, Mask

Motion = tuple[Array, Array, Array]

GROUPS = {  # of parameters, by the words their names begin with
    "gravity": "m ",
    "inertia": "I_",
    "rotors": "rotor inertia",
    "friction": ("Coulomb friction", "viscous friction", "torque offset"),
}


@dataclass(frozen=True)
class Excitation:
    """What the motion of some recordings can tell, at a given noise of the torques.

    condition: of the regressor's columns of each group of base parameters, and of "all" together;
    infinite where the recordings leave a column zero; combinations: how many independent
    combinations of the base parameters are told; undetermined: the base parameters that are not
    told by themselves, in NAMES; advice: sentences, none where everything is determined.
    """

    condition: dict[str, float]
    combinations: int
    undetermined: list[str]
    advice: list[str]


def candidate_motions(speed: float, acceleration: float, count: int = 1000) -> dict[str, Motion]:
    """Motions to try, (count, 6) each: positions, velocities, accelerations [rad, rad/s, rad/s²].

    Holding still, one joint moving, two at the same time, and all: each in random poses over the
    whole range, at random velocities up to `speed` and accelerations up to `acceleration`.
    """
    random = np.random.default_rng(0)
    limits = np.array([np.pi, speed, acceleration])[:, None, None]
    q, qd, qdd = random.uniform(-1, 1, (3, count, 6)) * limits
    motions = {"Holding still": (q, 0 * qd, 0 * qdd)}
    for number in (1, 2, 6):
        for joints in combinations(range(6), number):
            moving = np.isin(np.arange(6), joints)
            name = "all joints" if number == 6 else " and ".join(f"joint {k + 1}" for k in joints)
            name = f"Moving {name} at up to {speed:g} rad/s and {acceleration:g} rad/s²"
            motions[name] = q, moving * qd, moving * qdd
    return motions


def check_excitation(
    data: Stack, base: BaseParameters, width: Array, noise: Array, candidates: dict[str, Array]
) -> Excitation:
    """What recordings tell of base parameters at a noise of (6,) [Nm], independent in each sample.

    width: (P,), standard deviations of what is known before; candidates: regressors (N, 6, P) of
    `candidate_motions`. What is told has less than a hundredth of its variance from what was known
    before. A fit can find less, where its errors are correlated.
    """
    rows = total(data)
    before = ~_told(rows, base, width, noise)
    after = {
        motion: _told(np.concatenate([rows, _rows(regressor)], axis=1), base, width, noise)
        for motion, regressor in candidates.items()
    }
    return Excitation(
        condition=_condition(rows[..., :-1] / noise[:, None, None], base, width),
        combinations=_combinations(rows, base, width, noise),
        undetermined=[NAMES[column] for column in base.columns[before]],
        advice=_advice(base, before, after),
    )


def _rows(regressor: Array) -> Array:
    """Rows (6, N, P + 1) of each joint; what they can tell does not depend on the torques."""
    return np.pad(regressor.swapaxes(0, 1), ((0, 0), (0, 0), (0, 1)))


def _told(rows: Array, base: BaseParameters, width: Array, noise: Array) -> Mask:
    _, spread = solve(rows, noise, np.zeros(len(width)), width)
    return prior_share(base.groups, spread, width) <= LARGEST_SHARE


def _combinations(rows: Array, base: BaseParameters, width: Array, noise: Array) -> int:
    """In how many directions the variance is left with a hundredth of what it was before."""
    _, spread = solve(rows, noise, np.zeros(len(width)), width)
    before, after = base.groups * width, base.groups @ spread
    left = eigh(after @ after.T, before @ before.T, eigvals_only=True)
    return int(np.sum(left <= LARGEST_SHARE))


def _condition(weighted: Array, base: BaseParameters, width: Array) -> dict[str, float]:
    """Condition numbers of the columns, each counted in the width of its parameter."""
    columns = (weighted * width).reshape(-1, len(width))
    members = {
        group: [column for column in base.columns if NAMES[column].startswith(beginning)]
        for group, beginning in GROUPS.items()
    }
    members["all"] = list(base.columns)
    return {
        group: float(np.linalg.cond(columns[:, chosen]))
        for group, chosen in members.items()
        if chosen
    }


def _advice(base: BaseParameters, unknown: Mask, after: dict[str, Mask]) -> list[str]:
    """The motion that would tell most of what is unknown, then the next one for the rest."""
    sentences: list[str] = []
    left = unknown
    while left.any():
        motion = max(after, key=lambda name: int(np.sum(left & after[name])))
        gained = left & after[motion]
        if not gained.any():
            rest = _list(base.columns[left])
            return [*sentences, f"at this noise, none of the motions tried would determine {rest}"]
        missing = _list(base.columns[gained])
        sentences.append(f"{motion} in many poses would determine {missing}")
        left = left & ~gained
    return sentences


def _list(columns: Iterable[int]) -> str:
    """Parameters by the link or joint that they are of."""
    owners: dict[str, list[str]] = defaultdict(list)
    for column in columns:
        name, owner = NAMES[column].split(" of ")
        owners[owner].append(name)
    return "; ".join(f"{', '.join(names)} of {owner}" for owner, names in owners.items())
