"""Torque sensors between the gears and the links of a simulated arm, as a Panda or an iiwa has."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.stand.rig import States
from ur5lib.timeseries.arrays import Array

BEHIND = 0.05  # share of a joint's friction that lies between its sensor and its link
GAIN_ERROR, BIAS = 0.01, 0.003  # of all joints, alternating in sign; share of the largest torque
# Share of the largest torque, by the differences between samples of a real xMate 7's sensors.
NOISE = 7e-4
NOT_STATED = ("actual_current", "target_current", "target_moment", "actual_TCP_force")


@dataclass(frozen=True)
class TorqueSensors:
    """Sensors that read gain τ + bias, each (n,); bias, noise: [Nm]."""

    gain: Array
    bias: Array
    noise: Array

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Return the sensors of an arm."""
        largest = np.array([robot.motor(joint).torque_max for joint in robot.joint_numbers])
        sign = np.array([(-1.0) ** k for k in robot.joint_numbers])
        return cls(1 - GAIN_ERROR * sign, BIAS * sign * largest, NOISE * largest)

    def channels(
        self, values: dict[str, Array], states: States, random: np.random.Generator | None
    ) -> dict[str, Array]:
        """Return the controller's channels with `actual_torque` [Nm] in place of those of currents.

        random: generator of the noise, None for no noise.
        """
        torque = states["motor_torque"] - (1 - BEHIND) * states["friction_torque"]
        reading = self.gain * torque + self.bias
        if random is not None:
            reading += self.noise * random.normal(size=reading.shape)
        stated = {name: value for name, value in values.items() if name not in NOT_STATED}
        return stated | {"actual_torque": reading}
