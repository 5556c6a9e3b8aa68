"""filterpy's extended Kalman filter with fixed noise and a backward pass, to compare ours with."""

from typing import NamedTuple

import numpy as np
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import ExtendedKalmanFilter

from ur5lib.smoothing.noise import RECORDED_RESOLUTION
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import starts, unbroken

CANDIDATE_JERKS = (10.0, 30.0, 100.0, 300.0, 1000.0)  # rad/s³; the most likely is chosen
TUNING_SAMPLES = 300  # the jerk is chosen on this many samples, those with the most motion
SETTLED_GAIN_CHANGE = 1e-10  # below this relative change per sample, the gain stays constant
# Standard deviations of q, q̇, q̈ [rad, rad/s, rad/s²] at the start of a segment.
INITIAL_STD = np.repeat([10.0, 10.0, 100.0], 6)


class PlainMotion(NamedTuple):
    """Velocities [rad/s] and accelerations [rad/s²] of the joints, (N, 6) each."""

    qd: Array
    qdd: Array


def smooth_plainly(segment: Labels, q: Array, qd: Array, period: float) -> PlainMotion:
    """Return the motion by a smoother of constant accelerations.

    segment: (N,) labels, each smoothed on its own; q, qd: (N, 6) [rad, rad/s], NaN where missing;
    period: [s]. Its noise is fixed: white noise of measurements (`white_noise`), and for all joints
    the most likely of `CANDIDATE_JERKS`.
    """
    z = np.hstack([q, qd])
    noise = white_noise(z, segment)
    count = len(z) // TUNING_SAMPLES or 1
    parts = np.array_split(np.arange(len(z)), count)
    busiest = max(parts, key=lambda part: np.nansum(qd[part] ** 2) / len(part))

    def likelihood(jerk: float) -> float:
        return _smoothed_states(z[busiest], starts(segment[busiest]), period, noise, jerk)[1]

    jerk = max(CANDIDATE_JERKS, key=likelihood)
    state, _ = _smoothed_states(z, starts(segment), period, noise, jerk)
    return PlainMotion(state[:, 6:12], state[:, 12:])


def white_noise(z: Array, segment: Labels) -> Array:
    """Return the standard deviations (M,) of white noise in z (N, M): σ² = mean (Δ³z)² / 20.

    Third differences of white noise have 1 + 9 + 9 + 1 = 20 times its variance.
    """
    # a smooth motion has almost no third differences
    differences = [np.diff(z[part], 3, axis=0) for part in unbroken(segment)]
    square = np.nanmean(np.concatenate(differences) ** 2, axis=0) / 20
    return np.maximum(np.sqrt(square), RECORDED_RESOLUTION)


def _smoothed_states(
    z: Array, fresh: Mask, period: float, noise: Array, jerk: float
) -> tuple[Array, float]:
    """Return the states q, q̇, q̈ (N, 18) and the log-likelihood of the filter's innovations."""
    ekf, H, likelihood = ExtendedKalmanFilter(18, 12), np.eye(12, 18), 0.0
    step = np.array([[1, period, period**2 / 2], [0, 1, period], [0, 0, 1]])
    ekf.F, ekf.R = np.kron(step, np.eye(6)), np.diag(noise**2)
    ekf.Q = Q_discrete_white_noise(3, period, (jerk * period) ** 2, 6, order_by_dim=False)
    states, measured_rows = np.empty((len(z), 18)), np.asarray(np.isfinite(z).all(axis=1))
    settled, gains_back = False, list[Array]()
    for k, measured in enumerate(z):
        if settled and measured_rows[k] and not fresh[k]:
            # covariance and gains would stay as they are
            ekf.predict_x()
            ekf.y = measured - ekf.x[:12]
            ekf.x = ekf.x + ekf.K @ ekf.y
            gains_back.append(gains_back[-1])
        else:
            gain = ekf.K
            ekf.predict()
            if fresh[k]:
                ekf.x, ekf.P = np.zeros(18), np.diag(INITIAL_STD**2)
            if measured_rows[k]:
                ekf.update(measured, lambda _: H, lambda x: x[:12])
            # converged, as the noise is fixed
            change, size = (np.abs(of).max(axis=1) for of in (ekf.K - gain, ekf.K))
            settled = bool(measured_rows[k]) and bool((change <= SETTLED_GAIN_CHANGE * size).all())
            # C = P Fᵀ (F P Fᵀ + Q)⁻¹
            carried = ekf.F @ ekf.P
            gains_back.append(np.linalg.solve(carried @ ekf.F.T + ekf.Q, carried).T)
        if measured_rows[k]:
            likelihood -= (ekf.y @ ekf.SI @ ekf.y + np.linalg.slogdet(ekf.S)[1]) / 2
        states[k] = ekf.x
    for k in np.flatnonzero(~fresh[1:])[::-1]:
        # x(k | N) = x(k) + C (x(k+1 | N) - F x(k)) [Rauch, Tung, Striebel 1965]
        states[k] += gains_back[k] @ (states[k + 1] - ekf.F @ states[k])
    return states, likelihood
