"""The proposed entry of a file: channels, joints' order, arm, units, and the wrench's frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from ur5lib.channels import CHANNELS, columns, suffixes
from ur5lib.checks.block_means import BlockMeans, block_means
from ur5lib.checks.checked import described
from ur5lib.checks.readings import Order
from ur5lib.errors import InputError
from ur5lib.importing.account import Names
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import ROW_CLOCK
from ur5lib.importing.contents import TABLE_FORMAT, FileContents
from ur5lib.importing.effort_sources import is_share
from ur5lib.importing.efforts import (
    EFFORT_MEANINGS,
    UNITS_BY_CHANNEL,
    as_of,
    in_stated_unit,
    is_frozen,
    is_rectified,
    is_target,
    is_torque_of_joints,
    lead_of_opposite,
    name_efforts,
)
from ur5lib.importing.factors import behind_gears, following_error
from ur5lib.importing.form_of_file import Factors
from ur5lib.importing.identity import arms_of, identified, posed, tells_columns
from ur5lib.importing.motion import ImportedMotion, are_counts, find_motion, rests
from ur5lib.importing.spellings import CLOCK_NAME, is_of_motors, unused
from ur5lib.importing.stated_units import remedy, values_of
from ur5lib.importing.wrenches import (
    CONTACT_FORCE,
    change,
    frame_of,
    with_parted_wrench,
    wrench_blocks,
)
from ur5lib.recordings.entries import OPPOSITE_SIGN
from ur5lib.recordings.frames import repair_frames
from ur5lib.recordings.plausibility import SMALLEST_VALUE
from ur5lib.records.account import Confidence, Evidence
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

ChannelUnits = dict[str, str | list[float]]  # by channel, as a study has them
MIN_BLOCKS = 8
MIN_TURN = 0.1  # rad
MIN_TURNING_JOINTS = 4  # with fewer, constant efforts are no evidence
COUNTED = (
    "positions that are no angles, as pulses, tell nothing of the rest; first name their unit: "
    f"{remedy('actual_q')}"
)
MAX_GAP = 0.1  # s, that is filled before means are taken
MAX_NAMELESS_EFFORTS = 8  # that gravity is asked about, of a table without names
COMPARED_ROWS = 2000  # by which these are chosen
RECTIFIED_REASON = "never negative, though it falls to zero: without its sign, it tells no torque"
GAPS_REASON = "no row has its numbers of all joints"
FROZEN_REASON = "no number of it changes, so it was not measured"
SILENT_REASON = "zero throughout, so not recorded"
STRAY_REASON = f"stray bytes, nearer to zero than {SMALLEST_VALUE:g}: not recorded"
OTHER_CLOCK = "another clock; the rows are timed by the one above"
OTHER_STAMPS = "its stamps are not those of the positions"
FURTHER_CHANNELS = (
    *("joint_control_output", "actual_TCP_pose", "actual_TCP_force", "actual_TCP_speed"),
    "joint_temperatures",
)
CONTROLLER_CHANNELS = (  # of a table, read where its columns have these names
    *("ft_raw_wrench", "wrench_calc_from_currents", "payload", "payload_cog"),
    *("payload_inertia", "target_gravity", "tcp_offset"),
)
CONTROLLER_COLUMNS = {c: name for name in CONTROLLER_CHANNELS for c in columns(name)}


@dataclass(frozen=True)
class Proposal:
    """The channels that are proposed for a file's blocks, with arm and role.

    moving: positions, velocities and targets; order: column of each joint; channels: blocks by
    channel; units: by channel, those that are not SI; sensor: blocks of the force sensor; opposite:
    whether the sensor reads the force of the arm on its surroundings; pushed: whether there is a
    contact.
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
    def force_channels(self) -> dict[str, list[ColumnBlock]]:
        """Return the blocks of the force sensor by channel."""
        return {n: [block] for n, block in zip(("ft_f", "ft_t"), self.sensor, strict=False)}

    @property
    def read_as_named(self) -> list[ColumnBlock]:
        """Return a table's blocks that have the names of CONTROLLER_CHANNELS, also those with zeros
        alone.
        """
        file = self.contents
        blocks = file.blocks + file.silent if file.format == TABLE_FORMAT else []
        return [block for block in blocks if {*block.names} <= {*CONTROLLER_COLUMNS}]

    @property
    def clock(self) -> str:
        """Return the name of the robot's time stamps."""
        return self.moving.position.clock


def propose(file: FileContents) -> Proposal:
    """Return the proposal for a file. Raises InputError where it has no positions."""
    moving = find_motion(with_parted_wrench(file))
    placed = posed(moving)
    file, clock = moving.file, moving.position.clock
    efforts = {f"effort{k}": in_stated_unit(b, file) for k, b in enumerate(_efforts(moving))}
    wrench = wrench_blocks(file, clock)
    means, loads = _means(moving, efforts, wrench)
    _correct(efforts, means, file)
    telling = {n: v for n, v in means.currents.items() if not is_share(efforts[n])} if means else {}
    likely = replace(means, currents=telling) if means else None
    arm, robot, order, like = identity = identified(moving, likely, placed)
    ordered = means.part(columns=order) if means else None
    named = name_efforts(efforts, ordered, identity, file)
    channels = {name: [block] for name, block in (moving.blocks | named).items()}
    for name in FURTHER_CHANNELS:
        block, width = file.meant(name, clock), len(suffixes(name, file.joints))
        if block and block.rows.shape[1] == width:
            channels[name] = [block]
    units: ChannelUnits = dict(moving.units)
    scaled = (moving.blocks | named).items()
    units |= {n: unit for n, block in scaled if (unit := block.unit())}
    words = {n: unit for n, unit in file.stated.units.items() if values_of(unit) is None}
    units |= {n: unit for n, unit in words.items() if n in channels and unit != CHANNELS[n].unit}
    pushed = _led(channels.get("target_qdd", []), file) or _pushed(wrench, file)
    measured = [block.names for name, block in named.items() if name.startswith("actual")]
    proving = [n for n, block in efforts.items() if block.names in measured][:1] if pushed else []
    proof = ordered and replace(ordered, currents={n: ordered.currents[n] for n in proving})
    near = robot or like
    doubt = as_of(like) if like else ""
    known = proof if proving else None
    frame = frame_of(wrench, known, loads, near, file, doubt) if wrench else None
    opposite, sensor = bool(frame and near and frame.is_opposite(near)), list[ColumnBlock]()
    if frame and frame.axes == "flange":
        sensor = wrench
    elif frame:
        channels["actual_TCP_force"] = wrench
        units |= {"actual_TCP_force": OPPOSITE_SIGN} if opposite else {}
    proposal = Proposal(moving, arm, order, channels, units, sensor, opposite, pushed)
    _account_for_the_rest(proposal)
    return proposal


def _efforts(moving: ImportedMotion) -> list[ColumnBlock]:
    """Return the measured efforts; the account states why others are left out: constant, without
    sign, or computed.
    """
    efforts = sorted(moving.beside(EFFORT_MEANINGS), key=lambda block: is_of_motors(block.stem()))
    account = moving.file.account
    of_joints = [block for block in efforts if is_torque_of_joints(block)]
    for block in efforts:
        if is_frozen(block) and not (is_target(block) and rests(moving)):
            account.exclude(block, FROZEN_REASON)
        elif is_rectified(block):
            account.exclude(block, RECTIFIED_REASON)
        elif error := following_error(block, moving):
            account.exclude(block, error)
        elif of_joints and is_of_motors(block.stem()):
            account.exclude(block, f"raw or of the motors, beside {of_joints[0].title}", "name")
    efforts = [block for block in efforts if block.names not in account.excluded]
    if sum(block.is_nameless() for block in efforts) > MAX_NAMELESS_EFFORTS:
        efforts = _following_the_motion(moving, efforts)
    names = [block.stem().strip("_").rpartition("/")[2] for block in efforts]
    if "actual_current" not in names:
        return efforts
    beside = "beside actual_current: computed from it, or of another kind"
    for block, name in zip(efforts, names, strict=True):
        if name not in UNITS_BY_CHANNEL:
            account.exclude(block, beside, "name")
    return [block for block in efforts if block.names not in account.excluded]


def _following_the_motion(
    moving: ImportedMotion, efforts: Sequence[ColumnBlock]
) -> list[ColumnBlock]:
    """Return the MAX_NAMELESS_EFFORTS blocks that angles and velocities of the joints explain best.

    It is one linear regression, with a cost that grows with the number of columns alone.
    """
    q = moving.in_si()["actual_q"]
    rows = np.linspace(0, len(q) - 1, min(len(q), COMPARED_ROWS)).astype(int)
    qd = np.gradient(q, axis=0)[rows]
    terms = [np.sin(q[rows]), np.cos(q[rows]), qd, np.sign(qd), np.ones((len(rows), 1))]
    basis = np.linalg.qr(np.nan_to_num(np.hstack(terms)))[0]
    values = np.nan_to_num(np.stack([block.rows[rows] for block in efforts], axis=1))
    centred = (values - values.mean(axis=0)).reshape(len(rows), -1)
    explained = ((basis.T @ centred) ** 2).sum(axis=0) / ((centred**2).sum(axis=0) + 1e-300)
    shares = np.median(explained.reshape(len(efforts), -1), axis=1)
    least = float(np.sort(shares)[-MAX_NAMELESS_EFFORTS])
    better = f"the joints' motion explains less of it than of others, {least:.0%} and more"
    for block, share in zip(efforts, shares, strict=True):
        if share < least:
            moving.file.account.exclude(block, better)
    return [block for block in efforts if block.names not in moving.file.account.excluded]


def _correct(efforts: dict[str, ColumnBlock], means: BlockMeans | None, file: FileContents) -> None:
    """Correct efforts and means in place: without means, they are left out; else they are scaled
    like the precedent's or, without one, turned if of the opposite sign and multiplied by the gears
    if of the motors' side.
    """
    for name in [name for name in efforts if means and name not in means.currents]:
        file.account.exclude(efforts.pop(name), GAPS_REASON)
    if file.precedent:
        _scale_like(file.precedent.efforts, efforts, means)
    elif means:
        _turn(efforts, means, file)
        _put_behind_gears(efforts, means, file)


def _scale_like(
    scaled: Mapping[Names, tuple[str, Factors]],
    efforts: dict[str, ColumnBlock],
    means: BlockMeans | None,
) -> None:
    """Multiply efforts, in place, by the factors of another file's efforts."""
    for name, block in efforts.items():
        _, factors = scaled.get(block.names, ("", block.all_factors()))
        _scale(name, np.array(factors) / np.array(block.all_factors()), efforts, means)


def _scale(
    name: str, factors: Array | float, efforts: dict[str, ColumnBlock], means: BlockMeans | None
) -> None:
    """Multiply an effort, in place, in its block and in the means."""
    efforts[name] = efforts[name].scaled(factors)
    if means:
        means.currents[name] *= factors


def _possible_arms(file: FileContents) -> list[Robot]:
    """Return the arms with gravity that identifies columns: the stated one, or all with as many
    joints.
    """
    stated = file.stated.robot
    arms = [described(name) for name in ([stated] if stated else arms_of(file))]
    return [*filter(tells_columns, arms)]


def _put_behind_gears(
    efforts: dict[str, ColumnBlock], means: BlockMeans, file: FileContents
) -> None:
    """Multiply torques of the motors' side, in place, by the gear ratios."""
    arms = _possible_arms(file)
    for name, block in efforts.items():
        gears = behind_gears(name, block, means, arms, file.account)
        if gears is not None:
            _scale(name, gears, efforts, means)


def _turn(efforts: dict[str, ColumnBlock], means: BlockMeans, file: FileContents) -> None:
    """Turn, in place, the efforts that gravity explains better with the opposite sign."""
    arms = _possible_arms(file)
    for name, block in efforts.items():
        if arms and (lead := lead_of_opposite(means, name, arms)):
            _scale(name, -1.0, efforts, means)
            so = f"gravity explains it so by {lead:.3g} of log-likelihood before the sign as read"
            turned = f"it has the opposite sign: else friction would drive, and {so}"
            file.account.hold("proven", block, "numbers", turned)


def _means(
    moving: ImportedMotion, efforts: Mapping[str, ColumnBlock], wrench: Sequence[ColumnBlock]
) -> tuple[BlockMeans | None, Array]:
    """Return the means over blocks of time, columns as in the file, and the wrench (M, 6) at these.

    The means are None, and the wrench is empty, if the rows are postures or too few.
    """
    values = {name: block.rows for name, block in efforts.items()} | moving.in_si()
    if wrench:  # a force without moments as if it acted at the flange
        rows = np.hstack([block.rows for block in wrench])
        values["wrench"] = np.pad(rows, ((0, 0), (0, 6 - rows.shape[1])))
    columns = {f"{n}_{k}": part for n, rows in values.items() for k, part in enumerate(rows.T)}
    if moving.still:
        return None, np.empty((0, 6))
    fresh = np.diff(moving.time, prepend=-np.inf) > 0
    table = pd.DataFrame({"time": moving.time - np.nanmin(moving.time), **columns})[fresh]
    if are_counts(moving.file, moving.position):
        moving.file.account.tell("check", "columns", "as named", "name", COUNTED)
        return None, np.empty((0, 6))
    anywhere = dict.fromkeys((f"actual_q_{k}" for k in range(moving.file.joints)), math.inf)
    source, lasts = str(moving.file.path), np.ptp(moving.time)
    try:
        whole = table.reset_index(drop=True)
        robot, timing, _ = repair_frames(whole, None, MAX_GAP, source, anywhere)
        means = block_means(robot, timing.period, [n for n in values if n not in moving.blocks])
        if len(means.q) < MIN_BLOCKS:
            step = np.median(np.diff(moving.time[fresh]))
            raise InputError(f"it lasts {lasts:.3g} s in steps of {step:.3g} s")
    except InputError as error:
        short = f"too short, or with too many gaps for numbers to tell more ({error})"
        moving.file.account.tell("check", "columns", "as named", "name", short)
        return None, np.empty((0, 6))
    loads = means.currents.pop("wrench", np.empty((0, 6)))
    turned = np.ptp(means.q, axis=0) > MIN_TURN  # else postures of one kind, seen often
    return replace(means, offset=bool(turned.sum() < MIN_TURNING_JOINTS)), loads


def _led(target: Sequence[ColumnBlock], file: FileContents) -> bool:
    """Return whether target accelerations show that a hand leads the arm."""
    led = [block.title for block in target if not block.rows.any()]
    for title in led:
        hand = f"{title} is zero while the target moves, as of an arm that a hand leads"
        file.account.tell("check", "role", "contact", "numbers", f"{hand}; otherwise write fit")
    return bool(led)


def _pushed(wrench: Sequence[ColumnBlock], file: FileContents) -> bool:
    """Return whether a wrench changes so much that there is a contact; the account states the
    role.
    """
    most = change(wrench) if wrench else 0.0
    changes = f"the force changes by {most:.3g} N; without contact by {CONTACT_FORCE:.0f} at most"
    if most > CONTACT_FORCE:
        file.account.tell("proven", "role", "contact", "numbers", changes)
        return True
    shown = changes if wrench else "nothing touches the arm; otherwise write contact"
    file.account.tell("assumed", "role", "fit", "numbers" if wrench else "position", shown)
    return False


def _account_for_the_rest(proposal: Proposal) -> None:
    """State in the account, for the blocks without statement, their meaning by name or why they are
    left out.
    """
    file, account = proposal.contents, proposal.contents.account
    if file.header.layout:
        account.tell("assumed", "columns", f"those of {file.header.layout}", "position", "as many")
    as_named = {block.names for block in proposal.read_as_named}
    for block in file.silent:
        if block.names not in as_named:
            account.exclude(block, _why_silent(block.rows))
    taken = {b.names for blocks in (*proposal.channels.values(), proposal.sensor) for b in blocks}
    taken |= as_named
    for name in file.clocks.stamps:
        by: Evidence = "name" if CLOCK_NAME.search(name) else "position"
        if name != ROW_CLOCK:
            told: Confidence = "assumed" if name == proposal.clock else "left out"
            account.state(told, (name,), name, by, "" if name == proposal.clock else OTHER_CLOCK)
    for block in file.blocks + file.silent:
        if block.names in taken and block.names not in account.of_columns:
            account.hold("assumed", block, block.evidence, "")
        elif block.names not in taken and block.names not in account.excluded:
            meaning = block.meaning() or ""
            first = next(iter(proposal.channels.get(meaning, [])), None)
            alike = f"named like {meaning}, as {first.title} before" if first else ""
            why = alike or unused(block.stem(), block.names, file.joints)
            why = OTHER_STAMPS if meaning and block.clock != proposal.clock else why
            account.exclude(block, why, "name")


def _why_silent(rows: Array) -> str:
    if not np.isfinite(rows).any():
        return "no numbers"
    return STRAY_REASON if np.nan_to_num(rows).any() else SILENT_REASON


def is_clockless(proposal: Proposal) -> bool:
    """Return whether the file has no time stamps, so that its rows have a rate or are postures."""
    return proposal.clock == ROW_CLOCK


def meanings(proposal: Proposal) -> dict[tuple[str, ...], str]:
    """Return channel and unit in words of the blocks that an entry has, by the names of their
    columns.
    """
    told = {
        block.names: f"{channel} [{unit}]" if (unit := proposal.units.get(channel)) else channel
        for channel, blocks in (proposal.channels | proposal.force_channels).items()
        for block in blocks
    }
    told |= {b.names: CONTROLLER_COLUMNS[b.names[0]] for b in proposal.read_as_named}
    unit = proposal.contents.clocks.units.get(proposal.clock, "s")
    return told | {(proposal.clock,): f"time [{unit}]"}
