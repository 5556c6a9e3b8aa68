"""The force sensor in the wrist of a simulated e-Series arm, as RTDE records it."""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from ur5lib.stand.engine import Experiment
from ur5lib.stand.rig import STEP
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

# Noise between samples of a real UR5e at rest [N, Nm].
NOISE = np.array([0.22, 0.22, 0.09, 0.006, 0.007, 0.005])
ZEROED = 0.2  # s, at the start, in which a program zeroes the sensor
MINUTE = 60.0  # s


def wrist_channels(
    experiment: Experiment, frames: pd.DataFrame, random: np.random.Generator
) -> dict[str, Array]:
    """Return RTDE's channels of the wrist sensor at the controller's frames [N, Nm].

    `ft_raw_wrench` is the reading in the sensor's axes; `actual_TCP_force` is the reading less the
    weight of the payload configured at the controller, zeroed at the start, in base axes.
    """
    motion, plan = experiment.motion, experiment.plan
    sensor = plan.wrist_sensor
    assert sensor is not None
    time = frames["time"].to_numpy()
    steps = np.rint(time / STEP).astype(int)
    # scale R^T f + bias + drift t
    turn = Rotation.from_rotvec(sensor.rotation_deg, degrees=True).as_matrix()
    halves = motion.force_sensor[steps].reshape(-1, 2, 3)
    felt = sensor.scale * (halves @ turn).reshape(-1, 6)
    raw = felt + sensor.bias + np.outer(time / MINUTE, sensor.drift_per_min)
    if plan.noise:
        raw += NOISE * random.normal(size=raw.shape)
    # without the declared payload's weight, zeroed
    rotation = motion.rotation[steps].reshape(-1, 3, 3)
    force = raw - _declared_weight(experiment, rotation)
    force -= force[time <= time[0] + ZEROED].mean(axis=0)
    force = np.einsum("nij,nkj->nki", rotation, force.reshape(-1, 2, 3)).reshape(-1, 6)
    return named(np.round(raw, 6), "ft_raw_wrench") | named(np.round(force, 6), "actual_TCP_force")


def _declared_weight(experiment: Experiment, rotation: Array) -> Array:
    """Return the weight (N, 6) of the declared payload, axes of frame 6; rotation: (N, 3, 3)."""
    declared = experiment.declared
    if declared is None:
        return np.zeros((len(rotation), 6))
    force = declared.mass * np.array(experiment.robot.gravity) @ rotation
    return np.concatenate([force, np.cross(declared.center_of_mass, force)], axis=1)
