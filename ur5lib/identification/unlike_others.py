"""Joints whose friction differs from what other arms and the arm's other joints have."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtrc

from ur5lib.errors import Remark, remark
from ur5lib.identification.currents import JointFit
from ur5lib.identification.estimation import estimate_together, physical
from ur5lib.identification.population import Typical
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Samples
from ur5lib.robots.friction import BASE
from ur5lib.timeseries.arrays import Array

UNUSUAL = 1e-3  # chance below which a joint is unlike others
RAREST = 1e-6  # chance below which a normal distribution says nothing
FRICTION = ("coulomb", "viscous")  # that is compared with other arms
VAGUE = 1e3  # relative error that lets a value count for nothing


def without_others(
    joints: Sequence[JointFit], samples: Sequence[Samples], prior: Prior, seed: int
) -> list[JointFit]:
    """Return the joints with friction as the recordings alone show it.

    Typical friction would pull the torque constant along: more current is more friction or a
    smaller constant.
    """
    typical = {name: known for name, known in prior.typical.items() if name not in FRICTION}
    terms, alone = [joint.terms for joint in joints], replace(prior, typical=typical)
    estimates, _ = estimate_together(samples, terms, alone, seed)
    errors = [
        np.maximum(own.std_error, one.estimate.std_error)
        for own, one in zip(estimates, joints, strict=True)
    ]
    found = zip(joints, estimates, errors, strict=True)
    return [replace(one, estimate=replace(own, std_error=error)) for one, own, error in found]


def unlike_others(joints: Sequence[JointFit], prior: Prior) -> Iterator[tuple[int, Remark]]:
    """Yield joints whose friction differs from what other arms and its own arm's joints have.

    The squared deviations of Coulomb and viscous friction add up. With further terms, both are only
    a part of friction, and not compared. odds: one in so many joints differs as much by chance.
    """
    known = {name: prior.typical[name] for name in FRICTION if name in prior.typical}
    if not known:
        return
    compared = [_beside_typical(joints, *pair) for pair in known.items()]
    value, error, spread = map(np.array, zip(*compared, strict=True))
    # the farthest first, which then no longer shifts what is expected of the others
    while True:
        # from the prediction by the other joints: (C⁻¹ y)ⱼ / √(C⁻¹)ⱼⱼ, C the covariance of y
        precision = np.linalg.inv(spread + error[:, None] ** 2 * np.eye(len(joints)))
        variance = np.diagonal(precision, axis1=1, axis2=2)
        deviation = np.matvec(precision, value) / np.sqrt(variance)  # (2, n)
        freedom = np.maximum((error < VAGUE).sum(axis=0), 1)
        chance = chdtrc(freedom, (deviation**2).sum(axis=0))
        joint = int(np.argmin(chance))
        if chance[joint] > UNUSUAL:
            return
        farthest = int(np.argmax(np.abs(deviation[:, joint])))
        name = [*known][farthest]
        words = {"parameter": name, "ratio": float(np.exp(value[farthest, joint]))}
        odds = round(1 / max(float(chance[joint]), RAREST))
        yield joint, remark("unlike other arms", **words, arms=known[name].arms, odds=odds)
        value[:, joint], error[:, joint] = 0.0, VAGUE


def _beside_typical(
    joints: Sequence[JointFit], name: str, known: Typical
) -> tuple[Array, Array, Array]:
    """Return the logarithm of the joints' friction over what is typical (n,) with its standard
    error, VAGUE where incomparable, and the covariance (n, n) of such logarithms among arms.
    """
    place = joints[0].names().index(name)
    value = np.array([physical(one.estimate.coefficients)[place] for one in joints])
    error = np.array([one.std_error()[place] for one in joints])
    comparable = np.array([one.terms == BASE for one in joints]) & (value > 0)
    ratio = np.log(np.where(comparable, value / known.mean, 1.0))
    error = np.divide(error, value, out=np.full_like(value, VAGUE), where=comparable)
    return ratio, error, known.covariance / np.outer(known.mean, known.mean)
