"""The static estimate of a recording, where no friction was fitted to its arm."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ur5lib.force.static_estimate import at_rest, static_wrench, torque_std
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, Smooth
from ur5lib.pipeline.external_torque import smoothed_external_torque
from ur5lib.pipeline.records.forces import Forces
from ur5lib.timeseries.arrays import Array

LEAST_ERROR = 0.3  # relative, of a torque constant that no recording was fitted for


def needed(friction: Mapping[str, Any], load: Mapping[str, Any]) -> bool:
    """Return whether nothing was fitted, and nothing contradicts the study.

    friction: friction.json; load: torques.json.
    """
    return not (friction["from"] or "stopped" in friction or load["stop_signs"])


def static_forces(
    record: Record, time: Array, jacobian: Array, prior: Prior, smooth: Smooth, cutoff: float
) -> Forces:
    """Return the static estimate where the arm rests, NaN elsewhere.

    time: (N,) [s]; jacobian: (N, 6, 6); prior: of the arm's torque constants; cutoff: of `smooth`
    [Hz].
    """
    inverse = prior.inverse_constant.mean
    error = np.sqrt(np.diag(np.linalg.inv(prior.inverse_constant.precision))) / inverse
    expected = record.torque * inverse
    torque = smoothed_external_torque(record, expected, 1 / inverse, smooth, cutoff)
    torque[~at_rest(record.qd)] = np.nan
    motor = smooth(record.current, record) / inverse
    std = torque_std(motor, np.maximum(error, LEAST_ERROR), prior.torque_max)
    wrench, deviation = static_wrench(torque, std, jacobian)
    return Forces(
        time=time, segment=record.segment, wrench={"static": wrench}, std={"static": deviation}
    )
