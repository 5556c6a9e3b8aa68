"""Published errors, computed as an erratum explains them."""

from typing import Protocol

import numpy as np
import pandas as pd

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.carried import configured_payload
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Model, Robot
from ur5lib.robots.end_effector import felt_acceleration
from ur5lib.signals.euler_angles import CAUSAL, through_angles
from ur5lib.signals.imu_samples import derivative, lowpassed
from ur5lib.signals.resampling import by_stamps
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import causal_lowpass, slow_delay
from ur5lib.timeseries.metrics import largest_error, mean_absolute_error
from ur5lib.timeseries.sampling import interpolated
from ur5lib.topics.thesis.closed_loop import published_gains, simulated_states, tracking_of
from ur5lib.topics.thesis.reference import AccelerationError, LoopError


def loop_error(robot: Robot, signals: Signals, way: LoopError) -> Array:
    """Return the error of each joint in closed loop (6,), computed as an erratum explains it.

    robot: under the recording's gravity; way: how the erratum says that it was computed. Raises
    ValueError where a target was not recorded.
    """
    tracking = tracking_of(signals)
    if tracking is None or signals.target_moment is None:
        raise ValueError("the closed loop needs targets, measured motion and target_moment")
    position, velocity = published_gains(robot)[way.gains]
    for joint, gain in way.velocity_gains.items():
        velocity[joint - 1] = gain
    motion = simulated_states(tracking, (position, velocity))
    if way.quantity == "torque":
        arm = _changed(robot, way).carrying(configured_payload(signals))
        error = LinkModel(arm, way.model).inverse_dynamics(*motion) - signals.target_moment
    else:
        measured = {"q": tracking.actual_q, "qd": tracking.actual_qd}
        error = motion[["q", "qd"].index(way.quantity)] - measured[way.quantity]
    counted = ~signals.interpolated & (signals.time >= way.from_s)
    between = _between(np.where(counted[:, None], error, np.nan), way.places)
    figure = mean_absolute_error if way.figure == "mean" else largest_error
    return figure(between, np.zeros_like(between))


class Accelerated(Protocol):
    """What accelerations are explained by."""

    quality: Quality
    imu: pd.DataFrame
    signals: Signals
    kinematics: Kinematics


def explained_accelerations(
    recording: Accelerated, robot: Robot, way: AccelerationError
) -> tuple[Array, Array]:
    """Return the accelerations through Euler angles and of the IMU, (N, 6) [m/s², rad/s²] each,
    computed as an erratum explains.

    robot: under the recording's gravity; way: how the erratum says that they were computed.
    """
    signals, kinematics = recording.signals, recording.kinematics
    start = recording.quality.starts["imu"]

    def smooth(values: Array) -> Array:
        return lowpassed(signals, causal_lowpass, CAUSAL, values)

    ahead = by_stamps(recording.imu, start, signals.time + slow_delay(CAUSAL), "imu")
    own_axes = smooth(ahead[:, :3]), smooth(derivative(signals, ahead[:, 3:]))
    felt = felt_acceleration(kinematics.rotation, *own_axes, -np.array(robot.gravity))
    modelled = through_angles(signals, kinematics, printed=True)
    late = interpolated(signals.time - way.model_delay_s, signals.time, modelled)
    return smooth(late), felt


def _changed(robot: Robot, way: LoopError) -> Robot:
    """Return the arm with the masses and centres of mass that the erratum names."""
    model = robot.models[way.model]
    masses, centers = [*(model.masses or robot.masses)], [*model.centers_of_mass]
    for link, mass in way.masses.items():
        masses[link - 1] = mass
    for link, center in way.centers_of_mass.items():
        centers[link - 1] = center
    changes = {"masses": tuple(masses), "centers_of_mass": tuple(centers)}
    changed: Model = model.model_copy(update=changes)  # links may be massless here
    return robot.with_model(way.model, changed)


def _between(error: Array, places: tuple[float, ...]) -> Array:
    """Return errors (N, 6), interpolated linearly at places from 0 to 1 between samples; NaN next
    to a NaN.
    """
    parts = [error if x == 0 else (1 - x) * error[:-1] + x * error[1:] for x in places]
    return np.concatenate(parts)
