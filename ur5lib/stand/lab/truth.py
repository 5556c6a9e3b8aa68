"""The true motion and forces of an emulated arm, shared with other processes of the host."""

import tempfile
from pathlib import Path

import numpy as np

from ur5lib.stand.rig import PARTS, STEP
from ur5lib.stand.sensors import EARTH_FIELD
from ur5lib.timeseries.arrays import Array

ROWS = 16384  # of the last steps that are kept
WIDTH = sum(PARTS.values())
COLUMNS = dict(
    zip(PARTS, np.split(np.arange(WIDTH), np.cumsum(list(PARTS.values()))[:-1]), strict=True)
)


class Truth:
    """The last 16 seconds of an arm's true state, in a file that processes map into memory.

    One process writes; any other opens the same path. Its time is the host's time.monotonic.
    """

    def __init__(self, path: str | Path) -> None:
        """Open the file of an emulated arm; `Truth.new` makes one."""
        self.path = str(path)
        rows = np.memmap(path, np.float64, "r+", shape=(ROWS + 1, WIDTH))
        self._head, self._rows = rows[0], rows[1:]

    @classmethod
    def new(cls) -> "Truth":
        """Return an empty truth in a temporary file, which the caller deletes."""
        with tempfile.NamedTemporaryFile(suffix=".truth", delete=False) as file:
            file.truncate((ROWS + 1) * WIDTH * 8)
        return cls(file.name)

    def __reduce__(self) -> tuple[type["Truth"], tuple[str]]:
        return Truth, (self.path,)  # processes share the file, not its content

    def begin(self, start: float, rate: float) -> None:
        """Set the time of the first step [s, host], and the host's seconds per simulated second."""
        self._head[:2] = start, rate

    def append(self, row: Array) -> None:
        """Write the state of the next step, in the order of `rig.PARTS`."""
        count = int(self._head[2])
        self._rows[count % ROWS] = row
        self._head[2] = count + 1

    def latest(self) -> float:
        """Return the time of the last step [s, host]."""
        start, rate, count = self._head[:3]
        return float(start + rate * STEP * (count - 1))

    def since(self, first: int) -> Array:
        """Return the states of all steps from number `first` on (N, WIDTH), in rig.PARTS' order.

        NaN for steps that are no longer in the file.
        """
        count = int(self._head[2])
        steps = np.arange(first, count)
        rows = self._rows[steps % ROWS].copy()
        rows[steps <= int(self._head[2]) - ROWS] = np.nan
        return rows

    def part(self, name: str, when: Array | float) -> Array:
        """Return a quantity of `rig.PARTS` at times (...) [s, host]: (..., components).

        Interpolated between steps; times before or after those kept give the first or last one.
        """
        start, rate, count = self._head[:3]
        step = (np.asarray(when, np.float64) - start) / (rate * STEP)
        step = np.clip(step, max(0, count - ROWS + 2), count - 1)
        before = np.clip(np.floor(step), 0, max(count - 2, 0)).astype(np.int64)
        share = (step - before)[..., None]
        rows = self._rows[:, COLUMNS[name][0] : COLUMNS[name][-1] + 1]
        return np.asarray(
            (1 - share) * rows[before % ROWS] + share * rows[(before + 1) % ROWS], np.float64
        )

    def force_sensor(self, when: Array | float) -> Array:
        """Return the true reading of a force sensor between flange and tool (..., 6) [N, Nm].

        Force and torque of tool and environment on the flange, at the sensor, axes of frame 6.
        """
        return self.part("force_sensor", when)

    def imu(self, when: Array | float) -> Array:
        """Return the true reading of an IMU on the flange (..., 9), in its axes.

        Specific force [m/s²], angular rate [rad/s] and magnetic field [normalised], the last in the
        axes of frame 6.
        """
        rotation = self.part("rotation", when)
        field = EARTH_FIELD @ rotation.reshape(*rotation.shape[:-1], 3, 3)
        return np.concatenate([self.part("imu", when), field], axis=-1)
