"""The proposed entry of a file: channels, joints' order, arm, units, and the wrench's frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from ur5lib.errors import InputError, some
from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import AGAIN, Contents, Evidence
from ur5lib.importing.efforts import (
    NAMED,
    Frame,
    as_amperes,
    is_opposite,
    name_efforts,
    wrench_frame,
)
from ur5lib.importing.identity import Case, identified
from ur5lib.importing.motion import ImportedMotion, find_motion
from ur5lib.importing.serial import arm_and_torque, arms_of
from ur5lib.recordings.block_means import BlockMeans, block_means
from ur5lib.recordings.entries import OPPOSITE
from ur5lib.recordings.frames import repair_frames
from ur5lib.recordings.readings import IN_ORDER, Order
from ur5lib.recordings.stop_signs import described
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

Units = dict[str, str | list[float]]  # by channel, as a study has them
FEWEST = 8  # blocks of 0.1 s
RESTS, SEVERAL = 0.1, 4  # rad; with fewer moving joints, constant efforts are no evidence
EFFORTS = ("effort", *NAMED)
OTHERS = (
    "joint_control_output",
    "actual_TCP_pose",
    "actual_TCP_force",
    "actual_TCP_speed",
    "joint_temperatures",
)
PUSHED = 10.0  # N; a wrench that changes by more is a contact


@dataclass(frozen=True)
class Proposal:
    """A file's channels.

    clock: name of the robot's time stamps; order: columns of joints 1 to 6; channels: blocks of
    each; units: by channel, those that are not SI; sensor: blocks of the force sensor; opposite:
    whether it reads the force of the arm on its surroundings; pushed: whether there is a contact.
    """

    contents: Contents
    clock: str
    arm: str
    order: Order
    channels: dict[str, list[Block]]
    units: Units
    sensor: list[Block] = field(default_factory=list)
    opposite: bool = False
    pushed: bool = False


def propose(file: Contents, arms: Sequence[str] = (), trusted: bool = False) -> Proposal:
    """Return the proposal for a file.

    arms: possible ones, by default all described; trusted: whether its names of joints are right.
    Raises InputError with the alternatives and a remedy where it is ambiguous.
    """
    evidence, moving, possible = file.evidence, find_motion(file), arms_of(file, arms)
    if file.joints != len(IN_ORDER):
        return _of_serial_arm(moving, possible)
    clock = moving.position.clock
    efforts = {f"effort{k}": as_amperes(b, evidence) for k, b in enumerate(_efforts(moving))}
    wrench = _wrench(file, clock)
    means, loads = _means(moving, efforts, wrench)
    _turn(efforts, means, [described(name) for name in possible], evidence)
    reading = identified(Case(moving, means), arms, trusted)
    arm, ordered = described(reading.arm), means.part(columns=reading.order)
    named = name_efforts(efforts, ordered, arm, evidence)
    channels = {name: [block] for name, block in (moving.blocks | named).items()}
    for name in OTHERS:
        block = _of_meaning(file, name, clock)
        wide = block is not None and block.rows.shape[1] == 6
        if block is not None and wide and block.names not in evidence.left_out:
            channels[name] = [block]
    pushed = _pushed(wrench, evidence)
    sensor: list[Block] = []
    opposite = False
    units = moving.units | {n: unit for n, block in named.items() if (unit := block.unit())}
    measured = [block.names for name, block in named.items() if name.startswith("actual")]
    usable = [name for name, block in efforts.items() if block.names in measured]
    if wrench:
        proving = usable[0] if pushed and usable else None
        frame = _frame(wrench, proving, ordered, loads, arm, evidence)
        sensor = wrench if frame and frame.axes == "flange" else []
        channels |= {"actual_TCP_force": wrench} if frame and frame.axes == "base" else {}
        opposite = frame is not None and _opposite(frame, wrench, arm, evidence)
    _report_columns(file)
    if opposite and not sensor:
        units["actual_TCP_force"] = OPPOSITE
    parts = file, clock, reading.arm, reading.order, channels, units
    return Proposal(*parts, sensor, opposite, pushed)


def _efforts(moving: ImportedMotion) -> list[Block]:
    """Return the efforts of a UR arm: by RTDE's names alone, where one is actual_current.

    Beside recorded channels, a file may hold what was computed from them.
    """
    found = moving.beside(EFFORTS)
    names = [block.stem().strip("_").rpartition("/")[2] for block in found]
    if "actual_current" not in names:
        return found
    return [block for block, name in zip(found, names, strict=True) if name in NAMED]


def _of_serial_arm(moving: ImportedMotion, arms: Sequence[str]) -> Proposal:
    """Return the proposal for a file of more joints than a UR arm has, in the file's order."""
    file, (arm, torque) = moving.file, arm_and_torque(moving, arms)
    channels = {name: [block] for name, block in moving.blocks.items()}
    units = Units(moving.units)
    if torque is not None:
        channels["actual_torque"] = [torque]
        units |= {"actual_torque": unit} if (unit := torque.unit()) else {}
    file.evidence.assumed.append(f"the joints' order, as in {moving.position.title}: base to wrist")
    _pushed([], file.evidence)
    _report_columns(file)
    order = tuple(range(file.joints))
    return Proposal(file, moving.position.clock, arm, order, channels, units)


def _turn(
    efforts: dict[str, Block], means: BlockMeans, arms: Sequence[Robot], evidence: Evidence
) -> None:
    """Turn the efforts of the opposite sign, in the blocks and in their means."""
    for name, block in efforts.items():
        if is_opposite(means, name, arms):
            efforts[name] = block.scaled(np.full(6, -1.0))
            means.currents[name] *= -1
            evidence.proven.append(
                f"{block.title} has the opposite sign: else friction would drive"
            )


def _of_meaning(file: Contents, meaning: str, clock: str) -> Block | None:
    """Return the block with a meaning and the time stamps of a clock."""
    for block in file.blocks:
        same = np.array_equal(file.clocks[block.clock], file.clocks[clock])
        if block.meaning() == meaning and same:
            return block
    return None


def _wrench(file: Contents, clock: str) -> list[Block]:
    """Return the blocks of force and torque, that of a force alone, or none."""
    whole = _of_meaning(file, "wrench", clock)
    if whole is not None and len(whole.names) == 6:
        parts = [(whole.names[k : k + 3], whole.rows[:, k : k + 3]) for k in (0, 3)]
        return [Block(names, rows, whole.clock) for names, rows in parts]
    both = [_of_meaning(file, meaning, clock) for meaning in ("force", "torque")]
    return [block for block in both if block is not None] if both[0] is not None else []


def _means(
    moving: ImportedMotion, efforts: Mapping[str, Block], wrench: Sequence[Block]
) -> tuple[BlockMeans, Array]:
    """Return the means over blocks of time, columns as in the file, and those of the wrench."""
    values = {name: block.rows for name, block in efforts.items()} | moving.in_si()
    if wrench:  # a force without moments as if it acted at the flange
        rows = np.hstack([block.rows for block in wrench])
        values["wrench"] = np.pad(rows, ((0, 0), (0, 6 - rows.shape[1])))
    columns = {f"{name}_{k}": rows[:, k] for name, rows in values.items() for k in range(6)}
    stamps, path = moving.time, moving.file.path
    table = pd.DataFrame({"time": stamps - stamps[0], **columns})
    positions = [f"actual_q_{k}" for k in range(6)]  # in rad since `find_motion`
    robot, timing, _ = repair_frames(table, None, 0.1, str(path), positions)
    means = block_means(robot, timing.period, [*efforts, *(["wrench"] if wrench else [])])
    if len(means.q) < FEWEST:
        unit = moving.file.units.get(moving.position.clock, "s")
        step = np.median(np.diff(stamps))
        raise InputError(
            f"{path}: too short or with too many gaps to analyse: {len(means.q)} stretches of "
            f"0.1 s are complete, in {np.ptp(stamps):.3g} s with a median step of "
            f"{step:.3g} s, by stamps in {unit}; record "
            "two seconds or more, at 10 Hz or faster, with all digits of the stamps"
        )
    turned = np.ptp(means.q, axis=0) > RESTS
    loads = means.currents.pop("wrench", np.empty((0, 6)))
    # postures of one kind, seen often
    return replace(means, offset=bool(turned.sum() < SEVERAL)), loads


def _frame(
    wrench: Sequence[Block],
    effort: str | None,
    means: BlockMeans,
    values: Array,
    arm: Robot,
    evidence: Evidence,
) -> Frame | None:
    """Return the frame of a wrench with values (M, 6), None where no effort proves it."""
    title = " and ".join(block.title for block in wrench)
    frame, lead = wrench_frame(means, effort, values, arm) if effort else (None, 0.0)
    if frame is None:
        evidence.ambiguous.append(
            f"{title}: in the base's frame or the flange's, by the arm or on it (the best two "
            f"log-likelihoods are {lead:.1f} apart, changes up to {_change(wrench):.0f} N); left "
            "out: record a push in several postures"
        )
        return None
    evidence.proven.append(f"{title} in the {frame.axes}'s frame: only so it explains the efforts")
    if len(wrench) == 1 and frame.axes == "base":
        evidence.ambiguous.append(
            f"{title}: left out, because a force in the base's frame is read only together with "
            "its moments: record these, too, or the force in the flange's axes"
        )
        return None
    return frame


def _opposite(frame: Frame, wrench: Sequence[Block], arm: Robot, evidence: Evidence) -> bool:
    """Return whether the sign of a wrench is opposite to that of its channel.

    Where a hand leads a compliant arm, efforts have the sign of the force on the arm. With a wrist
    sensor, the sign is therefore proven only by motors that work against the force.
    """
    title = " and ".join(block.title for block in wrench)
    if frame.axes == "base" and arm.wrist_sensor and frame.by_arm:
        evidence.assumed.append(f"{title} has the sign of actual_TCP_force, as where a hand leads")
        return False
    actor = "of the arm on its surroundings" if frame.by_arm else "of the surroundings on the arm"
    evidence.proven.append(f"{title} is the force {actor}, by the efforts")
    return frame.by_arm == (frame.axes == "flange" or arm.wrist_sensor)


def _change(wrench: Sequence[Block]) -> float:
    force = wrench[0].rows
    return float(np.nanmax(np.linalg.norm(force - np.nanmedian(force, axis=0), axis=1)))


def _pushed(wrench: Sequence[Block], evidence: Evidence) -> bool:
    """Return whether a wrench shows a contact."""
    if wrench and (change := _change(wrench)) > PUSHED:
        evidence.proven.append(f"role contact: the force changes by {change:.0f} N")
        return True
    evidence.assumed.append("role fit: nothing touches the arm; otherwise write contact")
    return False


def _report_columns(file: Contents) -> None:
    """Add the columns that are left out, and the assumed layout of a table, to the evidence."""
    evidence = file.evidence
    if file.header.layout:
        evidence.assumed.append(f"columns as of {file.header.layout}")
    if repeated := [name.split(AGAIN)[0] for name in file.header.repeated]:
        verb = "appears" if len(repeated) == 1 else "appear"
        evidence.proven.append(f"{some(repeated)} {verb} twice in the header; read once, the first")
    if silent := [block.title for block in file.silent]:
        evidence.proven.append(f"{some(silent)}: zero throughout, so not recorded")
