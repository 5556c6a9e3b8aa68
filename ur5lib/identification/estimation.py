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
from ur5lib.records.friction import CoefficientEstimate
from ur5lib.robots.friction import BASE_TERMS, coefficient_names
from ur5lib.timeseries.arrays import Array, Labels

VAGUE_PRECISION_SHARE = 1e-6  # with this share of its precision, a prior leaves a value to the data


def estimate_together(
    samples: Sequence[JointSamples], prior: Prior, seed: int = 0
) -> tuple[list[CoefficientEstimate], int]:
    """Return the estimates of all joints, and the number of units that the bootstrap draws.

    Units are paths, or parts of recordings if paths are few; without motion, postures in a row.
    """
    terms = samples[0].terms if samples else BASE_TERMS
    parts = [part for part in (_in_motion(samples, prior), _at_rest(terms, prior)) if part]
    sums = [np.concatenate(joint) for joint in zip(*(part.sums for part in parts), strict=True)]
    record, day = (_labels([getattr(part, name) for part in parts]) for name in ("record", "day"))
    joint_prior, generator = prior.over(terms), np.random.default_rng(seed)
    units = next((part.units() for part in parts if part.units()), 0)
    # the estimate from all blocks, and where it comes from
    solution, precision = _solve(sums, np.ones((1, len(record))), joint_prior)
    prior_share = np.diag(np.linalg.solve(precision, joint_prior.precision))
    covariance = np.asarray(np.linalg.inv(precision), dtype=np.float64)
    # replicates: the prior's mean is drawn, too
    free_prior = replace(prior, pinned=()).over(terms)
    root = np.linalg.cholesky(np.linalg.inv(free_prior.precision))
    # (B, P)
    means = (
        free_prior.mean
        + generator.standard_normal((REPLICATE_COUNT, len(free_prior.mean))) @ root.T
    )
    drawn_prior = Normal(means, joint_prior.precision)
    by_unit, by_block = (  # (B, P) each
        _solve(sums, np.hstack([draw(part.unit, generator) for part in parts]), drawn_prior)[0]
        for draw in (draw_units, draw_blocks)
    )
    # each joint's part, with standard errors in physical units
    estimates, ends = [], np.cumsum([joint.shape[1] for joint in sums])
    for columns, equations in zip(map(slice, [0, *ends[:-1]], ends), sums, strict=True):
        error = standard_error(
            physical_values(by_unit[:, columns]), physical_values(by_block[:, columns]), units
        )
        shares = shares_of_knowledge(
            prior_share[columns], covariance[columns, columns], equations, record, day
        )
        estimates.append(
            CoefficientEstimate(solution[0, columns], shares, by_unit[:, columns], error)
        )
    return estimates, units


def shares_of_knowledge(
    prior_share: Array, covariance: Array, equations: Array, record: Labels, day: Labels
) -> Array:
    """Return from where the information on a joint's coefficients comes, as four shares that add up
    to one, (4, P).

    They come from: the prior; recordings of other days than that of the most informative recording
    r; others of its day; r. The prior's share is the diagonal of M⁻¹ Λ (Rodgers 2000), Λ the
    prior's precision, M that of the posterior; the rest is divided in proportion to the recordings'
    parts of the variance, the diagonals of M⁻¹ I M⁻¹. covariance: M⁻¹ (P, P) of the joint;
    equations: `block_sums`; record, day: (count,) labels of the blocks.
    """
    # (count, P)
    block_variance = np.einsum("ij,bjk,ki->bi", covariance, equations[..., :-1], covariance)
    recordings = [record == label for label in np.unique(record)]
    # (R, P)
    variance_share = np.array([block_variance[blocks].sum(axis=0) for blocks in recordings])
    total = variance_share.sum(axis=0)
    variance_share *= np.divide(1 - prior_share, total, out=np.zeros_like(total), where=total > 0)
    days = np.array([day[blocks].max() for blocks in recordings])
    same = days[:, None] == days[variance_share.argmax(axis=0)]
    of_day, run = (variance_share * same).sum(axis=0), variance_share.max(axis=0)
    return np.stack([prior_share, (variance_share * ~same).sum(axis=0), of_day - run, run])


def with_fuller_errors(
    estimate: CoefficientEstimate, fuller: CoefficientEstimate
) -> CoefficientEstimate:
    """Return an estimate with standard errors that contain the effect of further terms.

    fuller: the estimate with these terms after the others. The errors are those of `fuller` and the
    difference of both estimates, in quadrature.
    """
    value, fuller_value = (
        physical_values(estimate.coefficients),
        physical_values(fuller.coefficients),
    )
    size = len(value)
    error = np.hypot(fuller.std_error[:size], fuller_value[:size] - value)
    return replace(estimate, std_error=error)


def physical_values(coefficients: Array) -> Array:
    """Return k [Nm/A], b [Nm] and friction [Nm, ...] for coefficients (..., P) of the current."""
    constant = 1 / coefficients[..., :1]
    return np.concatenate(
        [constant, -constant * coefficients[..., 1:2], constant * coefficients[..., 2:]], axis=-1
    )


@dataclass(frozen=True)
class NormalEquations:
    """The normal equations of the joints' coefficients, block by block.

    sums: `block_sums` of each joint; unit: label of the unit of each block, -1 if it has no
    samples; record, day: labels of each block, 0 if it has no samples.
    """

    sums: list[Array]
    unit: Labels
    record: Labels
    day: Labels

    def units(self) -> int:
        """Return the number of different units."""
        return len(np.unique(self.unit[self.unit >= 0]))


def _in_motion(samples: Sequence[JointSamples], prior: Prior) -> NormalEquations | None:
    """Return the normal equations of samples in motion; None without samples."""
    if not samples:
        return None
    count = 1 + max(int(joint.block.max(initial=0)) for joint in samples)
    sums = [
        _normal_equations(joint_samples, prior.of_joint(j), count)
        for j, joint_samples in enumerate(samples)
    ]
    unit = np.full(count, -1)
    record, day = np.zeros((2, count), dtype=np.int64)
    for joint_samples in samples:
        unit[joint_samples.block] = joint_samples.unit
        record[joint_samples.block], day[joint_samples.block] = (
            joint_samples.record,
            joint_samples.day,
        )
    return NormalEquations(sums, unit, record, day)


def _at_rest(terms: Sequence[str], prior: Prior) -> NormalEquations | None:
    """Return the normal equations of torque constants by postures at rest, each a block; None
    without any.

    Each recording counts as a day.
    """
    postures = prior.at_rest
    if postures is None:
        return None
    block, sums = np.arange(len(postures.record)), []
    size = 2 + len(coefficient_names(terms))
    for joint in range(postures.torque.shape[1]):
        joint_prior, design = prior.of_joint(joint), postures.torque[:, joint, None]
        current, noise = postures.current[:, joint], joint_prior.noise_at_rest()
        # without the prior: otherwise, contradictions of it would count as noise
        vague = Normal(
            joint_prior.inverse_constant.mean,
            VAGUE_PRECISION_SHARE * joint_prior.inverse_constant.precision,
        )
        fit = regress(design, current, block, vague, float(noise[0]))
        of_constant = _newton_step(fit, design, current, block, len(block))
        equations = np.zeros((len(block), size, size + 1))
        equations[:, 0, [0, -1]] = of_constant[:, 0]
        sums.append(equations)
    return NormalEquations(sums, postures.stretches(), postures.record, postures.record)


def _labels(parts: Sequence[Labels]) -> Labels:
    """Return the labels of all parts one after the other, shifted so that no two parts have a label
    in common.
    """
    firsts = np.cumsum([0, *(labels.max() + 1 for labels in parts[:-1])])
    return np.concatenate([first + labels for first, labels in zip(firsts, parts, strict=True)])


def _normal_equations(samples: JointSamples, prior: Prior, count: int) -> Array:
    """Return `block_sums` of the samples of a joint in motion."""
    fit, moving = regress_samples(samples, prior), samples.where(samples.moving)
    return _newton_step(fit, moving.columns, moving.current, moving.block, count)


def _newton_step(
    fit: Regression, design: Array, current: Array, block: Labels, count: int
) -> Array:
    """Return `block_sums` of one Newton step from Huber's estimate, in units of the estimate's
    noise.

    Samples beyond Huber's limit have a constant gradient and no curvature.
    """
    inlier = (fit.weight == 1.0).astype(float)
    predicted = design @ fit.coefficients
    # gradient Σ w r x and curvature Σ 1[inlier] x xᵀ of Huber's loss, at the estimate
    pull = inlier * predicted + fit.weight * (current - predicted)
    scale = inlier.mean() / fit.noise if len(inlier) else 1.0
    return block_sums(design, scale * inlier, scale * pull, block, count)


def _solve(sums: Sequence[Array], counts: Array, prior: Normal) -> tuple[Array, Array]:
    """Return the coefficients (B, P) of all joints for each of B draws of blocks, and the precision
    (P, P) of the first.

    sums: (count, P_j, P_j + 1) of each joint; counts: (B, count), how often each draw has each
    block.
    """
    size = sum(joint.shape[1] for joint in sums)
    information, right = np.zeros((len(counts), size, size)), np.zeros((len(counts), size))
    start = 0
    for joint in sums:
        drawn_sums = np.tensordot(counts, joint, axes=1)  # (B, P_j, P_j + 1)
        columns = slice(start, start + joint.shape[1])
        information[:, columns, columns], right[:, columns] = (
            drawn_sums[..., :-1],
            drawn_sums[..., -1],
        )
        start = columns.stop
    return posterior_mean(information, right, prior), information[0] + prior.precision
