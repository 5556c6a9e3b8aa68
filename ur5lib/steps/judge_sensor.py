"""The force sensor's wrench, and every estimate of the contact wrench compared with it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ur5lib.channels import columns
from ur5lib.force.contact_figures import contact_errors, figures_by_contact, force_errors
from ur5lib.force.controller import further_or_controller
from ur5lib.force.estimators import LEADING, STATIC, UNGATED, Stated, all_stated
from ur5lib.force.plain_least_squares import plain_least_squares
from ur5lib.force.sensor import (
    measured_columns,
    mounting_doubt,
    move_to_frame_6,
    offset_doubt,
    opposite_axes,
    wrench_of_environment,
)
from ur5lib.force.sensor_reading import OwnClock, SensorReading, moved_tool, sensor_reading
from ur5lib.force.touched import sensed_contact
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Compared, ForceError, Sensed
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.opened import Opened
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.sensor_offset import OffsetAccount
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.records.table import WRENCH
from ur5lib.records.verdicts import Reason
from ur5lib.robots.description import Robot, Vector3
from ur5lib.signals.resampling import by_stamps
from ur5lib.timeseries.arrays import Array, Mask

JUDGED = ("contact", "missed")  # periods by which a force is judged
SATURATED_SHARE = 0.999  # from this share of its largest value on, a channel counts as saturated


class JudgedSensor(NamedTuple):
    """The force sensor's wrench, and every estimate compared with it; both empty without a
    sensor."""

    sensor: SensorWrenches
    compared: Compared


class Inputs(Opened):
    """What is read of a recording."""

    role: str
    gravity: list[float] | None
    quality: Quality
    force: pd.DataFrame
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    alignment: Alignment
    premises: Premises
    currents: Currents
    forces: Forces
    further: FurtherForces | None


@step("recording", "sensor.parquet compared=beside_sensor.json")
def judge_sensor(
    recording: Inputs,
    arm: Robot,
    friction: Friction,
    bias_window_s: float,
    min_singular_value: float,
    mounting: tuple[Vector3 | None, Vector3 | None] = (None, None),
) -> JudgedSensor:
    """Return the force sensor's wrench, and every estimate of a recording compared with it.

    arm: as fitted; bias_window_s: at the start, free of contact; mounting: place [m] and turn [°]
    of the sensor as the study states them. Errors are not used for judgement if a fit has used the
    recording.
    """
    signals, rotation = recording.signals, recording.kinematics.rotation
    if signals.force_sensor is None:
        return JudgedSensor(SensorWrenches(time=signals.time, segment=signals.segment), Compared())
    robot = arm.mounted(recording.gravity).with_force_sensor(*mounting)
    reading = sensors_reading(recording, robot, bias_window_s)
    sensor = sensor_wrenches(robot, signals, reading, rotation)
    withheld = bool(recording.premises.contradictions.stop_signs or friction.stopped)
    others = further_or_controller(recording.further, arm, signals, withheld)
    estimates = compared_estimates(robot, signals, reading, others, recording.forces)
    torque = recording.currents.external_torque
    if torque is not None and recording.forces.wrench:
        plain = plain_least_squares(torque, recording.kinematics.jacobian, min_singular_value)
        estimates["compensated"] |= {UNGATED: Stated(plain)}
        sensor = replace(sensor, plain=plain)
    channels = recording.quality.saturated_channels()
    at_limit = saturated(signals.force_sensor, recording.force, channels)
    compared = beside_sensor(reading, sensor, estimates, rotation, at_limit)
    is_doubted = compared.offset_doubt is not None
    errors = [used(row, recording.role, is_doubted) for row in compared.errors]
    return JudgedSensor(sensor, replace(compared, errors=errors))


def sensors_reading(recording: Inputs, robot: Robot, bias_window_s: float) -> SensorReading:
    """Return the sensor's reading; robot: under the recording's gravity, with the sensor."""
    signals = recording.signals
    moved = moved_tool(robot, recording.kinematics, recording.motion)
    if (start := recording.quality.starts.get("force")) is None:
        whole = signals.ft_raw_wrench is not None  # otherwise, the controller subtracts its tool
        tool = recording.premises.load.payload if whole else None
        return sensor_reading(robot, signals, moved, bias_window_s, tool)
    clock_std = recording.alignment.clocks["force"].end_std
    step = float(np.diff(recording.force["time"]).mean())
    own = OwnClock(by_stamps(recording.force, start, signals.time, "force"), clock_std, step)
    return sensor_reading(robot, signals, moved, bias_window_s, own=own)


def saturated(reading: Array, force: pd.DataFrame, channels: Sequence[str]) -> Mask:
    """Return the mask (N,) of samples at the largest value of any of the sensor's channels.

    reading: (N, 6); force: the sensor's samples; channels: those that stay at their largest value,
    so that larger forces are not recorded.
    """
    at_limit = np.zeros(len(reading), bool)
    for name in channels:
        values = np.abs(reading[:, columns("ft").index(name)])
        at_limit |= values >= SATURATED_SHARE * force[name].abs().max()
    return at_limit


def sensor_wrenches(
    robot: Robot, signals: Signals, reading: SensorReading, rotation: Array
) -> SensorWrenches:
    """Return the sensor's wrench of the environment on the arm, by kind; rotation: (N, 3, 3)."""
    position = np.array(robot.mounting.force_sensor)

    def at_flange(free: Array) -> Array:
        return move_to_frame_6(wrench_of_environment(free, rotation), rotation, position)

    wrenches = {
        "printed": wrench_of_environment(reading.placed, rotation),
        "corrected": at_flange(reading.placed - reading.start_bias),
        "compensated": at_flange(reading.wrench - reading.untouched),
    }
    if not reading.own_clock:
        del wrenches["printed"]
    return SensorWrenches(time=signals.time, segment=signals.segment, wrench=wrenches)


def compared_estimates(
    robot: Robot,
    signals: Signals,
    reading: SensorReading,
    further: FurtherForces,
    forces: Forces,
) -> dict[str, dict[str, Stated]]:
    """Return the estimates to compare with each kind of reference.

    With a sensor in the arm's wrist, the controller's own force F^u is that sensor's reading: it is
    compared only with the raw reading, or with another sensor that has its own clock.
    """
    other = signals.ft_raw_wrench is not None or reading.own_clock
    itself = set() if other or not robot.wrist_sensor else {"Fu"}
    printed, corrected = (
        {name: own for name, own in kind.items() if name not in itself}
        for kind in (further.printed, further.corrected)
    )
    found = {"printed": {name: Stated(own) for name, own in printed.items()}}
    found["corrected"] = all_stated(forces, corrected)
    return found | {"compensated": {**found["corrected"]}}


def beside_sensor(
    reading: SensorReading,
    sensor: SensorWrenches,
    compared: Mapping[str, Mapping[str, Stated]],
    rotation: Array,
    at_limit: Mask,
) -> Compared:
    """Return offsets of the reading, doubts about them and the mounting, contacts, and errors.

    Contacts and free samples follow from the sensor minus bias and tool weight. With a sensor
    without moments, forces alone are compared; samples where it is saturated, at_limit: (N,), are
    not. compared: by `compared_estimates`.
    """
    best = sensor.wrench["compensated"]
    force = np.linalg.norm(best[:, :3], axis=1)
    measured = measured_columns(best)
    opposite = list[str]()
    if LEADING in compared["compensated"]:
        estimated = compared["compensated"][LEADING].wrench
        opposite = opposite_axes(best[:, :3], estimated[:, :3], rotation)

    def told(reference: Array) -> Array:
        return np.where(at_limit[:, None], np.nan, reference)

    def errors(kind: str, name: str, own: Stated) -> Iterator[ForceError]:
        band = None if own.std is None else own.std[:, measured]
        given = own.wrench[:, measured], band, told(sensor.wrench[kind])[:, measured]
        yield from force_errors(kind, name, figures_by_contact(*given, force, sensor.period))

    account = reading.account()
    return Compared(
        offset=account,
        offset_doubt=offset_doubt(reading.offset, reading.each),
        mounting_doubt=mounting_doubt(reading.offset, opposite),
        sensed=with_bias(sensed_contact(force, sensor.time), account),
        errors=[
            row
            for kind in sensor.wrench
            for name, own in compared[kind].items()
            for row in errors(kind, name, own)
        ],
        contacts=[
            row
            for name, own in compared["compensated"].items()
            for row in contact_errors(name, own, told(best)[:, :3], force, sensor.time)
        ],
    )


def with_bias(sensed: Sensed | None, account: OffsetAccount) -> Sensed | None:
    """Return a row of sensed.csv with the sensor's bias and drift added, None without a row;
    account: with that bias and drift.
    """
    if sensed is None:
        return None
    known: dict[str, Any] = {
        f"{name}_{axis}": float(value)
        for name in ("bias", "bias_std", "drift", "drift_std")
        for axis, value in zip("xyz", getattr(account, name), strict=False)
    }
    return replace(sensed, **known)


def used(row: ForceError, role: str, is_doubted: bool) -> ForceError:
    """Return a row of errors with `use` and `reason` set if it is about a force in contact; others
    unchanged.

    is_doubted: whether the sensor's bias is uncertain.
    """
    if row.kind != "compensated" or row.during not in JUDGED or row.component not in WRENCH[:3]:
        return row
    reason: Reason = "uncalibrated" if row.estimate == STATIC else ""
    if role == "fit":
        reason = "fitted"
    elif is_doubted:
        reason = "sensor_bias"
    return replace(row, use="yes" if reason in ("", "uncalibrated") else "no", reason=reason)
