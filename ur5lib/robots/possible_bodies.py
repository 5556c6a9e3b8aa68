"""Masses and inertias that a body of positive density can have.

Its second moments of mass, S = ½ tr(I) 1 - I about the centre of mass, are positive definite: no
principal moment of inertia exceeds the sum of the others (Wensing).
"""

import numpy as np
import scipy  # loads scipy.optimize at its first use

from ur5lib.robots.inertia import WRITTEN_SHARE
from ur5lib.timeseries.arrays import Array

THINNEST = 1e-4  # m; radius of gyration of a sheet across its plane
# A sheet's principal moments, written with three digits, err by this share of their sum.
ROUNDING = 1e-3


def impossibility(mass: float, inertia: Array) -> str:
    """Return why no body has a mass [kg] and inertia (3, 3) [kg m²], in words; empty if one may.

    inertia: about the centre of mass; a largest moment above the others' sum by rounding counts as
    possible.
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
    """Return the nearest inertia tensor (3, 3) [kg m²] that a body of a mass [kg] may have.

    Nearest in the norm of its entries; it has the same principal axes. Its principal moments are
    sums of two second moments of mass, each at least that of the thinnest body.
    """
    moments, axes = np.linalg.eigh(inertia)
    sums = 1 - np.eye(3)
    least = np.full(3, max(mass * THINNEST**2, WRITTEN_SHARE * np.abs(moments).sum()))
    above_least, _ = scipy.optimize.nnls(sums, moments - sums @ least)
    return np.asarray(axes @ np.diag(sums @ (least + above_least)) @ axes.T)


def change(old: Array, new: Array) -> str:
    """Return a text with the entries of two inertia tensors (3, 3) in the order of a URDF."""
    order = np.triu_indices(3)
    return f"{_listed(old[order])} become {_listed(new[order])} kg m² (ixx ixy ixz iyy iyz izz)"


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in values + 0.0)
