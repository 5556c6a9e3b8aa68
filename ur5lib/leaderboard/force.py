"""From an external torque to a force with its band, by least squares; the same for all rivals."""

from collections.abc import Callable, Sequence

import numpy as np

from ur5lib.force.contact_wrench import least_squares_wrench
from ur5lib.force.residual_model import ResidualModel, Stretch, few_paths, fit_residual_model
from ur5lib.leaderboard.run import Estimate, Run
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken

TorqueEstimate = Callable[[Run], Array]
"""Returns the external torque (N, 6) [Nm] of a run, NaN where unknown."""

NOTHING = np.zeros(6)  # Nm
CUTOFF = 2.0  # Hz; it enters only figures of the residual model that are not used here


def learned_noise(
    torque: TorqueEstimate, runs: Sequence[Run], breakaway: Array = NOTHING
) -> ResidualModel:
    """Return the spread of an estimated torque on contact-free runs, by joint and its state.

    breakaway: (6,) [Nm], up to which dry friction holds a joint; only our own estimate uses it. As
    for the project's own estimates, the spread is wider by Student's t if there are few paths.
    Raises InputError if a joint never moves.
    """
    stretches = [
        Stretch(estimate[rows], run.states[rows], run.period)
        for run in runs
        for estimate in [torque(run)]
        for rows in unbroken(run.segment)
    ]
    model = fit_residual_model(stretches, CUTOFF, breakaway)
    return model.wider(few_paths(len({run.path for run in runs})))


def force(run: Run, torque: Array, noise: ResidualModel) -> Estimate:
    """Return the force at the origin of frame 6, without a moment: (J_v S⁻¹ J_vᵀ)⁻¹ J_v S⁻¹ τ.

    torque: (N, 6) [Nm]; noise: its spread, S diagonal, as in the project's own least squares.
    """
    wrench, std = np.full_like(torque, np.nan), np.full_like(torque, np.nan)
    known = np.isfinite(torque).all(axis=1) & np.isfinite(run.jacobian).all(axis=(1, 2))
    spread = noise.spread[run.states[known], np.arange(6)]
    covariance = spread[:, :, None] ** 2 * np.eye(6)
    wrench[known], variance = least_squares_wrench(torque[known], run.jacobian[known], covariance)
    std[known] = np.sqrt(variance)
    return Estimate(wrench, std)
