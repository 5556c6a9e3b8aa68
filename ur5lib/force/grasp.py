"""Loads grasped during a run: contacts with the external torque of a weight."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.robots.friction import GEAR_EFFICIENCY_STD
from ur5lib.timeseries.arrays import Array

MIN_GRASP_DURATION = 2.0  # s; in a shorter contact, a load and a push cannot be distinguished
HANDLING_DURATION = 0.5  # s; the load is taken up and put down for this long
MIN_SHARE_EXPLAINED_BY_LOAD = 0.95  # a load explains this share of the contact's squared torque
USUAL_LOAD_LEVER = 0.15  # m; a load's centre of mass is usually this far from the flange
LEVER_PRIOR_WEIGHT = 1e-2  # weight of USUAL_LOAD_LEVER for each sample, in samples


class Grasped(NamedTuple):
    """A grasped load: mass [kg] and std_error [kg]."""

    mass: float
    std_error: float


def grasped_load(
    torque: Array, regressor: Array, deviation: Array, period: float
) -> Grasped | None:
    """Return the load that explains a contact; None if a weight does not explain it, or the contact
    is too short.

    torque: of the contact alone, (n, 6) [Nm]; regressor: (n, 6, 4), the joint torque per mass [kg]
    and first moment [kg m]; deviation: (6,) [Nm], standard deviation of the background, constant
    over the contact; period: [s]. Least squares of τ = −Y θ, with a prior on the first moments of
    USUAL_LOAD_LEVER times the mass.
    """
    edge = round(HANDLING_DURATION / period)
    inner = slice(edge, len(torque) - edge)
    finite = finite_rows(torque[inner])
    if finite.sum() * period < MIN_GRASP_DURATION - 2 * HANDLING_DURATION:
        return None
    target = torque[inner][finite] / deviation
    terms = -regressor[inner][finite] / deviation[:, None]
    columns = terms.reshape(-1, 4)
    information, right = columns.T @ columns, columns.T @ target.ravel()
    mass = right[0] / information[0, 0]
    if mass <= 0:
        return None
    lever_precision = len(target) * np.array([0.0, 1, 1, 1]) / (USUAL_LOAD_LEVER * mass) ** 2
    information += np.diag(LEVER_PRIOR_WEIGHT * lever_precision)
    parameters = np.linalg.solve(information, right)
    residual = target - terms @ parameters
    if (residual**2).sum() > (1 - MIN_SHARE_EXPLAINED_BY_LOAD) * (target**2).sum():
        return None
    # change of θ per standard deviation of each joint's background
    common = np.linalg.solve(information, terms.sum(axis=0).T)  # (4, 6)
    mass = float(parameters[0])
    error = float(np.hypot(np.linalg.norm(common[0]), GEAR_EFFICIENCY_STD * mass))
    return Grasped(mass, error) if mass > 3 * error else None
