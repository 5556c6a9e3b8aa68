"""The true motion and forces of a live arm, shared with other processes of the host."""

import os
from pathlib import Path

import numpy as np

from ur5lab.doubles.device_double import DeviceClock, Reading
from ur5lib.stand.plan import ForceSensor, Imu
from ur5lib.stand.rig import STEP, States, state_type
from ur5lib.stand.sensors import ImuReader, read_force
from ur5lib.timeseries.arrays import Array

STATE_TYPE = state_type(6)


class TrueStates:
    """The true states of an arm since it was switched on, read from the file that its process
    writes.

    Times are the host's time.monotonic; clock: the controller's.
    """

    def __init__(self, path: Path, clock: DeviceClock) -> None:
        self._file, self._clock = path.open("rb"), clock

    def latest(self) -> float:
        """Return the time of the last step [s, host]."""
        return self._clock.host(self._clock.offset_s + STEP * (self._count() - 1))

    def states(self, first: int = 0, end: int | None = None) -> States:
        """Return the states from step `first` to before step `end`, by default all."""
        count = (self._count() if end is None else end) - first
        size = STATE_TYPE.itemsize
        return np.frombuffer(os.pread(self._file.fileno(), count * size, first * size), STATE_TYPE)

    def part(self, name: str, when: Array | float) -> Array:
        """Return a quantity of STATE_TYPE at times (...) [s, host], with the shape (...,
        components).

        It is interpolated between steps; before the first and after the last step, it is these
        steps' value.
        """
        last = self._count() - 1
        passed = (np.asarray(when, np.float64) - self._clock.start) / self._clock.scale
        step = np.clip(passed / STEP, 0, last)
        before = np.floor(step).astype(np.int64)
        after, share = np.minimum(before + 1, last), (step - before)[..., None]
        first = int(before.min())
        values = self.states(first, int(after.max()) + 1)[name]
        return np.asarray((1 - share) * values[before - first] + share * values[after - first])

    def _count(self) -> int:
        return os.fstat(self._file.fileno()).st_size // STATE_TYPE.itemsize


def force_reading(truth: TrueStates, sensor: ForceSensor, seed: int | None = 0) -> Reading:
    """Return a function of time that gives a force sensor's reading: force and torque on the arm
    (6,) [N, Nm].

    They are at the sensor, in axes of frame 6. seed: of the noise, None for no noise.
    """
    random = None if seed is None else np.random.default_rng(seed)
    return lambda when: read_force(sensor, truth.part("force_sensor", when), random)


def imu_reading(truth: TrueStates, imu: Imu, rate: float, seed: int | None = 0) -> Reading:
    """Return a function of time that gives an IMU's reading (9,), in its axes; it is called once
    for each sample.

    They are specific force [m/s²], angular rate [rad/s] and magnetic field [normalised]. rate: of
    the samples [Hz]; seed: of the noise, None for no noise.
    """
    reader = ImuReader(imu, rate, None if seed is None else np.random.default_rng(seed))

    def reading(when: float) -> Array:
        true, rotation = (truth.part(name, np.array([when])) for name in ("imu", "rotation"))
        acceleration, field, turning = reader.read(true, rotation)
        return np.concatenate([acceleration[0], turning[0], field[0]])

    return reading
