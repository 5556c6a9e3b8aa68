"""The masses and inertias that a body may have if its density is positive everywhere.

Its second moments of mass, S = ½ tr(I) 1 - I about the centre of mass, are positive definite: no
principal moment of inertia exceeds the sum of the others (Wensing).
"""

import numpy as np
from scipy.optimize import nnls

from ur5lib.robots.inertia import WRITTEN_SHARE
from ur5lib.timeseries.arrays import Array

THINNEST = 1e-4  # m; a sheet has this radius of gyration across its plane
# A sheet's principal moments, written with three digits, err by this share of their sum.
ROUNDING = 1e-3


def impossibility(mass: float, inertia: Array) -> str:
    """Return why no body has a mass [kg] and an inertia tensor (3, 3) [kg m²] about its centre of
    mass, in words, but for rounding; empty where one may.
    """
    if mass <= 0:
        return f"its mass is {mass:g} kg"
    moments = np.asarray(np.linalg.eigvalsh(inertia), np.float64)
    principal = f"its principal moments of inertia are {_listed(moments)} kg m²"
    if moments[0] <= 0:
        return f"{principal}, which must be positive"
    if moments[2] - moments[1] - moments[0] > ROUNDING * moments.sum():
        return f"{principal}, the largest above the sum of the others"
    return ""


def nearest_possible(mass: float, inertia: Array) -> Array:
    """Return the inertia tensor (3, 3) [kg m²] that is nearest to one, of those that a body of a
    mass [kg] may have, in the norm of its entries.

    It has the same principal axes. Its principal moments are sums of two second moments of mass,
    each at least that of the thinnest body.
    """
    moments, axes = np.linalg.eigh(inertia)
    sums = 1 - np.eye(3)
    least = np.full(3, max(mass * THINNEST**2, WRITTEN_SHARE * np.abs(moments).sum()))
    above_least, _ = nnls(sums, moments - sums @ least)
    return np.asarray(axes @ np.diag(sums @ (least + above_least)) @ axes.T)


def change(old: Array, new: Array) -> str:
    """Return two inertia tensors (3, 3) by their entries in the order of a URDF."""
    order = np.triu_indices(3)
    return f"{_listed(old[order])} become {_listed(new[order])} kg m² (ixx ixy ixz iyy iyz izz)"


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in values + 0.0)
