"""The map from motion and rigid-body torque to motor current: k i + b = τ + τ_friction.

The current is predicted from it for motion without contact, with its band.
"""

from collections.abc import Iterable, Iterator
from datetime import date

import numpy as np

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.identification.estimation import physical_values
from ur5lib.identification.regression import half_width
from ur5lib.identification.samples import (
    MIN_UNITS,
    CurrentSamples,
    Smooth,
    columns_of,
    held_columns,
    motion_states,
)
from ur5lib.records.friction import (
    MAX_PRIOR_SHARE,
    CoefficientEstimate,
    CurrentFit,
    Parameter,
)
from ur5lib.robots.friction import (
    OPTIONAL_TERMS,
    TERMS,
    JointMotion,
    coefficient_names,
    usual_at_rest,
)
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

MAX_GAIN_HALF = 0.05  # a gain is determined if its 95 % interval has at most this half-width
# Standard deviation of a joint's friction from day to day, relative, where recordings of one day do
# not show it. On seven dates of a UR10e, it is 0.06 on the most different date and 0.035 on all.
DAY_TO_DAY_STD = 0.07
# The same from recording to recording of a day: median of the joints' Coulomb friction on nine
# recordings of a UR5 0.046, on eight of a UR10e 0.008.
RUN_TO_RUN_STD = 0.03
# Relative variance of a joint's friction d days from a recorded date, σ² = a² + b² d: a prior by a
# UR10e. Its friction differs by 0.012 within a day, 0.02 within a week, and 0.046 after 25 days.
SAME_DAY_STD, DAILY_STD = 0.006, 0.0084
SEASON = 140.0  # recordings without dates count as this many days apart
MIN_BREAKAWAY_TORQUE = 0.1  # Nm
PASSIVE = "coulomb", "viscous", "rotor"  # below zero, these would drive the joint
POSITIVE = ("torque_constant", *(f"{of}{name}" for of in ("", "coupled_") for name in PASSIVE))
OPTIONAL_COEFFICIENTS = coefficient_names(OPTIONAL_TERMS)


def torque_constants(fit: CurrentFit) -> Array:
    """Return the torque constants (n,) [Nm/A] of the joints."""
    return 1 / np.array([joint.estimate.coefficients[0] for joint in fit.joints])


def motor_torque(fit: CurrentFit, current: Array) -> Array:
    """Return the torque k i + b (N, n) [Nm] of currents (N, n) [A]."""
    constant = torque_constants(fit)
    offset = -constant * [joint.estimate.coefficients[1] for joint in fit.joints]
    return np.asarray(current * constant + offset)


def constants_band(fit: CurrentFit) -> Array:
    """Return the half-widths (n,) of the relative 95 % intervals of the torque constants, divided
    by 1.96.

    With few paths, it is more than `constants_doubt`: the standard errors are uncertain, too.
    """
    shares = np.array([joint.estimate.prior_share[0] for joint in fit.joints])
    return half_width(constants_doubt(fit), fit.units, shares) / NORMAL95


def constants_doubt(fit: CurrentFit) -> Array:
    """Return the relative standard errors (n,) of the torque constants."""
    errors = np.array([joint.estimate.std_error[0] for joint in fit.joints])
    return np.abs(errors / torque_constants(fit))


def breakaway_torque(fit: CurrentFit) -> Array:
    """Return Coulomb friction (6,) [Nm], up to which dry friction keeps a joint at rest.

    It excludes the load-dependent part, and is at least MIN_BREAKAWAY_TORQUE.
    """
    coulomb = [
        dry_friction(joint.terms, physical_values(joint.estimate.coefficients))
        for joint in fit.joints
    ]
    return np.maximum(np.array(coulomb), MIN_BREAKAWAY_TORQUE)


def dry_friction(terms: tuple[str, ...], values: Array) -> float:
    """Return the Coulomb friction of a joint, including that of the coupled shaft that it turns
    with.

    values: (P,), constant, offset and friction's coefficients, in [A] or [Nm], as the result.
    """
    friction = dict(zip(coefficient_names(terms), values[2:].tolist(), strict=True))
    return max(0.0, friction["coulomb"]) + abs(friction.get("coupled_coulomb", 0.0))


def predict(fit: CurrentFit, record: CurrentSamples) -> Array:
    """Return the current (N, n) [A] that a fit predicts for a motion without contact; the record's
    current is not used.
    """
    return predicted_currents(fit, motions(record))


def mixed_at_rest(
    fit: CurrentFit, usual: CurrentFit, record: CurrentSamples
) -> tuple[Array, Array]:
    """Return the current [A] that a fit predicts, and its torque constant [Nm/A], (N, n) each,
    where the coefficients of each joint at rest are a mixture with those of a usual fit.

    One path shows neither friction nor offsets of other postures at rest.
    """
    # both are linear in the coefficients, of which 1 / k is one
    own, other = ((predict(one, record), 1 / torque_constants(one)) for one in (fit, usual))
    pairs = zip(own, other, strict=True)
    current, inverse = (usual_at_rest(*pair, record.qd) for pair in pairs)
    return current, 1 / inverse


def motions(record: CurrentSamples) -> Iterator[JointMotion]:
    """Yield the motion of each joint."""
    yield from map(record.joint, range(record.q.shape[1]))


def predicted_currents(fit: CurrentFit, joints: Iterable[JointMotion]) -> Array:
    """Return the currents (N, n) [A] that a fit predicts for the motion of n joints without
    contact.
    """
    currents = [
        columns_of(motion, model.terms)
        @ (model.estimate.coefficients if model.alone is None else model.alone)
        + held_columns(motion, model.distances) @ model.held
        for model, motion in zip(fit.joints, joints, strict=True)
    ]
    return np.stack(currents, axis=1)


def friction_current(fit: CurrentFit, record: CurrentSamples) -> Array:
    """Return the friction part (N, n) [A] of the predicted current in motion."""
    currents = [
        columns_of(motion, model.terms)[:, 2:] @ model.estimate.coefficients[2:]
        for model, motion in zip(fit.joints, motions(record), strict=True)
    ]
    return np.stack(currents, axis=1)


def spring_current(fit: CurrentFit, record: CurrentSamples) -> Array:
    """Return the part (N, n) [A] of the predicted current from springs and counterbalances."""
    currents = []
    for model, motion in zip(fit.joints, motions(record), strict=True):
        is_spring = np.array([name.startswith("balance") for name in model.names()])
        currents.append(columns_of(motion, model.terms) @ (is_spring * model.estimate.coefficients))
    return np.stack(currents, axis=1)


def load_loss(fit: CurrentFit, record: CurrentSamples) -> Array:
    """Return the load-dependent friction (N, n) per Nm of torque that the gears transmit, with its
    sign.
    """
    loss = np.empty_like(record.q)
    for joint, (model, constant) in enumerate(zip(fit.joints, torque_constants(fit), strict=True)):
        coefficient = constant * model.estimate.coefficients[model.names().index("load")]
        loss[:, joint] = coefficient * record.joint(joint).direction
    return loss


def band(fit: CurrentFit, record: CurrentSamples, smooth: Smooth) -> Array:
    """Return the half-width (N, n) [A] of the 95 % band of low-passed predictions, for the day of
    the record.
    """
    by_state = np.array([joint.bands for joint in fit.joints])
    within = np.choose(motion_states(record, smooth), by_state.T[:, None])
    # without any date, a recording that follows another one is of its session
    is_of_session = bool(record.before) and not record.day and not fit.dates
    days = 0.0 if is_of_session else days_apart(record.day, fit.dates)
    differing = friction_std(days)
    between = differing * smooth(friction_current(fit, record), record)
    doubt = smooth(_coefficients_doubt(fit, record), record)
    return np.hypot(within, NORMAL95 * np.hypot(between, doubt))


def friction_std(days: float) -> float:
    """Return the relative standard deviation of friction after some days: σ² = a² + b² d."""
    return float(np.sqrt(SAME_DAY_STD**2 + DAILY_STD**2 * days))


def days_apart(day: str, others: Iterable[str]) -> float:
    """Return the days from a date to the nearest of others (ISO 8601), or SEASON if unknown."""
    known = [date.fromisoformat(other) for other in others if other and day]
    return float(
        min((abs(date.fromisoformat(day) - other).days for other in known), default=SEASON)
    )


def _coefficients_doubt(fit: CurrentFit, record: CurrentSamples) -> Array:
    """Return the standard deviation (N, n) [A] of a prediction due to errors of the coefficients;
    zero of joints without `doubt`.
    """
    doubts = np.zeros_like(record.q)
    for joint, (model, motion) in enumerate(zip(fit.joints, motions(record), strict=True)):
        if model.doubt is not None:
            columns = columns_of(motion, model.terms)
            doubts[:, joint] = np.sqrt(((columns @ model.doubt) * columns).sum(axis=1))
    return doubts


def unseen_difference(
    estimate: CoefficientEstimate, days: int, recordings: int, paths: int
) -> Array:
    """Return the standard deviation (P,) by which a joint's parameters differ between the fitted
    days and all days.

    Friction F of D days and R recordings differs by F √(σ_day² / D + σ_run² / R), reduced by the
    share of the prior. A bootstrap over U paths contains the deviations as if each path had a day
    of its own: σ_day² (1 / D - 1 / U) remains.
    """
    if paths < MIN_UNITS:  # the bootstrap is over stretches
        variance = DAY_TO_DAY_STD**2 / days + RUN_TO_RUN_STD**2 / recordings
    else:
        variance = DAY_TO_DAY_STD**2 * max(0.0, 1 / days - 1 / paths)
    friction = np.abs(physical_values(estimate.coefficients))
    friction[:2] = 0.0  # torque constant and offset
    unseen: Array = friction * np.sqrt(variance) * (1 - estimate.prior_share)
    return unseen


def parameters(fit: CurrentFit, measured: Effort = CURRENT) -> list[Parameter]:
    """Return torque constants [Nm/A], offsets [Nm] and friction [Nm, Nm s/rad, ...] of all joints,
    with errors and whether they are determined.

    measured: torques have gains [Nm/Nm] in place of constants, determined if their 95 % interval is
    at most ± MAX_GAIN_HALF; their offsets, friction and rotors are determined if their sign is. A
    parameter with a sign that would drive the joint is not determined.
    """
    friction = ["offset", *coefficient_names([*TERMS])]
    signed = ["torque_constant", *(friction if measured == TORQUE else ())]
    rows = []
    for joint, model in enumerate(fit.joints, start=1):
        estimate = model.estimate
        values = physical_values(estimate.coefficients)
        half = half_width(estimate.std_error, fit.units, estimate.prior_share)
        half = np.hypot(half, NORMAL95 * model.unseen)
        columns = (values, model.std_error(), values - half, values + half, *estimate.shares)
        for name, *numbers in zip(model.names(), *columns, strict=True):
            value, error, low, high, prior, arm, day, run = numbers
            if name in OPTIONAL_COEFFICIENTS and prior > MAX_PRIOR_SHARE:
                continue  # this joint lacks the term
            # the sign must be determined, too
            has_sign = name not in signed or low > 0 or high < 0
            is_possible = name not in POSITIVE or value > 0
            is_gain = name == "torque_constant" and measured == TORQUE
            is_told = prior < MAX_PRIOR_SHARE and not (is_gain and high - value > MAX_GAIN_HALF)
            is_determined = bool(is_told and has_sign and is_possible)
            shares = prior, arm, day, run
            rows.append(Parameter(joint, name, value, error, (low, high), *shares, is_determined))
    return rows
