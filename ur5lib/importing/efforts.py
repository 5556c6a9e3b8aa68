"""The channels of a file's efforts: currents, torques or targets, by name or else by gravity."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ur5lib.channels import (
    CHANNELS,
    CURRENT,
    MEASURED_CURRENT,
    MEASURED_EFFORTS,
    TARGET_CURRENT,
    TORQUE,
)
from ur5lib.checks.arm import torque_constants
from ur5lib.checks.block_means import SMALLEST_SIZE, BlockMeans, combination
from ur5lib.checks.currents import MAX_CONSTANT, MIN_CONSTANT, follows_its_model
from ur5lib.checks.exchanged_channels import MAX_ROUGHNESS_RATIO, roughness
from ur5lib.checks.readings import CLEAR_LEAD, Order, readings, usual_orders
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import JOINTS_OF_UR, ColumnBlock
from ur5lib.importing.contents import FileContents
from ur5lib.importing.effort_sources import (
    CANDIDATES,
    LESS_GRAVITY,
    MIN_BEARING_JOINTS,
    NO_EFFORT,
    UNKNOWN,
    EffortFacts,
    likely_driver,
    rows_of,
    shown_by_gravity,
    surest,
)
from ur5lib.importing.evidence import Row, Verdict, decide
from ur5lib.importing.identity import ArmIdentity, tells_columns
from ur5lib.importing.spellings import is_of_motors, newton_metres
from ur5lib.importing.stated_units import in_stated_values, remedy, stated_for
from ur5lib.recordings.intake import MOTOR_TORQUE
from ur5lib.recordings.less_gravity import TORQUE_LESS_GRAVITY
from ur5lib.records.account import Confidence
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

ROUNDING_STEP = 1e-3  # A; URScript gives currents with three decimals
LARGEST_MULTIPLE_RANGE = (100, 100_000)  # multiples of a rounded current's step that it reaches
MIN_DRIVE = 2.5  # standard errors, from which on friction clearly drives the joints
CLEAR_LEAD_ALONE = 10 * CLEAR_LEAD  # of gravity without friction; a random walk leads by 40
MIN_FOLDED_JOINTS = 3  # efforts of this many would change their sign
FOLDED_SHARE = 0.02  # of the largest effort, to which one that changes its sign falls
NO_EFFORT_REASON = "no name tells what it is, nor do the numbers; --columns names it"
LESS_GRAVITY_REASON = (
    "gravity does not explain it as it explains every current and motor torque; the gravity of the "
    "arm is added again"
)
CHANNELS_BY_UNIT = {  # by unit, and whether it is a target
    ("A", False): MEASURED_CURRENT,
    ("A", True): "target_current",
    ("Nm", False): MOTOR_TORQUE,
    ("Nm", True): "target_moment",
    (LESS_GRAVITY, False): TORQUE_LESS_GRAVITY,
}
UNITS_BY_CHANNEL = {
    channel: unit for (unit, _), channel in CHANNELS_BY_UNIT.items() if unit != LESS_GRAVITY
}
UNITS_BY_CHANNEL |= {"actual_torque": "Nm"}
EFFORT_MEANINGS = ("effort", *UNITS_BY_CHANNEL, TORQUE_LESS_GRAVITY)


def as_amperes(block: ColumnBlock) -> ColumnBlock:
    """Return a block in amperes if it may be rounded currents times a driver's constants: each
    column has whole multiples of a step that is no power of ten and, over ROUNDING_STEP, a possible
    torque constant. Else return the block itself.
    """
    steps = np.array([_step(np.abs(column)) for column in block.rows.T])
    if len(steps) != JOINTS_OF_UR:
        return block
    decimal = np.abs(np.log10(steps) - np.round(np.log10(steps))) < 1e-4
    constants = steps / ROUNDING_STEP
    possible = (constants > MIN_CONSTANT) & (constants < MAX_CONSTANT)
    if np.isnan(steps).any() or decimal.any() or not possible.all():
        return block
    return block.scaled(ROUNDING_STEP / steps)


def _without_constants(
    name: str, block: ColumnBlock, means: BlockMeans, arm: Robot, order: Order, account: Account
) -> tuple[ColumnBlock, BlockMeans]:
    """Return an effort and its means divided by a driver's constants, if gravity confirms these;
    else as they were.

    A converter gives multiples of steps, too: gravity must show the arm's torque constants after
    the division, and others before it. order: of the joints' columns.
    """
    divided = as_amperes(block)
    if divided is block:
        return block, means
    factors = np.array(divided.factors) / np.array(block.factors or [1.0] * len(order))
    current = means.currents[name] * factors[list(order)]
    trial = replace(means, currents=means.currents | {name: current})
    before, after = (shown_by_gravity(one, arm, name) for one in (means, trial))
    if len(after.constants) < MIN_BEARING_JOINTS or after.contradicts("A"):
        return block, means
    if not before.contradicts("A"):
        return block, means
    constants = ", ".join(f"{abs(1 / factor):.4g}" for factor in factors)
    steps = f"a current rounded to {1e3 * ROUNDING_STEP:.0f} mA, times a driver's constants (joint "
    steps += f"by joint {constants} Nm/A): whole multiples of these alone; without them, gravity "
    tells = f"tells {after.in_words()}, with them {before.in_words()}"
    account.hold("proven", block, "numbers", steps + tells)
    return divided, trial


def in_stated_unit(block: ColumnBlock, file: FileContents) -> ColumnBlock:
    """Return an effort in SI units by the values that the user states, or a torque in Nm by the
    unit in its name; else as it is.
    """
    if metres := newton_metres(block.names[0]):
        return block.scaled(metres)
    channel = stated_for(block, file)
    return in_stated_values(block, channel, file) if channel else block


def is_torque_of_joints(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a torque, and neither of motors nor raw."""
    return block.meaning() in (MOTOR_TORQUE, "actual_torque") and not is_of_motors(block.stem())


def is_target(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a target, which is constant where an arm rests."""
    return (block.meaning() or "").startswith("target")


def is_frozen(block: ColumnBlock) -> bool:
    """Return whether an effort never changes."""
    return not np.diff(block.rows, axis=0).any()


def is_rectified(block: ColumnBlock) -> bool:
    """Return whether efforts lost their sign: none is negative, though several fall to zero."""
    low, high = np.nanmin(block.rows, axis=0), np.nanmax(block.rows, axis=0)
    return bool((low >= 0).all()) and int((low < FOLDED_SHARE * high).sum()) >= MIN_FOLDED_JOINTS


def _step(sizes: Array) -> float:
    """Return the number of which sizes (N,) are whole multiples, NaN if there is none."""
    levels = np.unique(sizes[np.isfinite(sizes)])
    gaps = np.diff(levels, prepend=0.0)
    for parts in (1, 2, 3):
        step = gaps[gaps > 1e-6 * levels.max(initial=0.0)].min(initial=np.inf) / parts
        counts = np.round(levels / step)
        if counts.max(initial=0) == 0:
            return np.nan
        step = levels @ counts / (counts @ counts)
        if np.abs(levels - step * counts).max() < 0.01 * step:  # not its half or third as well
            least, most = LARGEST_MULTIPLE_RANGE
            return float(step) if least < counts.max() < most else np.nan
    return np.nan


def lead_of_opposite(means: BlockMeans, name: str, arms: Sequence[Robot]) -> float:
    """Return by how much the log-likelihood of an effort by gravity is larger with the opposite
    sign; 0 if it is not clearly so, or friction does not contradict the sign as read.

    Joints that sense their torque have no friction; turned, these must balance the arm's gravity.
    Where no joint's effort changes its sign, they may be sizes, for which neither sign is right.
    """
    effort, brakes = means.currents[name], []
    if not ((effort < 0).any(axis=0) & (effort > 0).any(axis=0)).any():
        return 0.0
    for column in range(effort.shape[1]):
        friction, speed = means.friction(column), np.abs(means.qd[:, column]).mean()
        terms = np.column_stack([friction, means.qdd, np.ones(len(effort))])
        force, error = combination(terms, effort[:, column], [1.0, float(speed)])
        brakes.append(force / max(error, SMALLEST_SIZE))
    ways = [replace(means, currents={name: sign * effort}) for sign in (1, -1)]
    fits = [torque_constants(ways[1], arm, name) for arm in arms if arm.measured == TORQUE]
    balances = any(fit.ratio and not fit.foreign() for fit in fits)
    if sum(brakes) >= 0 and not balances:
        return 0.0
    orders = usual_orders(effort.shape[1])
    as_read, turned = (readings(way, arms, orders)[0].score for way in ways)
    clear = balances or sum(brakes) < -MIN_DRIVE * np.sqrt(len(brakes))
    least = CLEAR_LEAD if clear else CLEAR_LEAD_ALONE
    return turned - as_read if turned - as_read > least else 0.0


def name_efforts(
    blocks: Mapping[str, ColumnBlock],
    means: BlockMeans | None,
    identity: ArmIdentity,
    file: FileContents,
) -> dict[str, ColumnBlock]:
    """Return the efforts by channel, in SI units, without those that neither name nor unit
    identifies.

    blocks: by the names that they have in `means`; means: with the joints in order, None without a
    motion.
    """
    arm, channels = identity.robot, _like_precedent(blocks, file)
    read = {channel.names for channel in channels.values()}
    blocks = {name: block for name, block in blocks.items() if block.names not in read}
    telling = next((one for one in (arm, identity.like) if one and tells_columns(one)), None)
    for name, block in blocks.items():
        if means and telling:
            known = means, telling, identity.order, file.account
            blocks[name], means = _without_constants(name, block, *known)
    facts = {
        name: _facts(name, block, means, telling or arm, identity, file)
        for name, block in blocks.items()
    }
    units = {
        name: unit
        for name, own, verdict in _verdicts(facts, file.account)
        if (unit := _read_as(own, verdict, file))
    }
    targets = _targets({name: blocks[name] for name in units}, means, telling, file)
    for name, unit in units.items():
        if identity.like:
            file.account.hold("check", blocks[name], "numbers", as_of(identity.like))
        block, target = blocks[name], any(blocks[name] is other for other in targets)
        channel = _channel_of(unit, target, arm)
        if channel == "target_moment" and arm and not arm.is_ur():
            commanded = "a torque that the controller of another arm commanded"
            file.account.exclude(block, commanded, "name")
        elif channel in channels:
            beside = f"it may be {channel}, as {channels[channel].title}; --columns names the one"
            file.account.exclude(block, beside, "name")
        else:
            channels[channel] = _in_si(block, unit)
    return channels


def _facts(
    name: str,
    block: ColumnBlock,
    means: BlockMeans | None,
    arm: Robot | None,
    identity: ArmIdentity,
    file: FileContents,
) -> EffortFacts:
    """Return what sources are asked about; arm: the file's, or the likeliest."""
    shown = shown_by_gravity(means, arm if arm and tells_columns(arm) else None, name)
    known = identity.robot is not None and identity.like is None
    channel = stated_for(block, file)
    stated = {channel: file.stated.units[channel]} if channel else {}
    return EffortFacts(block, arm, known, stated, means, name, shown)


def _in_si(block: ColumnBlock, unit: str) -> ColumnBlock:
    """Return an effort in SI units; of one in an unknown unit, the file's numbers."""
    if unit == UNKNOWN:
        return replace(block, rows=block.rows / block.all_factors(), factors=(), is_known=False)
    return block.scaled(1e-3) if unit == "mA" else block


def _like_precedent(
    blocks: Mapping[str, ColumnBlock], file: FileContents
) -> dict[str, ColumnBlock]:
    """Return, by channel, the efforts that the file's precedent has, too."""
    channels = dict[str, ColumnBlock]()
    for block in blocks.values() if file.precedent else ():
        if file.precedent and block.names in file.precedent.efforts:
            like = f"as in {file.precedent.name}, of the same form and arm: one driver, one unit"
            multiples = "; its numbers are whole milliamperes by these factors, too"
            sure: Confidence = "assumed" if file.precedent.shown else "check"
            like += multiples if file.precedent.shown else "; alone, they do not show it"
            file.account.hold(sure, block, "numbers", like)
            channels[file.precedent.efforts[block.names][0]] = block
    return channels


def as_of(like: Robot) -> str:
    """Return in words that a meaning holds if the arm, which is unknown, is like the
    likeliest one.
    """
    return f"if the arm, which no name and no pose tells, is {like.name} or like it"


def _verdicts(
    facts: Mapping[str, EffortFacts], account: Account
) -> Iterator[tuple[str, EffortFacts, Verdict]]:
    """Yield the verdict on each effort, the surest first; the account gets the rows."""
    rows = {name: rows_of(own) for name, own in facts.items()}
    verdicts = {name: _verdict(rows[name], own) for name, own in facts.items()}
    efforts = [name for name, own in verdicts.items() if own.candidate != NO_EFFORT]
    left = [name for name, own in rows.items() if all(row.source != "motion" for row in own)]
    if not efforts and len(left) == 1:
        rows[left[0]].append(Row("alone", {NO_EFFORT: -7.0}))
        verdicts[left[0]] = _verdict(rows[left[0]], facts[left[0]])
    for name in sorted(facts, key=lambda name: -verdicts[name].lead):
        account.speak(facts[name].block, rows[name], CANDIDATES)
        yield name, facts[name], verdicts[name]


def _verdict(rows: Sequence[Row], facts: EffortFacts) -> Verdict:
    return decide(rows, [*CANDIDATES], surest(rows, facts))


def _read_as(facts: EffortFacts, verdict: Verdict, file: FileContents) -> str:
    """Return the candidate that an effort is read as, "" if it is none; the account states why.

    One of which priors alone speak, or gravity only with a factor a joint, is kept in an unknown
    unit: a fit would find the factors, but no force follows from them.
    """
    absent = any(row.source == "gravity absent" for row in verdict.speaking)
    if absent and verdict.by != "option":
        # it is absent, too, where something carries the arm
        verdict = verdict._replace(confidence="check")
    block, reason, account = facts.block, verdict.reason(CANDIDATES), file.account
    if verdict.candidate == NO_EFFORT:
        spoken = any(row.words() for row in verdict.speaking)
        account.exclude(block, reason if spoken else NO_EFFORT_REASON)
        return ""
    if verdict.candidate == LESS_GRAVITY and is_target(block):
        account.exclude(block, f"a command less gravity: {reason}")
        return ""
    if verdict.candidate == UNKNOWN or not verdict.told:
        reason = reason if verdict.told else f"{CANDIDATES[verdict.candidate]} by habit, {reason}"
        if is_target(block):  # no force needs it
            named = block.meaning() or ""
            remedy = f"--unit {named}={CHANNELS[named].unit}, if that is right"
            account.exclude(block, f"a command in no known unit: {reason}; {remedy}")
            return ""
        account.hold("check", block, verdict.by, _unknown(facts, reason))
        return UNKNOWN
    told = f"in {CANDIDATES[verdict.candidate]}: {reason}"
    if verdict.candidate == LESS_GRAVITY:
        told += f"{likely_driver(facts)}; {LESS_GRAVITY_REASON}"
    account.hold(verdict.confidence, block, verdict.by, told)
    return verdict.candidate


def _unknown(facts: EffortFacts, reason: str) -> str:
    """Return in words that the unit of an effort is unknown, and the option that ends it."""
    named, measured = facts.block.meaning() or "", facts.arm.measured if facts.arm else TORQUE
    channel = named if named in MEASURED_EFFORTS else measured.channel
    factor, shown = facts.shown.factor(), facts.shown.in_words()
    option = remedy(channel) if factor is None else f"--unit {measured.channel}={factor:.3g}"
    reason += f"; gravity tells {shown}" if shown and shown not in reason else ""
    kept = "kept, but no force is stated until it is named"
    return f"in an unknown unit: {reason}; {kept}: {option}"


def _channel_of(unit: str, target: bool, arm: Robot | None) -> str:
    """Return the channel of an effort in a unit; in an unknown one, it is what the arm measures."""
    if unit == UNKNOWN:
        unit = "A" if arm is not None and arm.measured == CURRENT else "Nm"
    channel = CHANNELS_BY_UNIT[unit.replace("mA", "A"), target and unit != LESS_GRAVITY]
    torques = arm is not None and (arm.measured == TORQUE or not arm.is_ur())
    return "actual_torque" if channel == MOTOR_TORQUE and torques else channel


def _targets(
    efforts: Mapping[str, ColumnBlock],
    means: BlockMeans | None,
    arm: Robot | None,
    file: FileContents,
) -> list[ColumnBlock]:
    """Return the efforts that were computed, by their names, or nameless and without noise.

    Of two nameless ones, the one that follows the arm's model more closely is computed, even if the
    other is smoother: whoever wrote the log has then smoothed what was measured.
    """
    named = [one for one in efforts.values() if is_target(one)]
    nameless = {name: effort for name, effort in efforts.items() if effort.is_nameless()}
    sizes = {name: _noise(effort) for name, effort in nameless.items()}
    most = max(sizes.values(), default=0.0)
    smooth = [name for name, size in sizes.items() if size < MAX_ROUGHNESS_RATIO * most]
    either = "a target, or gravity alone, which is as smooth: --columns tells which"
    for name in smooth:
        noise = f"computed: its noise is {sizes[name] / most:.1%} of that of the roughest effort"
        (rough, *_) = [other for other in nameless if other not in smooth]
        if len(nameless) == 2 and means and arm and arm.is_ur():
            pair = {MEASURED_CURRENT: means.currents[rough], TARGET_CURRENT: means.currents[name]}
            if follows_its_model(replace(means, currents=pair), arm):
                closer = "computed: it follows gravity, friction and inertia more closely than "
                noise, name = f"{closer}{nameless[name].title}, which was smoothed", rough
        file.account.hold("check", nameless[name], "numbers", f"{noise}; {either}")
        named.append(nameless[name])
    return named


def _noise(effort: ColumnBlock) -> float:
    """Return the noise of an effort, as a share of its size."""
    spread = np.nanstd(effort.rows, axis=0) + SMALLEST_SIZE
    return float(np.nanmedian(roughness(effort.rows) / spread))
