"""Readings of the simulated force sensor and IMU, each on its own clock."""

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from ur5lib.stand.engine import SimulatedMotion
from ur5lib.stand.plan import Clock, ForceSensor, Imu
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated

FORCE_RATE, IMU_RATE = 207.6, 266.27  # Hz, by their own clocks
TICK = 0.001  # s, of the IMU's stamps
FORCE_COLUMNS = [f"ft_{quantity}{axis}" for quantity in "ft" for axis in "xyz"]
IMU_COLUMNS = [f"imu_{quantity}{axis}" for quantity in "amg" for axis in "xyz"]

# Force sensor: noise between samples at rest, from the thesis's recordings [N, Nm].
FORCE_NOISE = np.array([0.0013, 0.0015, 0.0022, 5e-5, 5e-5, 4e-5])
# IMU: manufacturer's noise density per √Hz and bandwidth [Hz] (Table 4.5).
GYROSCOPE_NOISE, GYROSCOPE_BANDWIDTH = np.deg2rad(0.05), 40.0
ACCELEROMETER_NOISE, ACCELEROMETER_BANDWIDTH = 0.002, 30.0
MAGNETOMETER_NOISE = 0.001  # relative to the Earth's field: 0.5 of about 500 mGauss
EARTH_FIELD = np.array([0.32, 0.05, -0.73])  # base axes, normalised


def force_readings(
    sensor: ForceSensor, motion: SimulatedMotion, random: np.random.Generator, noise: bool
) -> pd.DataFrame:
    """Return a force sensor's `time` [s] on its own clock, from its first sample, and ft_* [N, Nm].

    Force and torque on the arm: weight and inertia of the tool, and the contact, plus the bias.
    noise: whether values and timestamps are noisy.
    """
    stamps, when = _samples(sensor.clock, FORCE_RATE, motion, random, noise)
    reading = interpolated(when, motion.time, motion.force_sensor) + sensor.bias
    reading += noise * FORCE_NOISE * random.normal(size=reading.shape)
    if sensor.saturation_n is not None:
        reading[:, :3] = reading[:, :3].clip(-sensor.saturation_n, sensor.saturation_n)
    return _table(stamps, reading, FORCE_COLUMNS)


def imu_readings(
    imu: Imu, motion: SimulatedMotion, random: np.random.Generator, noise: bool
) -> pd.DataFrame:
    """Return an IMU's `time` [s] on its own clock, from its first sample, and imu_* in its axes.

    Specific force [m/s²], magnetic field [normalised], angular rate [rad/s]; arguments as above.
    """
    stamps, when = _samples(imu.clock, IMU_RATE, motion, random, noise)
    if noise:
        stamps = TICK * np.rint(stamps / TICK)
    reading = interpolated(when, motion.time, motion.imu)
    turn = interpolated(when, motion.time, motion.rotation).reshape(-1, 3, 3)
    acceleration = reading[:, :3] + imu.accelerometer_bias
    field = (
        EARTH_FIELD @ turn
    )  # axes of frame 6; the mounting is neglected because nothing uses the field
    rate = reading[:, 3:] + imu.gyroscope_bias
    if noise:
        acceleration += _coloured(ACCELEROMETER_NOISE, ACCELEROMETER_BANDWIDTH, len(when), random)
        field += MAGNETOMETER_NOISE * random.normal(size=field.shape)
        rate += _coloured(GYROSCOPE_NOISE, GYROSCOPE_BANDWIDTH, len(when), random)
    return _table(stamps, np.hstack([acceleration, field, rate]), IMU_COLUMNS)


def _samples(
    clock: Clock, rate: float, motion: SimulatedMotion, random: np.random.Generator, noise: bool
) -> tuple[Array, Array]:
    """Return the timestamps of a device's samples and their true times (N,) [s].

    t_robot = offset + (1 + drift) t_device; all timestamps but the first, which is zero, jitter.
    """
    scale = 1 + 1e-6 * clock.drift_ppm
    stamps = np.arange(0, (motion.time[-1] - clock.offset_s) / scale, 1 / rate)
    jitter = noise * clock.jitter_s * random.normal(size=len(stamps))
    jitter[0] = 0
    return np.maximum.accumulate(stamps + jitter), clock.offset_s + scale * stamps


def _coloured(density: float, bandwidth: float, count: int, random: np.random.Generator) -> Array:
    """Return white noise of a density [1/√Hz] behind a first-order low-pass (N, 3)."""
    decay = np.exp(-2 * np.pi * bandwidth / IMU_RATE)
    deviation = density * np.sqrt(bandwidth * np.pi / 2)  # of the noise after the low-pass
    drive = deviation * np.sqrt(1 - decay**2) * random.normal(size=(count, 3))
    drive[0] /= np.sqrt(1 - decay**2)
    return lfilter([1.0], [1.0, -decay], drive, axis=0)


def _table(time: Array, values: Array, names: list[str]) -> pd.DataFrame:
    return pd.DataFrame({"time": time, **dict(zip(names, values.T, strict=True))})
