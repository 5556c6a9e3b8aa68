"""Joint motion from encoders and IMU by a Kalman smoother, where the IMU is valid."""

from typing import Any

from ur5lib.pipeline.fused_motion import fused_record, imu_model, no_fused_motion
from ur5lib.pipeline.imu_samples import has_valid_imu
from ur5lib.pipeline.smoothed_motion import known_joints, measured, motion_account
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion, MotionAccount, MotionNoise
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import ImuCalibration, calibration_for
from ur5lib.smoothing.imu_fusion import smooth_with_imu
from ur5lib.tables import read_record, write_json


def fuse_imu(input: Any, output: Any, params: Any) -> None:
    record, summary = no_fused_motion(), dict[str, MotionAccount]()
    if has_valid_imu(read_record(dict[str, SettledClock], input.clocks)):
        signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
        robot = load_robot(input.arm).mounted(params.gravity)
        known = read_record(dict[str, ImuCalibration], input.calibration)
        calibration = calibration_for(params.recording, known)
        samples = signals.time, signals.segment, *measured(signals)
        motion = Motion.read(input.motion)
        account = read_record(dict[str, MotionAccount], input.account)["encoders"]
        encoders = known_joints(motion, MotionNoise.read(input.noise), account)
        model = imu_model(robot, kinematics, calibration, motion.qd)
        fused = smooth_with_imu(*samples, signals.imu, model, encoders)
        record, summary = fused_record(signals, fused), {"encoders+imu": motion_account(fused)}
    record.write(output.fused)
    write_json(summary, output.summary)
