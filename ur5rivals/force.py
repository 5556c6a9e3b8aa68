"""The force with its band from an external torque: by least squares, or as F̂ᵐᵃᵖ."""

from collections.abc import Callable, Sequence

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import least_squares_wrench
from ur5lib.force.force_input import ForceInput
from ur5lib.force.residual_model import ResidualModel, TorqueStretch, few_paths, fit_residual_model
from ur5lib.force.wrench_estimate import estimate_wrench, used_rows
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken
from ur5rivals.run import Estimate, Run

TorqueEstimate = Callable[[Run], Array]
"""Returns the external torque (N, 6) [Nm] of a run, NaN where unknown."""

NO_TORQUE = np.zeros(6)  # Nm
CUTOFF_HZ = 2.0  # Hz; of a study's low-pass
TYPICAL_FORCE = 15.0  # N; typical contact with an arm that is not described


def learned_noise(
    torque: TorqueEstimate, runs: Sequence[Run], breakaway: Array = NO_TORQUE
) -> ResidualModel:
    """Return the spread of an estimated torque on contact-free runs, by joint and its state.

    breakaway: torque (6,) [Nm], used only by our own estimate. As for the project's own estimates,
    the spread is wider by Student's t if there are few paths. Raises InputError if a joint never
    moves.
    """
    stretches = [
        TorqueStretch(estimate[rows], run.states[rows], run.period)
        for run in runs
        for estimate in [torque(run)]
        for rows in unbroken(run.segment)
    ]
    model = fit_residual_model(stretches, CUTOFF_HZ, breakaway)
    return model.wider(few_paths(len({run.path for run in runs})))


def force(run: Run, torque: Array, noise: ResidualModel) -> Estimate:
    """Return the force at the origin of frame 6, without a moment: (J_v S⁻¹ J_vᵀ)⁻¹ J_v S⁻¹ τ.

    torque: (N, 6) [Nm]; noise: its spread, S diagonal, as in the project's own least squares.
    """
    wrench, std = np.full_like(torque, np.nan), np.full_like(torque, np.nan)
    finite = np.isfinite(torque).all(axis=1) & np.isfinite(run.jacobian).all(axis=(1, 2))
    spread = noise.spread[run.states[finite], np.arange(6)]
    covariance = spread[:, :, None] ** 2 * np.eye(6)
    wrench[finite], variance = least_squares_wrench(
        torque[finite], run.jacobian[finite], covariance
    )
    std[finite] = np.sqrt(variance)
    return Estimate(wrench, std)


def breakaway_of(runs: Sequence[Run]) -> Array:
    """Return the median breakaway torque (6,) [Nm] of the runs."""
    return np.asarray(np.median([run.breakaway for run in runs], axis=0))


def most_probable(run: Run, torque: Array, noise: ResidualModel) -> Estimate:
    """Return F̂ᵐᵃᵖ, including gate and background, computed from an external torque (N, 6) [Nm].

    noise: of that torque without contact, with the breakaway torque.
    """
    inputs = run.q, run.qd, torque, run.states, run.segment, run.period, None, run.gears
    rows = used_rows(run.segment, run.period, noise.cutoff)
    prior, place = ContactPrior(TYPICAL_FORCE), None
    if run.arm is not None:
        rotation, _ = link_frames(run.arm.robot, run.q[rows])
        prior = ContactPrior.of(run.arm.robot, None, run.arm.place)
        place = run.arm.place.on(rotation[:, -1])
    estimate = estimate_wrench(ForceInput(*inputs), run.jacobian[rows], noise, prior, place)
    return Estimate(estimate.wrench, estimate.std)
