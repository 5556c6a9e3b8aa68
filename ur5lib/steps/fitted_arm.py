"""An arm with what was fitted to it."""

from ur5lib.force.residual_model import Residuals
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.opened import Opened
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration


class FittedArm(Opened):
    """What is known of an arm.

    described, identified: without and with the models that were identified; calibration: of its
    IMU, by the recording that it lacks, or `all`.
    """

    described: Robot
    identified: Robot
    rotors: Rotors
    identification: Identification
    calibration: dict[str, ImuCalibration]
    friction: Friction
    residuals: Residuals
