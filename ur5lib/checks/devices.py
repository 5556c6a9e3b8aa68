"""Checks of what each device of a recording wrote against what it should have written."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from ur5lib.checks.channels import check_robot
from ur5lib.checks.commanded import without_command
from ur5lib.checks.named_rates import other_named_rate
from ur5lib.checks.parts_of_runs import Ends, as_text
from ur5lib.recordings.intake import Intake
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Device, Finding
from ur5lib.robots.description import FullScale, Robot

CLIPPING_SHARE = 0.999  # from this share of the full scale on, a sample counts as clipped
MIN_SATURATED_SAMPLES = 10  # samples at exactly the same extreme value indicate saturation
MIN_GRAVITY, MAX_GRAVITY = 8.0, 12.0  # m/s², the median specific force that an IMU may measure
# Where an IMU turns, a component of gravity changes at least this much [m/s²].
MIN_GRAVITY_CHANGE = 3.0


def checked_intake(intake: Intake, arm: Robot, names: Iterable[str] = ()) -> Intake:
    """Return an intake with the findings of the checks of its devices added; names: of its files,
    which may state its rate.
    """
    quality, limits = intake.quality, (arm.position_limits(), arm.velocity_limits())
    robot, commanded = without_command(intake.robot, quality.period_s, arm)
    intake = replace(intake, robot=robot)
    shown = check_robot(intake.robot, quality.period_s, *limits, arm.is_counted())
    findings = [*quality.findings, *commanded, *shown, *other_named_rate(names, quality.period_s)]
    for device, table in intake.sensors.items():
        findings += check_sensor(device, table, arm)
    ends = as_text(Ends.of(intake.robot, quality))
    return replace(intake, quality=replace(quality, findings=findings, ends=ends))


def check_sensor(device: Device, table: pd.DataFrame, arm: Robot) -> list[Finding]:
    """Return what shows that a sensor's file is of another sensor, or saturated; table: its
    channels.
    """
    if device == "force":
        return check_force_sensor(table)
    return check_imu(table, arm.mounting.imu_full_scale)


def check_force_sensor(table: pd.DataFrame) -> list[Finding]:
    """Check for saturation and for an IMU file read by mistake. table: `time` and ft_* as read."""
    return [*_saturation(table), *_looks_like_imu(table)]


def check_imu(table: pd.DataFrame, full_scale: FullScale | None) -> list[Finding]:
    """Check for saturation, and that the accelerometer measures gravity.

    table: `time` and imu_* as read; full_scale: of the IMU, None if unknown.
    """
    clipped = _clipped(table, full_scale) if full_scale else ()
    return [*clipped, *_gravity(table)]


def _saturation(table: pd.DataFrame) -> Iterator[Finding]:
    channels = table.drop(columns="time")
    stuck = {
        name: int((column.abs() == column.abs().max()).sum()) for name, column in channels.items()
    }
    saturated = {name: count for name, count in stuck.items() if count >= MIN_SATURATED_SAMPLES}
    if saturated:
        count, channels = max(saturated.values()), (*map(str, saturated),)
        detail = (
            f"{', '.join(channels)} stay at their largest value; larger forces are not recorded"
        )
        yield Finding("force", Found.SATURATION, "warning", count, detail, channels=channels)


def _looks_like_imu(table: pd.DataFrame) -> Iterator[Finding]:
    """Find a force that rotates at the magnitude of gravity: an acceleration, or a 1 kg tool."""
    if "ft_fx" not in table:
        return
    force = table[["ft_fx", "ft_fy", "ft_fz"]].to_numpy()
    low, high = np.quantile(np.linalg.norm(force, axis=1), [0.05, 0.95])
    turns = np.ptp(force, axis=0).max() > MIN_GRAVITY_CHANGE
    if low >= MIN_GRAVITY and high <= MAX_GRAVITY and turns:
        detail = (
            f"the force keeps a magnitude of {number((low + high) / 2, '.3g')} N while it rotates, "
            "like the acceleration from an IMU or the weight of 1 kg; check which file the study "
            "names"
        )
        yield Finding("force", Found.SIZE_OF_GRAVITY, "warning", len(table), detail)


def _clipped(table: pd.DataFrame, full_scale: FullScale) -> Iterator[Finding]:
    """Find samples at the full scale of accelerometer or gyroscope."""
    rate = math.radians(full_scale.angular_rate_deg)
    limits = {"imu_a": full_scale.acceleration, "imu_g": rate}
    channels = {name: limits[name[:5]] for name in table if name[:5] in limits}
    reached = table[[*channels]].abs() >= CLIPPING_SHARE * pd.Series(channels, dtype=float)
    if reached.any(axis=None):
        detail = (
            f"{', '.join(reached.columns[reached.any()])} reach the IMU's full scale "
            f"({number(full_scale.acceleration, 'g')} m/s², "
            f"{number(full_scale.angular_rate_deg, 'g')} °/s); larger values are not recorded"
        )
        count = int(reached.any(axis=1).sum())
        yield Finding("imu", Found.SATURATION, "warning", count, detail)


def _gravity(table: pd.DataFrame) -> Iterator[Finding]:
    if "imu_ax" not in table:
        return
    norm = float(np.median(np.linalg.norm(table[["imu_ax", "imu_ay", "imu_az"]], axis=1)))
    if not MIN_GRAVITY <= norm <= MAX_GRAVITY:
        detail = (
            f"the median specific force is {number(norm, '.3g')} m/s² instead of 9.8 m/s²; check "
            "which file the study names, its columns and its units"
        )
        yield Finding("imu", Found.NO_GRAVITY, "warning", len(table), detail)
