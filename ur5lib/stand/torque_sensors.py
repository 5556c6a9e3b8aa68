"""Readings of torque sensors in the joints, in place of motor currents."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.stand.rig import States
from ur5lib.timeseries.arrays import Array

# Share of a joint's friction that acts between its sensor and its link.
FRICTION_SHARE_BEHIND_SENSOR = 0.05
GAIN_ERROR = 0.01  # error of the joints' gains, alternating in sign
BIAS_SHARE = 0.003  # bias over the joint's largest torque, alternating in sign
# Noise over the largest torque, by differences between samples of a real xMate 7's sensors.
NOISE_SHARE = 7e-4
# A controller that senses torque does not record these, as it has no currents.
UNRECORDED_CHANNELS = ("actual_current", "target_current", "target_moment", "actual_TCP_force")


@dataclass(frozen=True)
class TorqueSensors:
    """Torque sensors in the joints, which read gain τ + bias with noise; gain, bias [Nm], noise:
    standard deviation [Nm], (n,) each.
    """

    gain: Array
    bias: Array
    noise: Array

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Return the sensors of an arm."""
        largest = np.array(robot.torque_limits())
        sign = np.array([(-1.0) ** k for k in robot.joint_numbers])
        return cls(1 - GAIN_ERROR * sign, BIAS_SHARE * sign * largest, NOISE_SHARE * largest)

    def channels(
        self, values: dict[str, Array], states: States, random: np.random.Generator | None
    ) -> dict[str, Array]:
        """Return the controller's channels with `actual_torque` [Nm] in place of those that follow
        from motor currents.

        random: generator of the noise, None for no noise.
        """
        torque = (
            states["motor_torque"] - (1 - FRICTION_SHARE_BEHIND_SENSOR) * states["friction_torque"]
        )
        reading = self.gain * torque + self.bias
        if random is not None:
            reading += self.noise * random.normal(size=reading.shape)
        recorded = {
            name: value for name, value in values.items() if name not in UNRECORDED_CHANNELS
        }
        return recorded | {"actual_torque": reading}
