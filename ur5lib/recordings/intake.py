"""Intake of a recording: read and repair it, find channels that it lacks from others."""

import math
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.channels import (
    CHANNELS,
    EFFORT_CHANNELS,
    MEASURED_CURRENT,
    MOST_JOINTS,
    SENSED_TORQUE,
    TORQUE,
    UNKNOWN_UNIT,
    columns,
    is_unused,
    joint_count,
    meant,
)
from ur5lib.errors import InputError, some
from ur5lib.recordings.added import is_added
from ur5lib.recordings.copies import efforts_in, fingerprint
from ur5lib.recordings.counting import at_the_joints, counted_as
from ur5lib.recordings.entries import Files
from ur5lib.recordings.formats import read_recording
from ur5lib.recordings.frames import no_positions, repair_frames
from ur5lib.recordings.frozen import frozen_end
from ur5lib.recordings.held_samples import fresh_samples
from ur5lib.recordings.less_gravity import with_gravity
from ur5lib.recordings.plausibility import drop_unwritten
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.recordings.sensors import FORCE_CHANNELS, FORCES, on_robot_clock, repair_samples
from ur5lib.recordings.starts import place_sensors
from ur5lib.recordings.wraps import without_wraps
from ur5lib.recordings.zeroings import on_one_zero
from ur5lib.records.codes import Found
from ur5lib.records.phrases import as_written
from ur5lib.records.quality import Device, Finding, Log, Quality, StartOffset, add_finding
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import link_frames
from ur5lib.tables import channel, checksum, has_unit, named
from ur5lib.timeseries.arrays import Array

RAW_WRENCH, TCP_FORCE = "ft_raw_wrench", "actual_TCP_force"
MOTOR_TORQUE = "actual_current_as_torque"
NAMES_OF_TORQUES = (SENSED_TORQUE, MOTOR_TORQUE, MEASURED_CURRENT)  # of arms that measure them
TIMES_POSSIBLE = 2.0  # times what a joint can reach; beyond it, a value is no joint's

# Every column is a block of its own, so that it can be freed; pandas expects few blocks.
warnings.filterwarnings(
    "ignore", category=pd.errors.PerformanceWarning, module=r"ur5lib\.recordings\."
)


@dataclass(frozen=True)
class Intake:
    """The data of a recording, and the findings of reading and repairing it.

    robot: on a uniform time grid; sensors: each on its own clock.
    """

    robot: pd.DataFrame
    sensors: dict[Device, pd.DataFrame]
    quality: Quality


FORCES_ALONE = "it has forces alone: moments are not measured, and only forces are compared with it"


def read_and_repair(recording: Files, arm: Robot, max_gap: float) -> Intake:
    """Return the repaired data of a recording with findings; max_gap: [s].

    Raises InputError when it cannot be used.
    """
    raw = read_recording(recording)
    whole, wrapped = without_wraps(raw.robot.table)
    raw = replace(raw, robot=replace(raw.robot, table=whole))
    declared: Payload | None = getattr(recording, "known_payload", lambda: None)()
    frames, findings = known_frames(raw, counted_as(recording, arm), declared)
    raw, frames = with_slow_sensor(raw, frames, findings)
    findings += [*_no_velocities(frames), *raw.findings, *wrapped]
    contents, efforts = fingerprint(frames), efforts_in(raw.robot.table)
    remarks: list[Finding] = []
    placed = place_sensors(raw, remarks)
    del whole
    rows, files = len(raw.robot.table), {d: checksum(r.source) for d, r in raw.sensors.items()}
    cycle, source, start = raw.cycle, raw.robot.source, raw.robot.start
    del raw  # its channels are freed while they are repaired
    bounds = bounds_of(arm, unknown := recording.unknown_unit())
    robot, timing, repairs = repair_frames(frames, cycle, max_gap, source, bounds)
    robot = robot.assign(**{UNKNOWN_UNIT: True}) if unknown else robot
    findings += repairs + remarks
    robot = with_wrist_sensor(robot, arm, "force" in placed, findings)
    robot = _on_one_zero(robot, placed, arm, findings)
    sensed = placed["force"][0].table if "force" in placed else robot
    if "ft_fx" in sensed and "ft_tx" not in sensed:
        add_finding(findings, "force", Found.NO_MOMENTS, "note", len(sensed), FORCES_ALONE)
    quality = Quality(
        rows=rows,
        frames=len(robot),
        duration_s=float(robot["time"].iloc[-1] - robot["time"].iloc[0]),
        period_s=timing.period,
        longest_step_s=timing.longest_step,
        jitter_s={"median": timing.jitter_median, "99 %": timing.jitter_99},
        start_epoch_s=start.seconds if start and start.since == "epoch_s" else None,
        devices=["robot", *placed],
        starts={device: offset for device, (_, offset) in placed.items()},
        files=files,
        findings=findings,
        fingerprint=contents,
        efforts=efforts,
        account=recording.account,
    )
    return Intake(robot, {device: record.table for device, (record, _) in placed.items()}, quality)


def _no_velocities(frames: pd.DataFrame) -> Iterator[Finding]:
    """Yield a note if there are no velocities, so that slopes of the positions replace them."""
    if "actual_q_0" in frames and "actual_qd_0" not in frames:
        detail = "no actual_qd: velocities are the slopes of actual_q, with the noise of these"
        yield Finding("robot", Found.NO_VELOCITIES, "note", len(frames), detail)


def known_frames(
    raw: RawRecording, arm: Robot, payload: Payload | None = None
) -> tuple[pd.DataFrame, list[Finding]]:
    """Return the robot's rows with the recognised channels, efforts and positions converted to the
    arm's joints; and findings. payload: as the study declares it.

    Raises InputError if they lack positions of the arm's joints.
    """
    unwritten: list[Finding] = []
    written = replace(raw.robot, table=drop_unwritten(raw.robot.table, unwritten))
    _expect_joints(written, arm)
    frames, findings = _known_channels(written.table, "force" in raw.sensors)
    findings += unwritten
    frames = _with_torques_named(frames, arm, findings)
    return with_efforts(at_the_joints(frames, arm), arm, findings, payload), findings


def _on_one_zero(
    robot: pd.DataFrame,
    placed: dict[Device, tuple[DeviceRecord, StartOffset]],
    arm: Robot,
    findings: list[Finding],
) -> pd.DataFrame:
    """Return the robot's table; a force sensor that was zeroed during the recording is put on its
    last zero, in that table or in `placed`.
    """
    if "force" not in placed:
        robot, zeroed = on_one_zero(robot, robot, arm)
    else:
        record, start = placed["force"]
        table, zeroed = on_one_zero(record.table, robot, arm, start)
        placed["force"] = replace(record, table=table), start
    findings += zeroed
    return robot


def _expect_joints(robot: DeviceRecord, arm: Robot) -> None:
    """Raise InputError unless a recording has the positions of exactly the arm's joints."""
    positions = [name for name in robot.table if name.startswith("actual_q_")]
    count, joints = joint_count(positions), len(arm.joints)
    if any(f"actual_q_{joint}" not in robot.table for joint in range(joints)):
        raise no_positions(robot.table, joints, robot.source)
    if count > joints:
        raise InputError(
            f"{robot.source}: has actual_q_0 to actual_q_{count - 1}, but {arm.name} has {joints} "
            "joints; name its arm in the study"
        )


def bounds_of(arm: Robot, unknown: bool = False) -> dict[str, float]:
    """Return, by column, the magnitude from which on a value is impossible for an arm.

    All have a UR's bounds, or twice the arm's own limits if these are larger; measured currents of
    motors without a documented torque constant have a UR's. Measured torques of other arms have
    none, nor have efforts in an unknown unit, and target currents of such motors.
    """
    farthest = [TIMES_POSSIBLE * max(map(abs, ends)) for ends in arm.position_limits()]
    fastest = [TIMES_POSSIBLE * speed for speed in arm.velocity_limits()]
    limits = {f"{kind}_q": farthest for kind in ("actual", "target")}
    limits |= {f"{kind}_qd": fastest for kind in ("actual", "target")}
    limits["target_qdd"] = [TIMES_POSSIBLE * rate for rate in arm.acceleration_limits()]
    limits["target_moment"] = [TIMES_POSSIBLE * torque for torque in arm.torque_limits()]
    amperes = np.divide(limits["target_moment"], arm.maker_torque_constants())
    limits["target_current"] = np.nan_to_num(amperes, nan=math.inf).tolist()
    limits["actual_current"] = np.nan_to_num(amperes, nan=0.0).tolist()
    if arm.measured == TORQUE or unknown:
        limits[arm.measured.channel] = [math.inf] * len(arm.joints)
    return {
        f"{name}_{joint}": max(bound, CHANNELS[name].bound)
        for name, bounds in limits.items()
        for joint, bound in enumerate(bounds)
    }


def _known_channels(table: pd.DataFrame, other: bool) -> tuple[pd.DataFrame, list[Finding]]:
    """Return the table with only the channels that have a meaning and a unit, and notes on the
    others.

    other: whether the study names another force sensor, which is used instead of the table's.
    """
    wrench = [name for name in table if re.match(r"ft_(?!raw)", name)]
    whole = FORCE_CHANNELS if {*FORCE_CHANNELS} <= {*wrench} else FORCES
    sensor = not other and {*whole} <= {*wrench}
    unread = [name for name in wrench if not sensor or name not in whole]
    others = [name for name in table if not has_unit(name) and name not in unread]
    added = [name for name in others if is_added(name)]
    unused = list(filter(is_unused, others))
    nearest = {name: meant(name) for name in others if name not in (*unused, *added)}
    misspelt = {name: near for name, near in nearest.items() if near is not None}
    known = (*unused, *misspelt, *added)
    unknown = [name for name in others if name not in known]
    notes: list[Finding] = []
    detail = (
        "ft_f… in the robot's file are taken as the force sensor; assumed: force of the "
        "surroundings on the arm, in the axes of frame 6"
    )
    add_finding(notes, "force", Found.ASSUMED_FRAME, "note", sensor, detail)
    detail = (
        f"{some(unread)}: a wrench in the robot's file that is not used; name its columns ft_fx to "
        "ft_tz (or to ft_fz, without moments), or declare `force_sensor`"
    )
    add_finding(notes, "robot", Found.UNUSED_WRENCH, "warning", len(unread), detail)
    near = ", ".join(sorted({*misspelt.values()}))
    detail = f"{some([*misspelt])}: left out; rename them if {near} is meant"
    add_finding(notes, "robot", Found.MISSPELT_CHANNELS, "warning", len(misspelt), detail)
    detail = f"{some(unused)}: RTDE channels that are not used; left out"
    add_finding(notes, "robot", Found.UNUSED_CHANNELS, "note", len(unused), detail)
    detail = f"{some(unknown)}: not channels of RTDE; ignored"
    add_finding(notes, "robot", Found.UNKNOWN_CHANNELS, "note", len(unknown), detail)
    return table.drop(columns=[*others, *unread]), notes


def with_slow_sensor(
    raw: RawRecording, frames: pd.DataFrame, findings: list[Finding]
) -> tuple[RawRecording, pd.DataFrame]:
    """Return a recording and its robot's frames; the force sensor is moved to a device of its own
    if it is slower than the rows of the robot's file, or stays the same from some row on.
    """
    columns = [name for name in FORCE_CHANNELS if name in frames]
    samples = frames[["time", *columns]].dropna() if columns else frames[:0]
    values, time = samples[columns].to_numpy(float), samples["time"].to_numpy(float)
    if fresh_samples(values) is None and frozen_end(values, time) is None:
        return raw, frames
    log = Log(Path(raw.robot.source), "force", findings)
    record = log.unless_unusable(lambda: repair_samples(samples, log))
    sensors = dict(raw.sensors)
    if record is not None:
        sensors["force"] = on_robot_clock(replace(raw.robot, table=record.table))
    return replace(raw, sensors=sensors), frames.drop(columns=columns)


def with_wrist_sensor(
    robot: pd.DataFrame, arm: Robot, other: bool, findings: list[Finding]
) -> pd.DataFrame:
    """Return a repaired robot table with `ft_fx` .. `ft_tz` [N, Nm] read by the arm's own force
    sensor, if it has one.

    It is the wrench of the environment on the arm, in axes of frame 6, at the flange. other:
    whether the study names a force sensor, which is used instead.
    """
    named_reading = _reading(robot, arm) if arm.wrist_sensor else None
    if named_reading is None:
        return robot
    name, reading = named_reading
    detail = f"{name} of the arm is the force sensor of this recording, on the robot's clock"
    if other:
        detail = f"{name} is not compared: the study names another force sensor"
    used = () if other else (name,)
    add_finding(findings, "force", Found.WRIST_SENSOR, "note", 1, detail, used)
    return robot if other else robot.assign(**dict(zip(FORCE_CHANNELS, reading.T, strict=True)))


def _reading(robot: pd.DataFrame, arm: Robot) -> tuple[str, Array] | None:
    """Return the name of the wrist sensor's channel and its reading (N, 6) in axes of frame 6; None
    without one.

    The raw reading, else the controller's `actual_TCP_force` (base axes, without the configured
    payload, zeroed by the program): on a real UR5e both have the same moments, at the flange.
    """
    if _varies(robot, RAW_WRENCH):
        return RAW_WRENCH, channel(robot, RAW_WRENCH)
    if not _varies(robot, TCP_FORCE):
        return None
    rotation = link_frames(arm, channel(robot, "actual_q"))[0][:, -1]
    halves = channel(robot, TCP_FORCE).reshape(-1, 2, 3)
    return TCP_FORCE, (halves @ rotation).reshape(-1, 6)


def _varies(robot: pd.DataFrame, name: str) -> bool:
    """Return whether a channel was recorded and changes; without a sensor, it would be constant."""
    if f"{name}_0" not in robot:
        return False
    values = channel(robot, name)
    return bool((np.nanmax(values, axis=0) > np.nanmin(values, axis=0)).any())


def _with_torques_named(table: pd.DataFrame, arm: Robot, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with its torques named actual_torque, if the arm measures torques; other
    efforts are dropped.

    Tables of arms that measure currents are unchanged.
    """
    if arm.measured != TORQUE:
        return table
    found = [name for name in (*EFFORT_CHANNELS, MOTOR_TORQUE) if f"{name}_0" in table]
    given = next((name for name in NAMES_OF_TORQUES if name in found), SENSED_TORQUE)
    detail = f"{given} is read as actual_torque [Nm], which the arm measures"
    is_other = given != SENSED_TORQUE
    add_finding(findings, "robot", Found.TORQUES_BY_ANOTHER_NAME, "note", is_other, detail)
    others = [own for name in found if name != given for own in columns(name, MOST_JOINTS)]
    renamed = dict(
        zip(columns(given, MOST_JOINTS), columns(SENSED_TORQUE, MOST_JOINTS), strict=True)
    )
    return table.drop(columns=[own for own in others if own in table]).rename(columns=renamed)


def with_efforts(
    table: pd.DataFrame, arm: Robot, findings: list[Finding], payload: Payload | None = None
) -> pd.DataFrame:
    """Return a table with the efforts that its arm measures: torques [Nm], or currents [A].

    To torques less gravity, that of arm and payload is added. Torques of an arm with measured
    currents are divided by the torque constants of its joints. A fit of friction finds the
    constants anew, so that their errors cancel where currents become torques again.
    """
    whole = SENSED_TORQUE if arm.measured == TORQUE else MOTOR_TORQUE
    table = with_gravity(table, whole, arm, payload, findings)
    return table if arm.measured == TORQUE else _with_currents(table, arm, findings)


def _with_currents(table: pd.DataFrame, arm: Robot, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with currents [A], computed from torques [Nm] if it has only these; measured
    torques are dropped.
    """
    sensed = [name for name in columns(SENSED_TORQUE, MOST_JOINTS) if name in table]
    name = next((name for name in (MOTOR_TORQUE, SENSED_TORQUE) if f"{name}_0" in table), None)
    if name is None or f"{MEASURED_CURRENT}_0" in table:
        return table.drop(columns=sensed)
    constants = np.array(arm.maker_torque_constants())
    if np.isnan(constants).any():
        detail = (
            "actual_current_as_torque without actual_current: the torque constants of "
            f"{arm.name} are unknown"
        )
        add_finding(findings, "robot", Found.NO_CURRENTS, "warning", len(table), detail)
        return table.drop(columns=sensed)
    if name == MOTOR_TORQUE:
        detail = (
            "actual_current is actual_current_as_torque divided by "
            f"{as_written(constants, '.3g')} Nm/A, the torque constants of {arm.name}"
        )
        add_finding(findings, "robot", Found.CURRENTS_FROM_TORQUES, "note", len(table), detail)
    currents = named(channel(table, name) / constants, MEASURED_CURRENT)
    return table.assign(**currents).drop(columns=sensed)
