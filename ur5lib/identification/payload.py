"""The mass on the flange, from motor currents alone.

What an arm carries beyond its model adds a torque linear in the payload's mass and first moments.
Friction grows with it too, so torque and friction are found in turn.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ur5lib.identification.bootstrap import spread
from ur5lib.identification.currents import CurrentFit, predict
from ur5lib.identification.regression import Normal, regress
from ur5lib.identification.samples import STEP, Labels, Record, Smooth, blocks, smoothed_moving

Array = NDArray[np.float64]

ROUNDS = 5
DRAWS = 50
WIDE = 100.0  # kg, kg m; what a payload may be


@dataclass(frozen=True)
class Payload:
    """parameters, std_error: (P,) of the regressor's columns [kg, kg m, ...], the mass first.

    The errors count the recording's blocks, other draws of the recordings fitted on, and what
    may be known beforehand; mass_interval: 95 % [kg].
    """

    parameters: Array
    std_error: Array
    mass_interval: tuple[float, float]


def estimate_payload(
    fit: CurrentFit, record: Record, regressor: Array, smooth: Smooth, seed: int = 0
) -> Payload:
    """Estimate what the flange carries beyond the model behind `record.torque`.

    regressor: (N, 6, P) torque [Nm] per mass [kg], first moment [kg m], ... of the payload; the
    mass comes first. Only joints in motion count: at rest friction hides a load.
    """
    moving = smoothed_moving(record, smooth)
    scale = np.array([joint.band_moving / joint.estimate.coefficients[0] for joint in fit.joints])
    explained = smooth(regressor.reshape(len(regressor), -1), record).reshape(regressor.shape)
    rows = moving & np.isfinite(explained).all(axis=2) & np.isfinite(scale)
    rows[np.arange(len(rows)) % max(1, round(STEP / record.period)) > 0] = False
    block = np.repeat(blocks(record)[:, None], 6, axis=1)[rows]
    columns = (explained / scale[:, None])[rows]

    def solve(drawn: CurrentFit, start: Array, count: Labels, known: Array) -> Array:
        carried = replace(record, torque=record.torque + regressor @ start)
        unexplained = smooth(record.current - predict(drawn, carried), record)
        constant = 1 / np.array([joint.estimate.coefficients[0] for joint in drawn.joints])
        torque = (unexplained * constant / scale)[rows] + columns @ start
        return _solution(columns, torque, block, count, known)

    once = np.ones(1 + block.max(initial=0), dtype=np.int64)
    nothing = np.zeros(regressor.shape[2])
    solution = nothing
    for _ in range(ROUNDS):
        solution = solve(fit, solution, once, nothing)
    generator = np.random.default_rng(seed)
    draws = [
        solve(
            _drawn(fit, generator),
            solution,
            generator.multinomial(len(once), once / len(once)),
            generator.normal(nothing, WIDE),  # so that what the motion does not tell is uncertain
        )
        for _ in range(DRAWS)
    ]
    error = spread(np.array(draws))
    half = error[0] * stats.norm.ppf(0.975)
    return Payload(solution, error, (solution[0] - half, solution[0] + half))


def _solution(columns: Array, torque: Array, block: Labels, count: Labels, known: Array) -> Array:
    """Huber's estimate from the blocks drawn, each as often as counted; known: beforehand."""
    repeated = np.repeat(np.arange(len(block)), count[block])
    size = columns.shape[1]
    wide = Normal(known, np.eye(size) / WIDE**2)
    return regress(columns[repeated], torque[repeated], block[repeated], wide).coefficients


def _drawn(fit: CurrentFit, generator: np.random.Generator) -> CurrentFit:
    """The fit under one other draw of recordings, the same for all joints."""
    draw = generator.integers(len(fit.joints[0].estimate.replicates))
    joints = tuple(
        replace(
            joint,
            estimate=replace(joint.estimate, coefficients=joint.estimate.replicates[draw]),
        )
        for joint in fit.joints
    )
    return replace(fit, joints=joints)
