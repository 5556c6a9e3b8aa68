"""Mounting, tilt and gyroscope bias of an arm's IMU."""

from collections.abc import Mapping

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Alignment
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration, calibrate_without_each
from ur5lib.signals.imu_samples import has_valid_imu, imu_samples
from ur5lib.timeseries.lowpass import Butterworth


@step(
    "arm",
    "calibration=imu.json",
    recordings="fit",
    arm="described",
    lowpass="accelerations_lowpass",
)
def calibrate_imu(
    arm: Robot,
    signals: Mapping[str, Signals],
    kinematics: Mapping[str, Kinematics],
    alignment: Mapping[str, Alignment],
    gravities: dict[str, list[float] | None],
    lowpass: Butterworth,
) -> dict[str, ImuCalibration]:
    """Return the calibrations: from all recordings, and for each recording from the others."""
    records = {
        name: imu_samples(arm.mounted(gravities[name]), signals[name], kinematics[name], lowpass)
        for name, one in alignment.items()
        if has_valid_imu(one.clocks)
    }
    return calibrate_without_each(records)
