"""Whether a contact is a load that was grasped: does the torque it leaves look like a weight?"""

from dataclasses import dataclass

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array

SHORTEST = 2.0  # s; a shorter contact tells no load from a push
EDGE = 0.5  # s at both ends, while it is taken up or put down
EXPLAINED = 0.95  # share of the contact's squared torque that a weight must explain
GEARS = 0.03  # relative error of the mass by the gears' efficiency
LEVER = 0.15  # m, how far from the flange a load's centre of mass usually is


@dataclass(frozen=True)
class Grasped:
    """mass, std_error [kg] of a load."""

    mass: float
    std_error: float


def grasped_load(
    torque: Array, regressor: Array, deviation: Array, period: float, efficiency: float
) -> Grasped | None:
    """The load that explains a contact; None where a weight does not.

    torque: external, less its background, (n, 6) [Nm], of the contact's samples; regressor:
    (n, 6, 4), the torque that a load's mass [kg] and first moments [kg m] need; deviation: (6,)
    [Nm], by which the background may be off throughout; period: [s]; efficiency: of the gears.

    What a load needs, its weight on the arm takes: τ = −Y θ. Least squares with first moments of
    the size of a usual lever; the background's error is the same for all samples, and what is left
    is the noise of independent seconds.
    """
    edge = round(EDGE / period)
    inner = slice(edge, len(torque) - edge)
    known = finite_rows(torque[inner])
    if known.sum() * period < SHORTEST - 2 * EDGE:
        return None
    seen = torque[inner][known] / deviation
    terms = -regressor[inner][known] / deviation[:, None]
    parameters, information = _fit(terms, seen)
    left = seen - terms @ parameters
    if (left**2).sum() > (1 - EXPLAINED) * (seen**2).sum():
        return None
    common = np.linalg.solve(information, terms.sum(axis=0).T)  # of each joint's offset
    mass = float(parameters[0]) / efficiency
    error = float(np.hypot(np.linalg.norm(common[0]), GEARS * mass))
    return Grasped(mass, error) if mass > 3 * error else None


def _fit(terms: Array, seen: Array) -> tuple[Array, Array]:
    """θ (4,) and the normal equations' matrix; first moments are held to LEVER times the mass."""
    columns = terms.reshape(-1, 4)
    information = columns.T @ columns
    right = columns.T @ seen.ravel()
    mass = right[0] / information[0, 0]
    held = len(seen) * np.array([0.0, 1, 1, 1]) / max(LEVER * abs(mass), 1e-3) ** 2
    information = information + np.diag(held * 1e-2)
    return np.asarray(np.linalg.solve(information, right), np.float64), information
