"""What is wrong with the force sensor in an arm's wrist, and with its controller's force."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from scipy import stats
from scipy.spatial.transform import Rotation

from ur5lib.force.sensor_reading import in_frame_6, moved_tool, within_reach
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import JudgedLoad, Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.records.table import WRENCH, WRENCH_UNITS
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.end_effector import ToolMotion
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.topics.audit.free_reading import (
    FreeReading,
    SensorErrors,
    fit_free_reading,
    fit_sensor_errors,
    shifts_after_contacts,
)
from ur5lib.topics.audit.rows import AuditRow

# The pull acts at the tool's centre of mass, which the fit finds: both are iterated this often.
CENTER_ROUNDS = 3
# A larger error of the sensor's scale means that the declared payload is wrong, not the sensor.
MAX_SCALE_ERROR_OF_SENSOR = 0.15
MIN_FREE_DURATION = 5.0  # s; the audit needs this much time without contact
# Errors that matter: a quarter of the accuracy in the data sheet, 4 N and 0.3 Nm; 0.05 kg.
MIN_WRENCH_ERROR = np.array([1.0] * 3 + [0.1] * 3)  # N, Nm; per minute
MIN_TURN_DEG, MIN_SCALE_ERROR, MIN_MASS_ERROR, MIN_CENTER_ERROR = 2.0, 0.05, 0.1, 0.01
MIN_ZERO_ERROR = 2 * MIN_WRENCH_ERROR
SCALE_STD = 0.03  # prior standard deviation of the scale, which only a known mass determines
# m/s²; below it, the force of inertia does not matter, which a controller may not compensate.
MAX_INERTIAL_ACCELERATION = 0.3


class Inputs(Opened):
    """What is read of a recording."""

    gravity: list[float] | None
    quality: Quality
    signals: Signals
    kinematics: Kinematics
    motion: Motion
    premises: Premises
    prediction: Prediction


@step("recording", "audit.csv", recordings="examined")
def audit_sensor(recording: Inputs, arm: Robot) -> list[AuditRow]:
    """Return the audit of the sensor in the arm's wrist; empty without its reading.

    arm: as fitted.
    """
    signals, premises = recording.signals, recording.premises
    has_own_file = "force" in recording.quality.starts
    stopped = premises.contradictions.stop_signs
    if not arm.wrist_sensor or has_own_file or signals.force_sensor is None or stopped:
        return []
    robot, tool = arm.mounted(recording.gravity), premises.load.payload
    states = recording.kinematics, recording.motion
    return audit(robot, signals, *states, tool, recording.prediction.load)


def audit(
    robot: Robot,
    signals: Signals,
    kinematics: Kinematics,
    motion: Motion,
    tool: Payload | None,
    currents: JudgedLoad | None,
) -> list[AuditRow]:
    """Return a row for each estimated value of the sensor, and one for the time without contact.

    tool: on the flange, as declared; currents: the load by the motor currents, None without one.
    """
    free, rows, moved = 0.0, list[AuditRow](), moved_tool(robot, kinematics, motion)
    if signals.ft_raw_wrench is not None:
        reading, sensed = _explained(robot, signals, moved, tool)
        free = reading.seconds
        declared = robot.mounting.force_sensor_turn_deg
        rows += [*_turn_rows(sensed, np.array(declared)), *_sensor_rows(reading, sensed, tool)]
        rows += _shift_rows(reading, signals.time)
    if signals.actual_TCP_force is not None:
        weight = np.array(robot.gravity) @ kinematics.rotation  # R_6ᵀ g
        stated = _left_by_controller(signals, kinematics.rotation, moved, weight)
        if stated is not None and stated.seconds >= MIN_FREE_DURATION:
            free, left = free or stated.seconds, fit_sensor_errors(stated, None)
            # the zero of the controller's force, and the weight that it still contains
            zero = [*_wrench_rows("zero", stated.bias, stated.std()[0], MIN_ZERO_ERROR)]
            held = row("left_mass", "", left.mass, left.mass_std, "kg", 0.0, MIN_MASS_ERROR)
            if any(one.verdict == "unknown" for one in zero):  # a zero error looks like a weight
                held = replace(held, verdict="unknown")
            rows += [*zero, held]
    if currents:
        mass, std = currents.carried, currents.std_error
        wanted = currents.configured
        rows.append(row("mass_by_currents", "", mass, std, "kg", wanted, MIN_MASS_ERROR))
    time = AuditRow("free_time", "", free, None, None, None, "s", None, "")
    return [time, *(rows if free >= MIN_FREE_DURATION else [])]


def _explained(
    robot: Robot, signals: Signals, moved: ToolMotion, tool: Payload | None
) -> tuple[FreeReading, SensorErrors]:
    """Return the fit of the raw reading and the sensor's errors, with the centre of mass of the
    tool found by iteration.
    """
    assert signals.ft_raw_wrench is not None
    raw = in_frame_6(signals.ft_raw_wrench, robot)
    center = np.array(tool.center_of_mass) if tool else np.zeros(3)
    for _ in range(CENTER_ROUNDS):
        pull = moved.pull_at(center)
        reading = fit_free_reading(raw, pull, moved.spin, signals.time, signals.period, tool)
        sensed = fit_sensor_errors(reading, tool.mass if tool else None)
        if tool and abs(sensed.scale.mean() - 1) > MAX_SCALE_ERROR_OF_SENSOR:
            sensed = fit_sensor_errors(reading, None)
        center = within_reach(sensed.center)
    return reading, sensed


def _left_by_controller(
    signals: Signals, rotation: Array, moved: ToolMotion, weight: Array
) -> FreeReading | None:
    """Return the fit of the controller's force, axes of frame 6, at small accelerations of the
    tool: what the controller has not subtracted from the reading; None if these last less than
    MIN_FREE_DURATION.
    """
    assert signals.actual_TCP_force is not None
    slow = np.linalg.norm(moved.pull - weight, axis=1) < MAX_INERTIAL_ACCELERATION
    if slow.sum() * signals.period < MIN_FREE_DURATION:
        return None
    wrench = (signals.actual_TCP_force.reshape(-1, 2, 3) @ rotation).reshape(-1, 6)
    wrench[~slow] = np.nan
    return fit_free_reading(wrench, weight, moved.spin, signals.time, signals.period, None)


def _turn_rows(sensed: SensorErrors, declared: Array) -> Iterator[AuditRow]:
    """Yield the rotation vector from frame 6 to the sensor's axes; declared: (3,) [°]."""
    left = Rotation.from_rotvec(sensed.turn)  # remains after the declared turn
    turn = (left * Rotation.from_rotvec(declared, degrees=True)).as_rotvec(degrees=True)
    std = np.rad2deg(sensed.turn_std)
    yield from _axis_rows("turn", turn, std, "°", declared, MIN_TURN_DEG)


def _sensor_rows(
    reading: FreeReading, sensed: SensorErrors, tool: Payload | None
) -> Iterator[AuditRow]:
    """Yield bias, drift and scale of the sensor, and the tool that it carries."""
    bias_std, drift_std = reading.std()
    yield from _wrench_rows("bias", reading.bias, bias_std)
    yield from _wrench_rows("drift", reading.drift, drift_std, MIN_WRENCH_ERROR, "/min")
    mass, mass_std = sensed.mass, sensed.mass_std
    if tool and sensed.mass == tool.mass:
        yield from _axis_rows(
            "scale", sensed.scale, sensed.scale_std, "1", [1.0] * 3, MIN_SCALE_ERROR
        )
        factor = float(sensed.scale.mean())
        mass, mass_std = factor * mass, float(mass * np.linalg.norm(sensed.scale_std) / 3)
    mass_std = float(np.hypot(mass_std, SCALE_STD * mass))
    limit = max(MIN_MASS_ERROR, 2.5 * SCALE_STD * abs(mass))
    yield row("mass", "", mass, mass_std, "kg", tool.mass if tool else None, limit)
    places = tool.center_of_mass if tool else (None,) * 3
    yield from _axis_rows(
        "center_of_mass", sensed.center, sensed.center_std, "m", places, MIN_CENTER_ERROR
    )


def _shift_rows(reading: FreeReading, time: Array) -> Iterator[AuditRow]:
    """Yield by how much the mean reading shifts from before to after a contact; nothing with fewer
    than two contacts.
    """
    shifts = shifts_after_contacts(reading, time)
    if len(shifts) > 1:
        error = shifts.std(axis=0, ddof=1) / np.sqrt(len(shifts))
        student = stats.t.ppf(0.975, len(shifts) - 1) / NORMAL95
        yield from _wrench_rows("shift", shifts.mean(axis=0), student * error, MIN_WRENCH_ERROR)


def _axis_rows(
    quantity: str,
    values: Array,
    errors: Array,
    unit: str,
    expected: Iterable[float | None],
    limit: float,
) -> Iterator[AuditRow]:
    for axis, value, std, wanted in zip("xyz", values, errors, expected, strict=True):
        yield row(quantity, axis, value, std, unit, wanted, limit)


def _wrench_rows(
    quantity: str,
    values: Array,
    errors: Array,
    limits: Array | None = None,
    per: str = "",
) -> Iterator[AuditRow]:
    wanted = None if limits is None else 0.0
    allowed = [None] * 6 if limits is None else limits
    columns = WRENCH, values, errors, WRENCH_UNITS, allowed
    for name, value, std, unit, limit in zip(*columns, strict=True):
        yield row(quantity, name, value, std, unit + per, wanted, limit)


def row(
    quantity: str,
    component: str,
    value: float,
    std: float,
    unit: str,
    expected: float | None,
    limit: float | None,
) -> AuditRow:
    """Return a value with its 95 % interval and the verdict on it.

    std: of the value; expected: the right value, None if unknown; limit: smallest error that
    matters. wrong: |value - expected| > max(half interval, limit); unknown: not wrong, but half
    interval > limit; right otherwise; "" without expected or limit.
    """
    half, verdict = NORMAL95 * std, ""
    if expected is not None and limit is not None:
        off = abs(value - expected)
        verdict = "wrong" if off > max(half, limit) else "right"
        if verdict == "right" and limit and not half <= limit:
            verdict = "unknown"
    numbers = float(value), float(std), float(value - half), float(value + half)
    return AuditRow(quantity, component, *numbers, unit, expected, verdict)
