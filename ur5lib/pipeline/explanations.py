"""Ways in which published errors must have been computed, as an erratum describes them."""

from typing import Literal

from pydantic import Field

from ur5lib.robots.description import Vector3
from ur5lib.strict import Strict


class LoopError(Strict):
    """An error of the closed loop with published gains, as it must have been computed.

    quantity: q [rad], qd [rad/s] or torque [Nm]; figure: over time; gains: whose; velocity_gains:
    [1/s] of the joints, 1 to 6, with others; model: whose torque; masses [kg], centers_of_mass [m]:
    of its links, 1 to 6, with others; from_s: first time [s] that counts; places: where between two
    samples the error is taken, 0 to 1, by linear interpolation of all signals.
    """

    quantity: Literal["q", "qd", "torque"]
    figure: Literal["mean", "largest"] = "mean"
    gains: str
    velocity_gains: dict[int, float] = Field(default_factory=dict)
    model: str = ""
    masses: dict[int, float] = Field(default_factory=dict)
    centers_of_mass: dict[int, Vector3] = Field(default_factory=dict)
    from_s: float = 0.0
    places: tuple[float, ...] = (0.0,)


class AccelerationError(Strict):
    """An error of the end effector's acceleration, as it must have been computed.

    The IMU is filtered in its own axes, from rest and with gravity, and rotated afterwards by
    angles as late as the filter makes slow signals. model_delay_s: delay of the modelled one [s].
    """

    model_delay_s: float
