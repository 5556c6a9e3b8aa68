"""Rows of tables about the motion beside an IMU: accelerations, its calibration, the smoother."""

from collections.abc import Iterator, Mapping

import numpy as np

from ur5lib.records.accelerations import COMPONENTS, Difference, ImuComparison
from ur5lib.records.motion import MotionAccount
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.tidy import Row
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import InnovationTest
from ur5lib.timeseries.metrics import NORMAL95

CALIBRATED = {"mounting": "rad", "tilt": "rad", "gyroscope_bias": "rad/s", "place": "m"}
CHANNELS = [f"q_{joint}" for joint in range(1, 7)] + [f"qd_{joint}" for joint in range(1, 7)]
CHANNELS += [f"imu_{sensor}{axis}" for sensor in "ag" for axis in "xyz"]


def acceleration_mae(accelerations: ImuComparison) -> Iterator[Row]:
    """Yield the MAE of the end effector's acceleration against the IMU."""
    for estimate, errors in accelerations.errors.items():
        for component, mae in errors.mae.items():
            yield {
                "estimate": estimate,
                "component": component,
                "mae": mae,
                "zero_mae": errors.zero_mae[component],
            }


def acceleration_bands(
    accelerations: ImuComparison, every: Mapping[str, ImuComparison]
) -> Iterator[Row]:
    """Yield RMS differences from the IMU by range of frequency, in motion and at rest, the share
    within the band, and the RMS differences of filterpy's plain smoother.

    The band comes from the other recordings and contains all errors: noise of encoders and IMU,
    calibration, bending links. No rows without another recording.
    """
    known = (every[name] for name in accelerations.calibrated_on if name in every)
    ranges = [one.ranges for one in known if one is not accelerations]  # of the others
    for name, states in accelerations.ranges.items():
        for state, found in states.items():
            squares = [part.square for one in ranges if (part := one.get(name, {}).get(state))]
            if squares:
                std = np.sqrt(np.mean(squares, axis=0))
                rows = _band(found, std, accelerations.plain_ranges[name][state].square)
                yield from ({"range": name, "during": state} | row for row in rows)


def _band(found: Difference, std: Array, plain: Array) -> Iterator[Row]:
    levels = np.linspace(0, 1, len(found.quantiles))  # of the absolute values
    for index, (component, unit) in enumerate(COMPONENTS.items()):
        held = np.interp(NORMAL95 * std[index], found.quantiles[:, index], levels)
        yield {
            "component": component,
            "unit": unit,
            "rms": float(np.sqrt(found.square[index])),
            "std": float(std[index]),
            "held": float(held),
            "filterpy_rms": float(np.sqrt(plain[index])),
        }


def imu_calibration(calibration: dict[str, ImuCalibration]) -> Iterator[Row]:
    """Yield the calibration of an arm's IMU from all `fit` recordings.

    described: place by the arm's description; held_out: error on recordings left out with the
    estimated place, divided by that with the described one; below 1, the estimate is used.
    """
    fit = calibration.get("all")
    for quantity, unit in CALIBRATED.items() if fit else ():
        values, errors = getattr(fit, quantity), getattr(fit, f"{quantity}_std")
        for i, (axis, value, std) in enumerate(zip("xyz", values, errors, strict=False)):
            row: Row = {"quantity": quantity, "axis": axis, "unit": unit}
            row |= {"value": value, "std_error": std}
            if fit and quantity == "place":
                row |= {"described": fit.described[i], "held_out": fit.held_out}
            yield row


def innovations(motion: dict[str, MotionAccount], fused: dict[str, MotionAccount]) -> Iterator[Row]:
    """Yield whether the smoother's innovations are as wide as stated, and white."""
    for estimate, account in (motion | fused).items():
        test: InnovationTest = account.innovations
        for index, channel in enumerate(CHANNELS[: len(test.variance)]):
            low, high = test.variance_limits[index]
            names = ("variance", "portmanteau", "consistent", "white", "colour")
            yield {
                "estimate": estimate,
                "channel": channel,
                "variance_low": low,
                "variance_high": high,
                "portmanteau_limit": test.portmanteau_limit,
            } | {name: getattr(test, name)[index] for name in names}
