"""Joint estimate of all current-torque maps with a prior, and its uncertainty.

The joints are related through the prior of their torque constants only.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.identification.joint_regression import regress_samples
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import (
    REPLICATE_COUNT,
    Normal,
    Regression,
    block_sums,
    draw_blocks,
    draw_units,
    posterior_mean,
    regress,
    standard_error,
)
from ur5lib.identification.samples import JointSamples
from ur5lib.robots.friction import BASE_TERMS, coefficient_names
from ur5lib.timeseries.arrays import Array, Labels

VAGUE_PRECISION_SHARE = 1e-6  # of a precision, which leaves a value to the data


@dataclass(frozen=True)
class CoefficientEstimate:
    """The coefficients of one joint.

    coefficients: (P,), of the torque [A/Nm], an offset [A] and friction terms; shares: (4, P), of
    what is known of them, see `shares_of_knowledge`; replicates: (B, P), of the bootstrap over
    recordings; std_error: (P,), of `physical` values.
    """

    coefficients: Array
    shares: Array
    replicates: Array
    std_error: Array

    @property
    def prior_share(self) -> Array:
        """Return the share (P,) of the variance from the prior."""
        return self.shares[0]


def estimate_together(
    samples: Sequence[JointSamples], prior: Prior, seed: int = 0
) -> tuple[list[CoefficientEstimate], int]:
    """Estimate all joints; return the estimates and the number of units of the bootstrap.

    Units are paths, or stretches if paths are few; without motion, stretches of postures.
    """
    terms = samples[0].terms if samples else BASE_TERMS
    parts = [part for part in (_in_motion(samples, prior), _at_rest(terms, prior)) if part]
    sums = [np.concatenate(joint) for joint in zip(*(part.sums for part in parts), strict=True)]
    record, day = (_labels([getattr(part, name) for part in parts]) for name in ("record", "day"))
    whole, generator = prior.over(terms), np.random.default_rng(seed)
    units = next((part.units() for part in parts if part.units()), 0)
    # the estimate from all blocks, and where it comes from
    solution, precision = _solve(sums, np.ones((1, len(record))), whole)
    prior_share = np.diag(np.linalg.solve(precision, whole.precision))
    covariance = np.asarray(np.linalg.inv(precision), dtype=np.float64)
    # replicates: the prior's mean is drawn, too
    known = replace(prior, pinned=()).over(terms)
    root = np.linalg.cholesky(np.linalg.inv(known.precision))
    means = (
        known.mean + generator.standard_normal((REPLICATE_COUNT, len(known.mean))) @ root.T
    )  # (B, P)
    drawn_prior = Normal(means, whole.precision)
    by_unit, by_block = (  # (B, P) each
        _solve(sums, np.hstack([draw(part.unit, generator) for part in parts]), drawn_prior)[0]
        for draw in (draw_units, draw_blocks)
    )
    # each joint's part, with standard errors in physical units
    estimates, ends = [], np.cumsum([joint.shape[1] for joint in sums])
    for own, equations in zip(map(slice, [0, *ends[:-1]], ends), sums, strict=True):
        drawn = physical(by_unit[:, own]), physical(by_block[:, own])
        error = standard_error(*drawn, units)
        told = prior_share[own], covariance[own, own], equations, record, day
        shares = shares_of_knowledge(*told)
        estimates.append(CoefficientEstimate(solution[0, own], shares, by_unit[:, own], error))
    return estimates, units


def shares_of_knowledge(
    prior_share: Array, covariance: Array, equations: Array, record: Labels, day: Labels
) -> Array:
    """Return the shares (4, P) of what is known of a joint's coefficients, with the sum one.

    From the prior; recordings of other days than the recording r that tells most; others of its
    day; r. The prior's share is the diagonal of M⁻¹ Λ (Rodgers 2000), Λ its information and M that
    of all; the rest is divided as the recordings' parts of the variance, the diagonals of
    M⁻¹ I M⁻¹. covariance: M⁻¹ (P, P) of the joint; equations: `block_sums`; record, day: (count,)
    labels of the blocks.
    """
    each = np.einsum("ij,bjk,ki->bi", covariance, equations[..., :-1], covariance)  # (count, P)
    recordings = [record == label for label in np.unique(record)]
    told = np.array([each[blocks].sum(axis=0) for blocks in recordings])  # (R, P)
    whole = told.sum(axis=0)
    told *= np.divide(1 - prior_share, whole, out=np.zeros_like(whole), where=whole > 0)
    days = np.array([day[blocks].max() for blocks in recordings])
    same = days[:, None] == days[told.argmax(axis=0)]
    of_day, run = (told * same).sum(axis=0), told.max(axis=0)
    return np.stack([prior_share, (told * ~same).sum(axis=0), of_day - run, run])


def beside_fuller(
    estimate: CoefficientEstimate, fuller: CoefficientEstimate
) -> CoefficientEstimate:
    """Return an estimate with standard errors that contain the effect of further terms.

    fuller: the estimate with these terms after the others. The result's standard errors are those
    of the fuller estimate and the difference of both, added in quadrature.
    """
    value, other = physical(estimate.coefficients), physical(fuller.coefficients)
    size = len(value)
    error = np.hypot(fuller.std_error[:size], other[:size] - value)
    return replace(estimate, std_error=error)


def physical(coefficients: Array) -> Array:
    """Convert coefficients (..., P) of the current to k [Nm/A], b [Nm] and friction [Nm, ...]."""
    constant = 1 / coefficients[..., :1]
    return np.concatenate(
        [constant, -constant * coefficients[..., 1:2], constant * coefficients[..., 2:]], axis=-1
    )


@dataclass(frozen=True)
class NormalEquations:
    """What samples tell of the joints' coefficients, block by block.

    sums: `block_sums` of each joint; unit: of each block, -1 for one without samples; record, day:
    its labels, zero for one without samples.
    """

    sums: list[Array]
    unit: Labels
    record: Labels
    day: Labels

    def units(self) -> int:
        """Return the number of units."""
        return len(np.unique(self.unit[self.unit >= 0]))


def _in_motion(samples: Sequence[JointSamples], prior: Prior) -> NormalEquations | None:
    """Return what samples in motion tell; None without any joint's."""
    if not samples:
        return None
    count = 1 + max(int(joint.block.max(initial=0)) for joint in samples)
    sums = [_normal_equations(own, prior.of_joint(j), count) for j, own in enumerate(samples)]
    unit = np.full(count, -1)
    record, day = np.zeros((2, count), dtype=np.int64)
    for own in samples:
        unit[own.block] = own.unit
        record[own.block], day[own.block] = own.record, own.day
    return NormalEquations(sums, unit, record, day)


def _at_rest(terms: Sequence[str], prior: Prior) -> NormalEquations | None:
    """Return what postures at rest tell of torque constants, each a block; None without any.

    A recording of them counts as a day of its own.
    """
    postures = prior.at_rest
    if postures is None:
        return None
    block, sums = np.arange(len(postures.record)), []
    size = 2 + len(coefficient_names(terms))
    for joint in range(postures.torque.shape[1]):
        alone, design = prior.of_joint(joint), postures.torque[:, joint, None]
        current, noise = postures.current[:, joint], alone.noise_at_rest()
        # regardless of the prior, or what contradicts it would count as noise
        vague = Normal(
            alone.inverse_constant.mean, VAGUE_PRECISION_SHARE * alone.inverse_constant.precision
        )
        fit = regress(design, current, block, vague, float(noise[0]))
        of_constant = _newton_step(fit, design, current, block, len(block))
        whole = np.zeros((len(block), size, size + 1))
        whole[:, 0, [0, -1]] = of_constant[:, 0]
        sums.append(whole)
    return NormalEquations(sums, postures.stretches(), postures.record, postures.record)


def _labels(parts: Sequence[Labels]) -> Labels:
    """Return the labels of all parts, none of which is that of another part."""
    firsts = np.cumsum([0, *(own.max() + 1 for own in parts[:-1])])
    return np.concatenate([first + own for first, own in zip(firsts, parts, strict=True)])


def _normal_equations(samples: JointSamples, prior: Prior, count: int) -> Array:
    """Return `block_sums` of the samples of a joint in motion."""
    fit, moving = regress_samples(samples, prior), samples.where(samples.moving)
    return _newton_step(fit, moving.columns, moving.current, moving.block, count)


def _newton_step(
    fit: Regression, design: Array, current: Array, block: Labels, count: int
) -> Array:
    """Return `block_sums` of one Newton step from Huber's estimate.

    Samples beyond Huber's limit have a constant gradient and no curvature. Both are divided by the
    noise of the estimate.
    """
    inlier = (fit.weight == 1.0).astype(float)
    predicted = design @ fit.coefficients
    pull = inlier * predicted + fit.weight * (current - predicted)
    scale = inlier.mean() / fit.noise if len(inlier) else 1.0
    return block_sums(design, scale * inlier, scale * pull, block, count)


def _solve(sums: Sequence[Array], counts: Array, prior: Normal) -> tuple[Array, Array]:
    """Return the coefficients (B, P) of all joints, and the precision (P, P) of the first draw.

    sums: (count, P_j, P_j + 1) of each joint; counts: (B, count), of the blocks in each draw.
    """
    size = sum(joint.shape[1] for joint in sums)
    information, right = np.zeros((len(counts), size, size)), np.zeros((len(counts), size))
    start = 0
    for joint in sums:
        drawn = np.tensordot(counts, joint, axes=1)  # (B, P_j, P_j + 1)
        here = slice(start, start + joint.shape[1])
        information[:, here, here], right[:, here] = drawn[..., :-1], drawn[..., -1]
        start = here.stop
    return posterior_mean(information, right, prior), information[0] + prior.precision
