"""From what a force sensor reads to the wrench on the arm."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from ur5lib.force.external_torque import Mask, finite_rows

Array = NDArray[np.float64]

ROUNDS = 20  # of fitting and leaving contacts out; they settle in fewer
OUTSIDE = 4.0  # standard deviations of the free reading: beyond, something touches
REPEATS = np.array([0.1] * 3 + [0.01] * 3)  # N, Nm: no better than this, after a push
CLEAR = 0.25  # s, that a free sample is away from any contact
TURNED = 0.2  # of the unit vector of gravity in the sensor's axes: below, weight is as good as bias


@dataclass(frozen=True)
class SensorOffset:
    """What the sensor reads without contact: its bias, and the weight of the tool beyond it.

    bias: (6,) [N, Nm]; mass [kg]; moment_arm: mass times centre of mass, (3,) [kg m], sensor
    frame; *_std: their standard errors, NaN mass and arm where the arm turned too little to tell
    weight from bias (the bias then holds both); noise: (6,), standard deviation of a free sample;
    free: (N,), the contact-free samples behind all that.
    """

    bias: Array
    bias_std: Array
    mass: float
    mass_std: float
    moment_arm: Array
    moment_arm_std: Array
    noise: Array
    free: Mask

    def center(self) -> Array:
        """The tool's centre of mass, (3,) [m], in the sensor's frame."""
        return self.moment_arm / self.mass

    def reading(self, rotation: Array, gravity: Array) -> Array:
        """What the sensor reads without contact, (N, 6), at orientations R_6 (N, 3, 3).

        gravity: (3,) [m/s²], base frame.
        """
        parameters = np.concatenate([[self.mass], self.moment_arm])
        weight = _weight_terms(rotation, gravity) @ np.nan_to_num(parameters)
        return weight + self.bias


def fit_offset(reading: Array, rotation: Array, period: float, gravity: Array) -> SensorOffset:
    """Bias, mass and centre of mass from the contact-free samples, which it finds.

    reading: (N, 6), sensor frame, NaN rows allowed; rotation: (N, 3, 3), R_6; period: [s];
    gravity: g (3,) [m/s²], base frame.
    f = R_6^T m g + b_f, n = c x R_6^T m g + b_n. It starts from least deviations; samples off by
    more than 4 standard deviations, and what is near them, are left out, until nothing changes. So
    most of the recording has to be free of contact.
    """
    measured = finite_rows(reading)
    terms = _terms(rotation, gravity, measured)
    free, weight = measured, _least_deviations(terms, reading, measured)
    reach = np.ones(2 * round(CLEAR / period) + 1, bool)
    for _ in range(ROUNDS):
        parameters, left = _fit(terms, reading, free, weight)
        noise = np.maximum(1.4826 * np.median(np.abs(left[free]), axis=0), REPEATS)
        inside = (np.abs(left) <= OUTSIDE * noise).all(axis=1)
        quiet = binary_erosion(inside | ~measured, reach, border_value=1) & measured
        if (quiet == free).all() or not quiet.any():
            break
        free, weight = quiet, np.ones(len(quiet))
    return _offset(terms, parameters, left, free)


def _terms(rotation: Array, gravity: Array, measured: Mask) -> Array:
    """Of mass, mass times arm (3), and bias (6), in the reading: (N, 6, 10).

    The first four are 0 where the arm turns too little to tell weight from bias.
    """
    terms = np.zeros((len(rotation), 6, 10))
    terms[:, :, 4:] = np.eye(6)
    down = gravity / np.linalg.norm(gravity) @ rotation[measured]
    if np.std(down, axis=0).max() > TURNED:
        terms[:, :, :4] = _weight_terms(rotation, gravity)
    return terms


def _weight_terms(rotation: Array, gravity: Array) -> Array:
    """Of mass and mass times arm in the reading: (N, 6, 4)."""
    weight = gravity @ rotation  # R_6^T g, of each kilogram
    terms = np.zeros((len(rotation), 6, 4))
    terms[:, :3, 0] = weight
    terms[:, 3:, 1:] = np.cross(np.eye(3), weight[:, None]).mT
    return terms


def _least_deviations(terms: Array, reading: Array, measured: Mask) -> Array:
    """Weights (N,) by which least squares leave least absolute deviations (Schlossmacher 1973).

    Contacts then do not move the fit, as long as they fill less than half of the time.
    """
    weight = np.ones(len(reading))
    for _ in range(ROUNDS):
        _, left = _fit(terms, reading, measured, weight)
        weight = 1 / np.sqrt(np.maximum(np.linalg.norm(left / REPEATS, axis=1), 1.0))
    return weight


def _fit(terms: Array, reading: Array, free: Mask, weight: Array) -> tuple[Array, Array]:
    """Weighted least squares over the free samples, forces and moments each by their own scale.

    Returns the parameters (10,) and what they leave of every reading (N, 6).
    """
    scale = weight[free, None] / REPEATS
    rows = (terms[free] * scale[..., None]).reshape(-1, 10)
    values = (reading[free] * scale).ravel()
    parameters = np.linalg.pinv(rows.T @ rows, hermitian=True) @ (rows.T @ values)
    return parameters, reading - terms @ parameters


def _offset(terms: Array, parameters: Array, left: Array, free: Mask) -> SensorOffset:
    noise = left[free].std(axis=0)
    deviation = np.sqrt(np.diag(_covariance(terms[free], left[free], noise)))
    weighed = terms[:, :, :4].any()
    weight, weight_std = (np.where(weighed, x[:4], np.nan) for x in (parameters, deviation))
    return SensorOffset(
        bias=parameters[4:],
        bias_std=deviation[4:],
        mass=float(weight[0]),
        mass_std=float(weight_std[0]),
        moment_arm=weight[1:],
        moment_arm_std=weight_std[1:],
        noise=noise,
        free=free,
    )


def _covariance(terms: Array, left: Array, noise: Array) -> Array:
    """Of the parameters (10, 10), as far as errors of neighbouring samples are independent."""
    scale = np.maximum(noise, 1e-12)
    whitened = (terms / scale[:, None]).reshape(-1, 10)
    follows = (left[1:] * left[:-1]).mean() / (left**2).mean() if len(left) > 1 else 0.0
    inflated = (1 + follows) / max(1 - follows, 1e-9)
    return np.linalg.pinv(whitened.T @ whitened) * inflated


def wrench_of_environment(reading: Array, rotation: Array) -> Array:
    """Wrench of the environment on the arm, base axes, at the sensor's origin.

    reading: (N, 6) [N, Nm], sensor frame, without its offset; rotation: (N, 3, 3), R_6. Returns
    (N, 6). The sensor reads what acts on the arm: the tool's weight downwards, and pushes with the
    opposite sign of the motor torque they call for. Equation 6.11 has a minus here, as the
    thesis's estimates are of the arm acting on its environment.
    """
    halves = [rotation @ half[:, :, None] for half in (reading[:, :3], reading[:, 3:])]
    return np.concatenate(halves, axis=1)[..., 0]


def bias(reading: Array, time: Array, window: float) -> Array:
    """Mean reading over the first `window` seconds, which must be free of contact.

    reading: (N, 6), sensor frame; time: (N,) [s]. Returns (6,) [N, Nm]: the sensor's own bias
    and the weight of what is mounted on it, as far as the orientation stays the same.
    """
    measured = finite_rows(reading)
    first = time[measured].min()
    return reading[measured & (time <= first + window)].mean(axis=0)


def move_to_frame_6(wrench: Array, rotation: Array, position: Array) -> Array:
    """The same wrench at the origin of frame 6: n_6 = n + r x F.

    wrench: (N, 6) at the sensor's origin, base axes; rotation: (N, 3, 3), R_6;
    position: (3,) [m], the sensor's origin in frame 6 (Equation 6.10).
    """
    lever = rotation @ position
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.concatenate([force, moment + np.cross(lever, force)], axis=1)
