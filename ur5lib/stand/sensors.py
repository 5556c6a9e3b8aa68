"""Readings of force sensor and IMU, each on its own clock, and of the wrist sensor."""

import numpy as np
import pandas as pd
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from ur5lib.channels import columns
from ur5lib.stand.plan import Clock, ForceSensor, Imu, WristSensor
from ur5lib.stand.rig import STEP, Experiment, Rig, States, step_times
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated

FORCE_RATE, IMU_RATE = 207.6, 266.27  # Hz; by their own clocks
IMU_TICK = 0.001  # s; resolution of the IMU's stamps
FORCE_COLUMNS = columns("ft")
IMU_COLUMNS = [name for part in "amg" for name in columns(f"imu_{part}")]

# Force sensor: noise between samples at rest, from the thesis's recordings [N, Nm].
FORCE_NOISE = np.array([0.0013, 0.0015, 0.0022, 5e-5, 5e-5, 4e-5])
# IMU: manufacturer's noise density per √Hz and bandwidth [Hz] (Table 4.5).
GYROSCOPE_NOISE, GYROSCOPE_BANDWIDTH = np.deg2rad(0.05), 40.0
ACCELEROMETER_NOISE, ACCELEROMETER_BANDWIDTH = 0.002, 30.0
MAGNETOMETER_NOISE = 0.001  # relative to the Earth's field: 0.5 of about 500 mGauss
EARTH_FIELD = np.array([0.32, 0.05, -0.73])  # base axes, normalised
# WristReader sensor: noise between samples of a real UR5e at rest [N, Nm].
WRIST_NOISE = np.array([0.22, 0.22, 0.09, 0.006, 0.007, 0.005])
ZEROING_TIME = 0.2  # s; the wrist sensor is zeroed by the mean over this time
MINUTE = 60.0  # s


def force_readings(
    sensor: ForceSensor, motion: States, random: np.random.Generator, noise: bool
) -> pd.DataFrame:
    """Return a force sensor's `time` [s] on its own clock, from its first sample, and ft_* [N, Nm].

    noise: whether values and timestamps are noisy.
    """
    stamps, when, time = _samples(sensor.clock, FORCE_RATE, len(motion), random, noise)
    force = interpolated(when, time, motion["force_sensor"])
    return _table(stamps, read_force(sensor, force, random if noise else None), FORCE_COLUMNS)


def read_force(sensor: ForceSensor, force: Array, random: np.random.Generator | None) -> Array:
    """Return readings of a force sensor (..., 6) [N, Nm].

    force: true force and torque on the arm (..., 6): weight and inertia of the tool, and contacts;
    random: generator of the noise, None for no noise.
    """
    reading = force + sensor.bias
    if random is not None:
        reading += FORCE_NOISE * random.normal(size=reading.shape)
    if sensor.saturation_n is not None:
        reading[..., :3] = reading[..., :3].clip(-sensor.saturation_n, sensor.saturation_n)
    return np.asarray(reading)


def imu_readings(
    imu: Imu, motion: States, random: np.random.Generator, noise: bool
) -> pd.DataFrame:
    """Return an IMU's `time` [s] on its own clock, from its first sample, and imu_* in its axes.

    Specific force [m/s²], magnetic field [normalised], angular rate [rad/s]; arguments as of
    `force_readings`.
    """
    stamps, when, time = _samples(imu.clock, IMU_RATE, len(motion), random, noise)
    if noise:
        stamps = IMU_TICK * np.rint(stamps / IMU_TICK)
    true, rotation = (interpolated(when, time, motion[name]) for name in ("imu", "rotation"))
    reader = ImuReader(imu, IMU_RATE, random if noise else None)
    return _table(stamps, np.hstack(reader.read(true, rotation)), IMU_COLUMNS)


class ImuReader:
    """Reads a simulated IMU, sample after sample: the true motion with the sensor's bias
    and noise.
    """

    def __init__(self, imu: Imu, rate: float, random: np.random.Generator | None) -> None:
        """Begin to read an IMU; rate: of the samples [Hz]; random: generator of the noise, None for
        no noise.
        """
        self._imu, self._random = imu, random
        self._acceleration = ColouredNoise(ACCELEROMETER_NOISE, ACCELEROMETER_BANDWIDTH, rate)
        self._rate = ColouredNoise(GYROSCOPE_NOISE, GYROSCOPE_BANDWIDTH, rate)

    def read(self, true: Array, rotation: Array) -> tuple[Array, Array, Array]:
        """Return the next specific forces [m/s²], fields [normalised] and rates [rad/s] (N, 3).

        true: specific forces and rates (N, 6); rotation: of frame 6, (N, 9).
        """
        acceleration = true[:, :3] + self._imu.accelerometer_bias
        # axes of frame 6; the mounting is neglected because nothing uses the field
        field = EARTH_FIELD @ rotation.reshape(-1, 3, 3)
        rate = true[:, 3:] + self._imu.gyroscope_bias
        if self._random is not None:
            acceleration += self._acceleration.draw(len(true), self._random)
            field += MAGNETOMETER_NOISE * self._random.normal(size=field.shape)
            rate += self._rate.draw(len(true), self._random)
        return acceleration, field, rate


class ColouredNoise:
    """White noise behind a first-order low-pass, sample after sample."""

    def __init__(self, density: float, bandwidth: float, rate: float) -> None:
        """Begin a noise; density: of the white noise [1/√Hz]; bandwidth: of the low-pass [Hz];
        rate: of the samples [Hz].
        """
        self._decay = np.exp(-2 * np.pi * bandwidth / rate)
        self._deviation = density * np.sqrt(bandwidth * np.pi / 2)  # after the low-pass
        self._memory: Array | None = None

    def draw(self, count: int, random: np.random.Generator) -> Array:
        """Return the next samples (count, 3)."""
        fresh = np.sqrt(1 - self._decay**2)
        drive = self._deviation * fresh * random.normal(size=(count, 3))
        if self._memory is None:
            drive[0] /= fresh
            self._memory = np.zeros((1, 3))
        noise, self._memory = lfilter([1.0], [1.0, -self._decay], drive, axis=0, zi=self._memory)
        return np.asarray(noise)


def wrist_channels(
    experiment: Experiment, frames: pd.DataFrame, random: np.random.Generator
) -> dict[str, Array]:
    """Return RTDE's channels of the wrist sensor at the controller's frames [N, Nm].

    `ft_raw_wrench` is the reading in the sensor's axes; `actual_TCP_force` is the reading minus the
    weight of the configured payload, zeroed at the start, in base axes.
    """
    sensor, time = experiment.plan.wrist_sensor, frames["time"].to_numpy()
    assert sensor is not None
    motion, steps = experiment.motion, np.rint(time / STEP).astype(int)
    noise = random if experiment.plan.noise else None
    raw = WristReader(sensor, noise).read(motion["force_sensor"][steps], time)
    rotation = motion["rotation"][steps].reshape(-1, 3, 3)
    force = raw - declared_weight(experiment.rig, rotation)
    force -= force[time <= time[0] + ZEROING_TIME].mean(axis=0)
    force = in_base_axes(force, rotation)
    return named(np.round(raw, 6), "ft_raw_wrench") | named(np.round(force, 6), "actual_TCP_force")


class WristReader:
    """Reads the force sensor in the wrist of an e-Series arm."""

    def __init__(self, sensor: WristSensor, random: np.random.Generator | None) -> None:
        """Begin to read a sensor; random: generator of the noise, None for no noise."""
        self._sensor, self._random = sensor, random
        self._turn = Rotation.from_rotvec(sensor.rotation_deg, degrees=True).as_matrix()

    def read(self, force: Array, time: Array | float) -> Array:
        """Return scale Rᵀ f + bias + drift t, with noise (..., 6) [N, Nm], in the sensor's axes.

        force: on the arm, at the sensor, axes of frame 6 (..., 6); time: (...) [s].
        """
        raw = self.noiseless(force, time)
        if self._random is not None:
            raw += WRIST_NOISE * self._random.normal(size=raw.shape)
        return raw

    def noiseless(self, force: Array, time: Array | float) -> Array:
        """Return scale Rᵀ f + bias + drift t (..., 6) [N, Nm]; arguments as of `read`."""
        sensor, turned = self._sensor, force.reshape(*force.shape[:-1], 2, 3) @ self._turn
        drift = np.multiply.outer(np.divide(time, MINUTE), sensor.drift_per_min)
        return np.asarray(sensor.scale * turned.reshape(force.shape) + sensor.bias + drift)


def declared_weight(rig: Rig, rotation: Array) -> Array:
    """Return the declared payload's weight (..., 6), axes of frame 6; rotation: (..., 3, 3)."""
    declared = rig.declared
    if declared is None:
        return np.zeros((*rotation.shape[:-2], 6))
    force = declared.mass * np.array(rig.robot.gravity) @ rotation
    return np.concatenate([force, np.cross(declared.center_of_mass, force)], axis=-1)


def in_base_axes(wrench: Array, rotation: Array) -> Array:
    """Return wrenches (..., 6) of frame 6's axes in base axes; rotation: (..., 3, 3)."""
    halves = wrench.reshape(*wrench.shape[:-1], 2, 3)
    return np.asarray((halves @ rotation.mT).reshape(wrench.shape))


def _samples(
    clock: Clock, rate: float, steps: int, random: np.random.Generator, noise: bool
) -> tuple[Array, Array, Array]:
    """Return the timestamps (N,) of a device's samples, their true times (N,), and the times
    (steps,) of the simulation's steps, all in [s].

    t_robot = offset + (1 + drift) t_device; all timestamps but the first, which is zero, have
    jitter.
    """
    scale, time = 1 + 1e-6 * clock.drift_ppm, step_times(steps)
    stamps = np.arange(0, (time[-1] - clock.offset_s) / scale, 1 / rate)
    jitter = noise * clock.jitter_s * random.normal(size=len(stamps))
    jitter[0] = 0
    return np.maximum.accumulate(stamps + jitter), clock.offset_s + scale * stamps, time


def _table(time: Array, values: Array, names: list[str]) -> pd.DataFrame:
    return pd.DataFrame({"time": time, **dict(zip(names, values.T, strict=True))})
