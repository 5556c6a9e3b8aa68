"""The condition of each joint on one recording: the quantities that wear, grease and age change.

Friction and the current's offset are fitted to one recording, with the torque constant and all
other terms fixed at the arm's fit. The torque constant comes from a second fit, with friction free.
One recording alone determines it badly; fixing it in the first fit keeps its error out of the
friction.
"""

import numpy as np

from ur5lib.identification.joint_regression import MIN_SAMPLES
from ur5lib.identification.regression import Normal, regress
from ur5lib.identification.samples import (
    CurrentSamples,
    JointSamples,
    Smooth,
    blocks,
    joint_samples,
)
from ur5lib.records.friction import CurrentFit, JointFit
from ur5lib.robots.friction import coefficient_names
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken

QUANTITIES = ("coulomb", "viscous", "torque_constant", "offset", "noise")
# Columns of these coefficients in a joint's regressor.
FITTED_COLUMNS = {"offset": 1, "coulomb": 2, "viscous": 3}
MAX_CONSTANT_ERROR = 0.2  # beyond this relative error, a torque constant is not stated
UNKNOWN_ESTIMATE = float("nan"), float("nan")  # value and standard error
Estimates = dict[str, tuple[float, float]]


def joint_conditions(record: CurrentSamples, smooth: Smooth, fit: CurrentFit) -> list[Estimates]:
    """Return value and standard error of each of QUANTITIES, for each of joints 1 to 6.

    record: one contact-free recording; smooth: the low-pass; fit: of its arm. Value and error are
    NaN if the joint moves too little. Standard errors come from this recording only and exclude the
    variation between recordings.
    """
    samples = joint_samples([record], smooth, fit.joints[0].terms)
    noise = _noise(record, smooth)
    return [
        {**_motion_estimates(each_joint.where(each_joint.moving), joint), "noise": level}
        for each_joint, joint, level in zip(samples, fit.joints, noise, strict=True)
    ]


def _motion_estimates(moving: JointSamples, joint: JointFit) -> Estimates:
    """Return value and standard error of offset, friction and torque constant, from samples in
    motion.
    """
    torque, fitted_columns = moving.columns[:, 0], moving.columns[:, [*FITTED_COLUMNS.values()]]
    current = moving.current - _held_current_of_fit(moving, joint)
    inverse = joint.estimate.coefficients[0]
    # offset, Coulomb and viscous friction with the torque constant fixed: k i = τ + τ_friction - b
    value, error = _fitted_coefficients(fitted_columns, current - torque * inverse, moving)
    values, errors = np.array([-1.0, 1.0, 1.0]) * value / inverse, error / inverse
    quantities = dict(
        zip(FITTED_COLUMNS, zip(values.tolist(), errors.tolist(), strict=True), strict=True)
    )
    # torque constant with the terms in FITTED_COLUMNS free
    (value, *_), (error, *_) = _fitted_coefficients(
        np.column_stack([torque, fitted_columns]), current, moving
    )
    determined = value > error / MAX_CONSTANT_ERROR  # false if both are NaN
    constant = (float(1 / value), float(error / value**2)) if determined else UNKNOWN_ESTIMATE
    return {**quantities, "torque_constant": constant}


def _held_current_of_fit(samples: JointSamples, joint: JointFit) -> Array:
    """Return the current (n,) [A] of the friction terms that keep the arm's fitted coefficients."""
    is_held = [name not in FITTED_COLUMNS for name in coefficient_names(joint.terms)]
    current: Array = samples.columns[:, 2:] @ (joint.estimate.coefficients[2:] * is_held)
    return current


def _fitted_coefficients(
    columns: Array, target: Array, samples: JointSamples
) -> tuple[Array, Array]:
    """Return the coefficients (P,) of columns (n, P) fitted to a target (n,), and their standard
    errors (P,); NaN where they are not determined.
    """
    size = columns.shape[1]
    if len(target) < MIN_SAMPLES or np.linalg.matrix_rank(columns) < size:
        return np.full(size, np.nan), np.full(size, np.nan)
    flat = Normal(np.zeros(size), np.zeros((size, size)))
    regression = regress(columns, target, samples.block, flat)
    # Huber's estimate: its samples count by their weights, their errors are correlated in blocks
    information = columns.T @ (columns * regression.weight[:, None])
    return regression.coefficients, np.sqrt(regression.noise * np.diag(np.linalg.inv(information)))


def _noise(record: CurrentSamples, smooth: Smooth) -> list[tuple[float, float]]:
    """Return each joint's RMS current above the low-pass cut-off [A], and its standard error."""
    fast = record.current - smooth(record.current, record)
    parts = [fast[rows] for rows in unbroken(blocks(record))]
    power = np.array([np.nanmean(part**2, axis=0) for part in parts if np.isfinite(part).any()])
    if len(power) < 2:
        return [UNKNOWN_ESTIMATE] * record.current.shape[1]
    root = np.sqrt(power.mean(axis=0))
    # σ_√P = σ_P / (2 √P), of independent blocks
    error = power.std(axis=0, ddof=1) / np.sqrt(len(power)) / (2 * np.maximum(root, 1e-12))
    return [(float(a), float(b)) for a, b in zip(root, error, strict=True)]
