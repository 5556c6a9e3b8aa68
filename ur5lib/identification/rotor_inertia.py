"""The inertia of the motors' rotors, reflected through the gears.

A controller's torque is that of rigid links and rotors (erratum 8): its residual from the rigid
links is proportional to q̈. The rotors' gyroscopic moments are not modelled. Offset and friction
are fitted together with the inertia, although a model's torque contains none: values other than
zero indicate errors in the model of the links.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ur5lib.identification.controllers_torques import RotorSamples
from ur5lib.identification.regression import HUBER_LIMIT
from ur5lib.records.models import Rotors, Terms
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

RECORDING_PARTS = 8  # a single recording is divided into this many


@dataclass(frozen=True)
class RotorFit:
    """Rotor inertias and the terms that should be zero, with their standard errors; NaN for a joint
    that did not move.
    """

    value: Terms
    std_error: Terms


def fit_rotor_inertia(
    residual: Sequence[Array], qd: Sequence[Array], qdd: Sequence[Array]
) -> RotorFit:
    """Return the fit of residual = inertia q̈ + offset + coulomb sign(q̇) + viscous q̇, for each
    joint alone.

    residual, qd, qdd: an array (N, 6) for each recording [Nm, rad/s, rad/s²]. residual is the
    controller's torque minus that of rigid links in the same motion, all low-passed alike or none.
    Rows with NaN are excluded. Huber's loss limits the influence of poses in which the links' model
    is wrong. Such errors are similar throughout a motion and differ between motions, so the
    standard errors are a jackknife over recordings, or over parts of a single one.
    """
    recordings = [
        np.stack(quantities, axis=2) for quantities in zip(residual, qd, qdd, strict=True)
    ]
    parts = recordings if len(recordings) > 1 else np.array_split(recordings[0], RECORDING_PARTS)
    without = [_fit(parts[:k] + parts[k + 1 :]) for k in range(len(parts))]
    std_error = np.sqrt((len(parts) - 1) * np.var(without, axis=0))
    return RotorFit(Terms(*_fit(parts)), Terms(*std_error))


def _fit(parts: Sequence[Array]) -> Array:
    """Return the four terms of each joint, (4, 6); parts: (K, 6, 3) each."""
    samples = np.concatenate(parts)
    return np.stack([_fit_joint(samples[:, joint]) for joint in range(samples.shape[1])], axis=1)


def _fit_joint(samples: Array) -> Array:
    """Return the four terms (4,) of one joint, fitted to residual, q̇ and q̈, (N, 3); NaN if these
    do not determine them.
    """
    residual, qd, qdd = samples[np.isfinite(samples).all(axis=1)].T
    terms = np.stack([qdd, np.ones_like(qdd), np.sign(qd), qd], axis=1)
    if np.linalg.matrix_rank(terms) < terms.shape[1]:
        return np.full(terms.shape[1], np.nan)
    start = np.linalg.lstsq(terms, residual)[0]
    deviation = np.abs(residual - terms @ start).mean()  # the median would be that at rest
    scale = HUBER_LIMIT * np.sqrt(np.pi / 2) * deviation

    def misfit(values: Array) -> Array:
        return (terms @ values - residual) / scale

    return least_squares(misfit, start, loss="huber").x


def fitted_rotors(samples: Mapping[str, RotorSamples | None]) -> Rotors:
    """Return each joint's rotor inertia; samples: of recordings, None where not recorded.

    Empty without any samples.
    """
    known = {name: own for name, own in samples.items() if own is not None}
    if not known:
        return Rotors()
    fit = fit_rotor_inertia(*zip(*known.values(), strict=True))
    return Rotors([*known], fit.value, fit.std_error)


def with_rotors(robot: Robot, rotors: Rotors) -> Robot:
    """Return the arm with its chosen model replaced by "<model>+rotors", which has the determined
    rotor inertias.

    An inertia is determined if it is above zero with 95 %. The other joints keep that of the
    description: one that never accelerates may have a fit of any size. Without any, the arm is
    unchanged.
    """
    if rotors.value is None or rotors.std_error is None:
        return robot
    fitted, std_error = rotors.value.inertia, rotors.std_error.inertia
    determined = fitted > NORMAL95 * std_error  # of a joint without motion, both are NaN
    if not determined.any():
        return robot
    name = f"{robot.chosen_model}+rotors"
    described = name if name in robot.models else robot.chosen_model
    known = np.where(determined, fitted, rigid_bodies(robot, described).rotor_inertia)
    model = robot.models[described].model_copy(update={"rotor_inertias": tuple(known.tolist())})
    return robot.with_model(name, model)
