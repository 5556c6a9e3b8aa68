"""All rows of the table of estimates beside the truth."""

from collections.abc import Iterator, Mapping
from functools import partial
from operator import attrgetter

from ur5lib.pipeline.records.accelerations import Accelerations
from ur5lib.pipeline.records.forces import Forces
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.models import Identification, Rotors
from ur5lib.pipeline.records.motion import FusedMotion, Motion
from ur5lib.pipeline.records.truth import TrueParameters, Truth
from ur5lib.pipeline.true_arm import (
    Truths,
    rigid_torques,
    shared,
    true_acceleration,
    true_parameters,
    true_rotors,
)
from ur5lib.report import truth_table
from ur5lib.report.truth_table import Row, joint_numbers
from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.tables import read_record
from ur5lib.timeseries.lowpass import Butterworth

Files = Mapping[str, str]  # paths of one arm's or one recording's results


def arm_rows(files: Files, truths: Truths) -> Iterator[Row]:
    """Yield rows about parameters fitted to several recordings with a common truth.

    files: paths of the arm's results: described, rotors, identification, calibration, friction.
    """
    robot = load_robot(files["described"])
    rotors = read_record(Rotors, files["rotors"])
    if (inertias := shared(truths, rotors.from_, partial(true_rotors, robot))) is not None:
        yield from truth_table.rotor_rows(rotors, inertias)
    identified = read_record(Identification, files["identification"])
    true = shared(truths, identified.from_, partial(true_parameters, robot))
    if true is not None:
        yield from truth_table.parameter_rows(identified, true)
    imu = read_record(dict[str, ImuCalibration], files["calibration"]).get("all")
    if imu and (plan := shared(truths, imu.from_, attrgetter("plan.imu"))):
        yield from truth_table.imu_rows(imu, plan)
    friction = read_record(Friction, files["friction"])
    if truth := shared(truths, friction.from_, attrgetter("drive", "friction")):
        yield from truth_table.friction_rows(friction, *truth)


def recording_rows(files: Files, truth: TrueParameters, design: Butterworth) -> list[Row]:
    """Return rows about one recording; design: low-pass of the accelerations.

    files: paths of its clocks, motion, fused, accelerations, forces and truth, and of the described
    and the fitted arm.
    """
    motion, fused = Motion.read(files["motion"]), FusedMotion.read(files["fused"])
    true = Truth.read(files["truth"]).at(motion.time)
    robot = load_robot(files["described"])
    acceleration = true_acceleration(robot, true, motion.segment, design)
    motions = {"encoders": motion, "encoders+imu": fused}
    return [
        *truth_table.clock_rows(read_record(dict[str, SettledClock], files["clocks"]), truth),
        *truth_table.joint_acceleration_rows(motions, true),
        *truth_table.end_effector_rows(Accelerations.read(files["accelerations"]), acceleration),
        *torque_rows(load_robot(files["fitted"]), truth, true),
        *truth_table.wrench_rows(Forces.read(files["forces"]), true),
    ]


def torque_rows(robot: Robot, truth: TrueParameters, true: Truth) -> Iterator[Row]:
    """Yield the RMSE of models' torques at the true motion, against those of the simulated arm."""
    rigid = true.motor_torque - true.friction_torque + true.contact_torque
    joints = joint_numbers(rigid)
    for model, torque in rigid_torques(robot, truth, true).items():
        for row in truth_table.errors("torque", joints, ["Nm"] * len(joints), rigid, torque):
            yield row | {"method": f"Model {model}"}
