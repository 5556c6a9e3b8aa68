"""Readings of the sensors on an emulated arm: the truth with bias and noise."""

import numpy as np

from ur5lib.stand.lab.truth import Truth
from ur5lib.stand.plan import ForceSensor, Imu
from ur5lib.stand.sensors import (
    ACCELEROMETER_BANDWIDTH,
    ACCELEROMETER_NOISE,
    FORCE_NOISE,
    GYROSCOPE_BANDWIDTH,
    GYROSCOPE_NOISE,
    MAGNETOMETER_NOISE,
)
from ur5lib.timeseries.arrays import Array


class ForceReading:
    """A force sensor: called with the host's time.monotonic [s], it returns (6,) [N, Nm].

    Force and torque on the arm, at the sensor, axes of frame 6: weight and inertia of the tool, the
    contact, the bias.
    """

    def __init__(self, truth: Truth, sensor: ForceSensor, seed: int | None = 0) -> None:
        """seed: of the noise, None for no noise."""
        self._truth, self._bias = truth, np.array(sensor.bias)
        self._random = None if seed is None else np.random.default_rng(seed)

    def __call__(self, when: float) -> Array:
        """Return the reading at a time [s]."""
        reading = self._truth.force_sensor(when) + self._bias
        if self._random is not None:
            reading = reading + FORCE_NOISE * self._random.normal(size=6)
        return reading


class ImuReading:
    """An IMU: called with the host's time.monotonic [s], in order, it returns (9,) in its axes.

    Specific force [m/s²], angular rate [rad/s] and magnetic field [normalised].
    """

    def __init__(self, truth: Truth, imu: Imu, seed: int | None = 0) -> None:
        """seed: of the noise, None for no noise."""
        self._truth = truth
        self._bias = np.concatenate([imu.accelerometer_bias, imu.gyroscope_bias, np.zeros(3)])
        self._random = None if seed is None else np.random.default_rng(seed)
        self._noise, self._before = np.zeros(6), -np.inf

    def __call__(self, when: float) -> Array:
        """Return the reading at a time [s]."""
        reading = self._truth.imu(when) + self._bias
        if self._random is not None:
            field_noise = MAGNETOMETER_NOISE * self._random.normal(size=3)
            reading = reading + np.concatenate([self._coloured(when, self._random), field_noise])
        return reading

    def _coloured(self, when: float, random: np.random.Generator) -> Array:
        """Return low-passed white noise (6,), correlated with that of the previous reading."""
        decay = np.exp(-2 * np.pi * BANDWIDTH * (when - self._before))
        drawn = DEVIATION * np.sqrt(1 - decay**2) * random.normal(size=6)
        self._noise, self._before = decay * self._noise + drawn, when
        return self._noise


BANDWIDTH = np.repeat([ACCELEROMETER_BANDWIDTH, GYROSCOPE_BANDWIDTH], 3)  # Hz
DEVIATION = np.repeat([ACCELEROMETER_NOISE, GYROSCOPE_NOISE], 3) * np.sqrt(BANDWIDTH * np.pi / 2)
