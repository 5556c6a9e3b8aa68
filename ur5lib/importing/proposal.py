"""The proposed entry of a file: channels, joints' order, arm, units, and the wrench's frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from ur5lib.checks.block_means import BlockMeans, block_means
from ur5lib.checks.checked import described
from ur5lib.checks.readings import Order
from ur5lib.errors import InputError, some
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import ROW_CLOCK
from ur5lib.importing.contents import FileContents
from ur5lib.importing.efforts import (
    EFFORT_MEANINGS,
    UNITS_BY_CHANNEL,
    as_amperes,
    is_opposite,
    name_efforts,
)
from ur5lib.importing.identity import arms_of, identified, tells_columns
from ur5lib.importing.motion import ImportedMotion, find_motion
from ur5lib.importing.wrenches import CONTACT_FORCE, change, proven_frame, wrench_blocks
from ur5lib.recordings.entries import OPPOSITE_SIGN
from ur5lib.recordings.frames import repair_frames
from ur5lib.timeseries.arrays import Array

ChannelUnits = dict[str, str | list[float]]  # by channel, as a study has them
MIN_BLOCKS = 8
MIN_TURN = 0.1  # rad
MIN_TURNING_JOINTS = 4  # with fewer, constant efforts are no evidence
MAX_GAP = 0.1  # s, that is filled before means are taken
FURTHER_CHANNELS = (
    "joint_control_output",
    "actual_TCP_pose",
    "actual_TCP_force",
    "actual_TCP_speed",
    "joint_temperatures",
)


@dataclass(frozen=True)
class Proposal:
    """A file's channels.

    order: columns of the joints; channels: blocks of each; units: by channel, those that are not
    SI; sensor: blocks of the force sensor; opposite: whether it reads the force of the arm on its
    surroundings; pushed: whether there is a contact.
    """

    moving: ImportedMotion
    arm: str
    order: Order
    channels: dict[str, list[ColumnBlock]]
    units: ChannelUnits
    sensor: list[ColumnBlock] = field(default_factory=list)
    opposite: bool = False
    pushed: bool = False

    @property
    def contents(self) -> FileContents:
        """Return the file's contents."""
        return self.moving.file

    @property
    def clock(self) -> str:
        """Return the name of the robot's time stamps."""
        return self.moving.position.clock


def propose(file: FileContents) -> Proposal:
    """Return the proposal for a file. Raises InputError where it holds no positions."""
    moving = find_motion(file)
    file, clock = moving.file, moving.position.clock
    efforts = {
        f"effort{k}": as_amperes(block, file.evidence) for k, block in enumerate(_efforts(moving))
    }
    wrench = wrench_blocks(file, clock)
    means, loads = _means(moving, efforts, wrench)
    if means:
        _turn(efforts, means, file)
    arm, robot, order = identified(moving, means)
    ordered = means.part(columns=order) if means else None
    named = name_efforts(efforts, ordered, robot, file)
    channels = {name: [block] for name, block in (moving.blocks | named).items()}
    for name in FURTHER_CHANNELS:
        if (block := file.meant(name, clock)) and block.rows.shape[1] in (6, file.joints):
            channels[name] = [block]
    units: ChannelUnits = dict(moving.units)
    units |= {n: unit for n, block in named.items() if (unit := block.unit())}
    units |= {n: unit for n, unit in file.stated.units.items() if n in channels}
    pushed, frame = _pushed(wrench, file), None
    if wrench and robot:
        measured = [block.names for name, block in named.items() if name.startswith("actual")]
        proving = [name for name, block in efforts.items() if block.names in measured][:1]
        alone = ordered and replace(ordered, currents={n: ordered.currents[n] for n in proving})
        frame = proven_frame(wrench, alone if pushed and proving else None, loads, robot, file)
    opposite, sensor = bool(frame and robot and frame.is_opposite(robot)), list[ColumnBlock]()
    if frame and frame.axes == "flange":
        sensor = wrench
    elif frame:
        channels["actual_TCP_force"] = wrench
        units |= {"actual_TCP_force": OPPOSITE_SIGN} if opposite else {}
    _report_columns(file)
    return Proposal(moving, arm, order, channels, units, sensor, opposite, pushed)


def _efforts(moving: ImportedMotion) -> list[ColumnBlock]:
    """Return the efforts: by RTDE's names alone, where one is actual_current.

    Beside recorded channels, a file may hold what was computed from them.
    """
    efforts = moving.beside(EFFORT_MEANINGS)
    names = [block.stem().strip("_").rpartition("/")[2] for block in efforts]
    if "actual_current" not in names:
        return efforts
    return [block for block, name in zip(efforts, names, strict=True) if name in UNITS_BY_CHANNEL]


def _turn(efforts: dict[str, ColumnBlock], means: BlockMeans, file: FileContents) -> None:
    """Turn the efforts of the opposite sign, in the blocks and in their means."""
    stated = file.stated.robot
    arms = [described(name) for name in ([stated] if stated else arms_of(file))]
    arms = [*filter(tells_columns, arms)]
    for name, block in efforts.items():
        if arms and is_opposite(means, name, arms):
            efforts[name] = block.scaled(-1.0)
            means.currents[name] *= -1
            file.evidence.proven.append(
                f"{block.title} has the opposite sign: else friction would drive"
            )


def _means(
    moving: ImportedMotion, efforts: Mapping[str, ColumnBlock], wrench: Sequence[ColumnBlock]
) -> tuple[BlockMeans | None, Array]:
    """Return the means over blocks of time, columns as in the file, and those of the wrench.

    None where the rows are postures, or too few.
    """
    values = {name: block.rows for name, block in efforts.items()} | moving.in_si()
    if wrench:  # a force without moments as if it acted at the flange
        rows = np.hstack([block.rows for block in wrench])
        values["wrench"] = np.pad(rows, ((0, 0), (0, 6 - rows.shape[1])))
    columns = {
        f"{name}_{k}": rows[:, k] for name, rows in values.items() for k in range(rows.shape[1])
    }
    nothing = np.empty((0, 6))
    if moving.still:
        return None, nothing
    fresh = np.diff(moving.time, prepend=-np.inf) > 0
    table = pd.DataFrame({"time": moving.time - moving.time[0], **columns})[fresh]
    # in rad since `find_motion`
    anywhere = dict.fromkeys((f"actual_q_{k}" for k in range(moving.file.joints)), math.inf)
    table = table.reset_index(drop=True)
    try:
        robot, timing, _ = repair_frames(table, None, MAX_GAP, str(moving.file.path), anywhere)
        means = block_means(robot, timing.period, [*efforts, *(["wrench"] if wrench else [])])
    except InputError as error:
        _doubt_numbers(moving, str(error))
        return None, nothing
    if len(means.q) < MIN_BLOCKS:
        lasts, step = np.ptp(moving.time), np.median(np.diff(moving.time[fresh]))
        _doubt_numbers(moving, f"it lasts {lasts:.3g} s in steps of {step:.3g} s")
        return None, nothing
    turned = np.ptp(means.q, axis=0) > MIN_TURN
    loads = means.currents.pop("wrench", nothing)
    # postures of one kind, seen often
    return replace(means, offset=bool(turned.sum() < MIN_TURNING_JOINTS)), loads


def _doubt_numbers(moving: ImportedMotion, why: str) -> None:
    moving.file.evidence.check.append(
        f"nothing but names tells what the columns hold: too short, or with too many gaps ({why})"
    )


def _pushed(wrench: Sequence[ColumnBlock], file: FileContents) -> bool:
    """Return whether a wrench shows a contact."""
    if wrench and (most := change(wrench)) > CONTACT_FORCE:
        file.evidence.proven.append(f"role contact: the force changes by {most:.0f} N")
        return True
    file.evidence.assumed.append("role fit: nothing touches the arm; otherwise write contact")
    return False


def _report_columns(file: FileContents) -> None:
    """Add the columns that are left out, and the assumed layout of a table, to the evidence."""
    evidence = file.evidence
    if file.header.layout:
        evidence.assumed.append(f"columns as of {file.header.layout}")
    if silent := [block.title for block in file.silent]:
        evidence.left_out.append(f"{some(silent)}: zero throughout, so not recorded")


def is_clockless(proposal: Proposal) -> bool:
    """Return whether the file has no time stamps, so that its rows have a rate or are postures."""
    return proposal.clock == ROW_CLOCK
