"""What is wrong with a force sensor, by the weight of its tool: turn, scale, bias, drift.

Without contact, a sensor with the axes R in frame 6 and the scales k reads

    f = diag(k) Rᵀ m p + b + d t,    n = k̄ Rᵀ (c × m p - I α) + b + d t

for a tool of mass m and inertia I with its centre of mass at c, where p = g - a is gravity less
acceleration, and α the angular acceleration. Part of the errors is slow (`slow_covariance`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ur5lib.force.external_torque import finite_rows
from ur5lib.force.free_fit import REPEATABILITY, SensorReadings, least_deviations, settle
from ur5lib.force.sensed_contact import contacts
from ur5lib.force.sensor_drift import slow_covariance
from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array

MAX_AUDIT_SAMPLES = 5_000  # longer recordings are thinned to this many
SECONDS_PER_MINUTE = 60.0
UNIT_PULL = np.ones((1, 3))
# Columns of the regressor of `_terms`.
RESPONSE_COLUMNS = slice(0, 18)
BIAS_COLUMNS = slice(18, 24)
DRIFT_COLUMNS = slice(24, 30)
# Standard deviations of the prior: of a declared mass, a share and a constant part; of an
# undeclared mass; of the drift; of the inertia, that of small tools.
DECLARED_MASS_SHARE_STD = 0.3
DECLARED_MASS_STD = 0.3  # kg
UNDECLARED_MASS_STD = 3.0  # kg
CENTER_DISTANCE_STD = 0.2  # m; of the tool's centre of mass, about the sensor
DRIFT_STD = np.array([5.0] * 3 + [0.5] * 3)  # N/min, Nm/min
INERTIA_STD = 0.02  # kg m²
TURN_STD = 1.0  # rad
SCALE_STD = 0.3
FREE_MASS_STD = 10.0  # kg
SPAN_BEFORE_CONTACT = np.array([-1.25, -0.25])  # s; from the start of a contact
SPAN_AFTER_CONTACT = np.array([0.25, 1.25])  # s; from the end of a contact


@dataclass(frozen=True)
class FreeReading:
    """The reading (N, 6) without contact: response @ pull + bias + drift t.

    response: (6, 3) [kg, kg m]; bias: (6,) [N, Nm] at the start; drift: (6,) [N/min, Nm/min];
    covariance: (30, 30), of response, bias and drift in this order; residual: (N, 6) [N, Nm], from
    contacts and noise; seconds: time without contact.
    """

    response: Array
    bias: Array
    drift: Array
    covariance: Array
    residual: Array
    seconds: float

    def std(self) -> tuple[Array, Array]:
        """Return standard errors of bias and drift, (6,) each."""
        deviation = np.sqrt(np.diag(self.covariance))
        return deviation[BIAS_COLUMNS], deviation[DRIFT_COLUMNS]


@dataclass(frozen=True)
class SensorErrors:
    """A sensor's tool and its errors, each with its standard error.

    mass [kg]; center: (3,) [m], frame 6; turn: (3,) [rad], rotation vector of the sensor's axes in
    frame 6; scale: (3,), of the forces, all 1 where the tool's mass was unknown.
    """

    mass: float
    mass_std: float
    center: Array
    center_std: Array
    turn: Array
    turn_std: Array
    scale: Array
    scale_std: Array


def fit_free_reading(
    reading: Array, pull: Array, spin: Array, time: Array, period: float, tool: Payload | None
) -> FreeReading:
    """Return the fit of the reading without contact; contacts must fill less than half of the time.

    reading: (N, 6) [N, Nm], NaN rows allowed; pull: p (N, 3) [m/s²], at the tool's centre of mass,
    and spin: α (N, 3) [rad/s²], axes of frame 6; time: (N,) [s]; period: [s]; tool: as declared.
    Least squares with a wide prior: parameters that the motion does not excite keep its error.
    """
    stride = slice(None, None, max(1, -(-len(reading) // MAX_AUDIT_SAMPLES)))
    measured = finite_rows(reading) & finite_rows(pull)
    middle = np.median(reading[measured], axis=0)  # of a sensor that was never zeroed
    minutes = (time - time[0]) / SECONDS_PER_MINUTE
    terms = _terms(pull[stride], spin[stride], minutes[stride])
    expected, spread = _expectation(tool)
    prior_precision = 1 / spread**2
    unexpected = reading[stride] - middle - terms @ expected
    thin = SensorReadings(
        unexpected, terms, measured[stride], stride.step * period, prior_precision
    )
    correction, is_free, _ = settle(thin, thin.measured, least_deviations(thin))
    free_residual = (unexpected - terms @ correction)[is_free]
    response, bias, drift, inertia = np.split(expected + correction, [18, 24, 30])
    residual = reading - middle - bias - pull @ response.reshape(6, 3).T - np.outer(minutes, drift)
    residual[:, 3:] -= spin @ inertia.reshape(3, 3).T
    return FreeReading(
        response=response.reshape(6, 3),
        bias=middle + bias,
        drift=drift,
        covariance=_covariance(
            terms[is_free], free_residual, time[stride][is_free], prior_precision
        )[:30, :30],
        residual=residual,
        seconds=float(is_free.sum() * thin.period),
    )


def _covariance(terms: Array, residual: Array, time: Array, prior_precision: Array) -> Array:
    """Return the covariance (39, 39) of the parameters; each belongs to one component only."""
    covariance = np.zeros((39, 39))
    for component, repeats in enumerate(REPEATABILITY):
        columns = np.flatnonzero(
            np.abs(_terms(UNIT_PULL, UNIT_PULL, UNIT_PULL[:, 0]))[0, component]
        )
        part = terms[:, component][:, columns], residual[:, component], time
        covariance[np.ix_(columns, columns)] = slow_covariance(
            *part, repeats**-2, prior_precision[columns]
        )
    return covariance


def _expectation(tool: Payload | None) -> tuple[Array, Array]:
    """Return mean (39,) and standard deviation (39,) of the parameters' prior."""
    mass, center = (tool.mass, np.array(tool.center_of_mass)) if tool else (0.0, np.zeros(3))
    expected = np.zeros(39)
    expected[RESPONSE_COLUMNS] = response_of(
        np.concatenate([np.zeros(3), np.ones(3), [mass], mass * center])
    ).ravel()
    about = DECLARED_MASS_SHARE_STD * mass + DECLARED_MASS_STD if tool else UNDECLARED_MASS_STD
    undetermined = np.full(6, np.inf)
    spread = [
        np.full(9, about),
        np.full(9, about * CENTER_DISTANCE_STD),
        undetermined,
        DRIFT_STD,
        np.full(9, INERTIA_STD),
    ]
    return expected, np.concatenate(spread)


def _terms(pull: Array, spin: Array, minutes: Array) -> Array:
    """Return the regressor (N, 6, 39) of the reading, by columns: response (18), bias (6), drift
    per minute (6), inertia (9).
    """
    terms = np.zeros((len(pull), 6, 39))
    for component in range(6):
        terms[:, component, 3 * component : 3 * component + 3] = np.nan_to_num(pull)
    for component in range(3):
        first = 30 + 3 * component
        terms[:, 3 + component, first : first + 3] = np.nan_to_num(spin)
    terms[:, :, 18:24] = np.eye(6)
    terms[:, :, 24:30] = np.eye(6) * minutes[:, None, None]
    return terms


def fit_sensor_errors(reading: FreeReading, known_mass: float | None) -> SensorErrors:
    """Return the tool and the errors of a sensor that best explain its response.

    known_mass: of the tool [kg]; without it, the scale is taken as 1. Least squares weighted by the
    response's covariance, under wide priors.
    """
    start = np.concatenate([np.zeros(3), np.ones(3), [known_mass or 0.0], np.zeros(3)])
    widths = (0.0, FREE_MASS_STD) if known_mass is None else (SCALE_STD, 0.0)
    width = np.concatenate(
        [[TURN_STD] * 3, [widths[0]] * 3, [widths[1]], [FREE_MASS_STD * CENTER_DISTANCE_STD] * 3]
    )
    is_fitted = width > 0
    values, vectors = np.linalg.eigh(reading.covariance[RESPONSE_COLUMNS, RESPONSE_COLUMNS])
    # W with Wᵀ W = C⁻¹ of the response
    whiten = vectors.T / np.sqrt(np.maximum(values, 1e-12 * values.max()))[:, None]

    def misfit(moved: Array) -> Array:
        parameters = start.copy()
        parameters[is_fitted] += moved * width[is_fitted]
        difference = whiten @ (response_of(parameters) - reading.response).ravel()
        return np.concatenate([difference, moved])

    solution = least_squares(misfit, np.zeros(is_fitted.sum()))
    std = np.zeros(10)
    # cov = (Jᵀ J)⁻¹, in units of the widths
    jacobian = np.asarray(solution.jac)
    std[is_fitted] = width[is_fitted] * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    start[is_fitted] += width[is_fitted] * solution.x
    turn, scale, (mass,), moment = np.split(start, [3, 6, 7])
    turn_std, scale_std, (mass_std,), moment_std = np.split(std, [3, 6, 7])
    center = moment / mass if mass else np.full(3, np.nan)
    # c = h / m: σ_c² = (σ_h² + c² σ_m²) / m²
    center_std = np.hypot(moment_std, center * mass_std) / (abs(mass) or np.nan)
    return SensorErrors(
        float(mass), float(mass_std), center, center_std, turn, turn_std, scale, scale_std
    )


def response_of(parameters: Array) -> Array:
    """Return the response (6, 3) [kg, kg m] to a pull; parameters: (10,), turn [rad], scale, mass
    [kg], and first moments [kg m].
    """
    turn, scale, (mass,), moment = np.split(parameters, [3, 6, 7])
    axes = Rotation.from_rotvec(turn).as_matrix().T
    across = np.cross(moment, np.eye(3)).T  # (m c) × p
    return np.concatenate([scale[:, None] * axes * mass, scale.mean() * axes @ across])


def shifts_after_contacts(reading: FreeReading, time: Array) -> Array:
    """Return the shift of the mean reading, (C, 6) [N, Nm], from the second before to the second
    after each contact. Contacts without a free second on both sides are left out.
    """
    force = np.linalg.norm(reading.residual[:, :3], axis=1)
    touched = np.zeros(len(force), dtype=bool)
    for first, last in (spans := contacts(force)):
        touched[first:last] = True
    free_residual = np.where(touched[:, None], np.nan, reading.residual)
    shifts = [
        _mean_in(free_residual, time, time[last - 1] + SPAN_AFTER_CONTACT)
        - _mean_in(free_residual, time, time[first] + SPAN_BEFORE_CONTACT)
        for first, last in spans
    ]
    complete_shifts = np.array(shifts).reshape(-1, 6)
    return complete_shifts[np.isfinite(complete_shifts).all(axis=1)]


def _mean_in(values: Array, time: Array, span: Array) -> Array:
    """Return the mean (6,) of values (N, 6) from the first to the second time of span (2,) [s], NaN
    where a part of it is unknown.
    """
    rows = (time >= span[0]) & (time <= span[1])
    if span[0] < time[0] or span[1] > time[-1]:
        return np.full(6, np.nan)
    return np.asarray(values[rows].mean(axis=0))
