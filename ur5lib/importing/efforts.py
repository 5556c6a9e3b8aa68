"""The channels of a file's efforts: currents, torques or targets, by name or else by gravity."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.channels import CHANNELS, MEASURED_CURRENT, TARGET_CURRENT, TORQUE
from ur5lib.checks.arm import MAX_CONSTANT_RATIO, torque_constants
from ur5lib.checks.block_means import SMALLEST_SIZE, BlockMeans, combination
from ur5lib.checks.currents import MAX_CONSTANT, MIN_CONSTANT, follows_its_model
from ur5lib.checks.exchanged_channels import MAX_ROUGHNESS_RATIO, roughness
from ur5lib.checks.readings import (
    CLEAR_LEAD,
    OWN_FACTORS,
    Order,
    readings,
    unit_scores,
    usual_orders,
)
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import JOINTS_OF_UR, ColumnBlock
from ur5lib.importing.contents import FileContents
from ur5lib.importing.identity import MAX_SHOWN_RATIO, ArmIdentity, tells_columns
from ur5lib.importing.spellings import is_of_motors, named_unit, names_share, newton_metres
from ur5lib.recordings.delimited import number_in
from ur5lib.recordings.intake import MOTOR_TORQUE, TORQUE_LESS_GRAVITY
from ur5lib.records.account import Confidence
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

LESS_GRAVITY = "neither"  # current nor torque: a torque less gravity, as some drivers write
ROUNDING_STEP = 1e-3  # A; URScript gives currents with three decimals
LARGEST_MULTIPLE_RANGE = (100, 100_000)  # multiples of a rounded current's step that it reaches
MAX_TORQUE_RATIO = 1.5  # of a torque in Nm to gravity's
# Up to this one, nothing else is as near; 1 % of the torque for which some motors are rated is 1.5.
MAX_PROVEN_RATIO = 1.25
# The factors of joints that show the same unit differ by no more.
MAX_FACTOR_RATIO = 1.15
MIN_BEARING_JOINTS = 2  # this many show a unit together
MIN_DRIVE = 2.5  # standard errors, from which on friction clearly drives the joints
CLEAR_LEAD_ALONE = 10 * CLEAR_LEAD  # of gravity without friction; a random walk leads by 40
MIN_FOLDED_JOINTS = 3  # efforts of this many would change their sign
FOLDED_SHARE = 0.02  # of the largest effort, to which one that changes its sign falls
UNKNOWN_UNIT = "nothing tells its unit; record more postures, or --columns and --unit name it"
LESS_GRAVITY_REASON = (
    "in Nm, less gravity, which does not explain it as it explains every current and motor torque; "
    "the gravity of the arm is added again"
)
SHARE_REASON = (
    "a share of a rating, or counts, by its name: in Nm by a factor a joint, which the file lacks; "
    "multiply it, or give the factors as `units`"
)
OWN_FACTORS_REASON = (
    "as of a percentage of rated torques, of counts, or of motors before their gears: multiply it, "
    "or give the factors as `units`"
)
OR_SHARE_REASON = "a share of rated torques may be as near: the maker's manual has the unit"
UNIT_WORDS = {"A": "A", "mA": "mA", "Nm": "Nm", LESS_GRAVITY: "Nm less gravity"}
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
EFFORT_MEANINGS = ("effort", *UNITS_BY_CHANNEL)


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
    before, after = (_shown_by_gravity(one, arm, name) for one in (means, trial))
    if len(after.constants) < MIN_BEARING_JOINTS or after.contradicts("A"):
        return block, means
    if not before.contradicts("A"):
        return block, means
    constants = ", ".join(f"{abs(1 / factor):.4g}" for factor in factors)
    steps = f"a current rounded to {1e3 * ROUNDING_STEP:.0f} mA, times a driver's constants (joint "
    steps += f"by joint {constants} Nm/A): whole multiples of these alone; without them, gravity "
    tells = f"tells {after.constants_in_words()}, with them {before.constants_in_words()}"
    account.hold("proven", block, "numbers", steps + tells)
    return divided, trial


def in_stated_unit(block: ColumnBlock, file: FileContents) -> ColumnBlock:
    """Return an effort in SI units: a current in amperes by the user's factor, a torque in Nm by
    the unit in its name; else as it is.
    """
    if metres := newton_metres(block.names[0]):
        return block.scaled(metres)
    of_current = (block.meaning() or "effort") in ("effort", MEASURED_CURRENT)
    factor = number_in(file.stated.units.get(MEASURED_CURRENT, "").encode())
    if not of_current or factor is None or np.isnan(factor):
        return block
    file.account.hold("assumed", block, "option", f"one unit of the file is {factor:g} A")
    return replace(block.scaled(factor), stated=MEASURED_CURRENT)


def is_torque_of_joints(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a torque, and neither of motors nor raw."""
    return block.meaning() in (MOTOR_TORQUE, "actual_torque") and not is_of_motors(block.stem())


def is_target(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a target, which is constant where an arm rests."""
    return (block.meaning() or "").startswith("target")


def is_share(block: ColumnBlock) -> bool:
    """Return whether an effort is named as a share of a rating, or as counts."""
    return not block.stated and names_share(block.names[0])


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
    shown = {name: _shown_by_gravity(means, telling, name) for name in blocks}
    units = {name: _unit(block, shown[name], file) for name, block in blocks.items()}
    known_units = {name: unit for name, unit in units.items() if unit}
    targets = _targets({name: blocks[name] for name in known_units}, means, telling, file)
    for name, unit in known_units.items():
        if identity.like:
            file.account.hold("check", blocks[name], "numbers", as_of(identity.like))
        block, target = blocks[name], any(blocks[name] is other for other in targets)
        channel = CHANNELS_BY_UNIT[unit.replace("mA", "A"), target and unit != LESS_GRAVITY]
        if channel == MOTOR_TORQUE and arm and (arm.measured == TORQUE or not arm.is_ur()):
            channel = "actual_torque"
        if channel == "target_moment" and arm and not arm.is_ur():
            commanded = "a torque that the controller of another arm commanded"
            file.account.exclude(block, commanded, "name")
        elif channel in channels:
            beside = f"it may be {channel}, as {channels[channel].title}; --columns names the one"
            file.account.exclude(block, beside, "name")
        else:
            channels[channel] = block.scaled(1e-3) if unit == "mA" else block
    return channels


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


class GravityShown(NamedTuple):
    """What gravity shows of an effort.

    scores: log-likelihood of each unit; constants: Nm per unit of the file, by joint from 0; known:
    the maker's constants [Nm/A], empty for joints that sense their torque; own: log-likelihood with
    one factor per joint.
    """

    scores: Mapping[str, float]
    constants: Mapping[int, float]
    known: Sequence[float]
    own: float = -np.inf

    def is_of_own_factors(self) -> bool:
        """Return whether joints contradict the likeliest unit, and one factor per joint explains
        them far better.
        """
        best = self.likeliest()[0]
        foreign = best == LESS_GRAVITY or (bool(best) and self.contradicts(best))
        ahead = self.own - max(self.scores.values(), default=self.own)
        return len(self.constants) >= MIN_BEARING_JOINTS and foreign and ahead > CLEAR_LEAD

    def ratios(self, unit: str) -> list[float]:
        """Return the joints' constants as multiples of those that they would have in a unit."""
        of_unit = {"A": 1.0, "mA": 1e-3}
        return [
            constant / (of_unit[unit] * self.known[joint] if unit in of_unit else 1.0)
            for joint, constant in self.constants.items()
        ]

    def contradicts(self, unit: str) -> bool:
        """Return whether the constant of any joint is far from that of a unit."""
        most = MAX_TORQUE_RATIO if unit == "Nm" else MAX_CONSTANT_RATIO
        return any(not 1 / most < ratio < most for ratio in self.ratios(unit))

    def is_far_from_newton_metres(self) -> bool:
        """Return whether the median of the joints' constants is far from 1 Nm per unit of the
        file.
        """
        median = float(np.median(self.ratios("Nm") or [1.0]))
        return not 1 / MAX_PROVEN_RATIO < median < MAX_PROVEN_RATIO

    def confirms(self, unit: str) -> bool:
        """Return whether several joints show the maker's constants that a unit would have."""
        enough = len(self.constants) >= MIN_BEARING_JOINTS and bool(self.known or unit == "Nm")
        return enough and not self.contradicts(unit)

    def is_of_a_factor(self, unit: str) -> bool:
        """Return whether joints contradict a unit, but all show one other factor."""
        if not self.known:
            return False
        ratios = self.ratios("A")
        alike = len(ratios) >= MIN_BEARING_JOINTS and max(ratios) < MAX_FACTOR_RATIO * min(ratios)
        return alike and self.contradicts(unit)

    def factor(self) -> float:
        """Return the amperes of one unit of the file, by the joints' median."""
        return float(np.median(self.ratios("A")))

    def likeliest(self) -> tuple[str, float]:
        """Return the likeliest unit, "" without any, and by how much its log-likelihood exceeds the
        next one's.
        """
        best, rival, *_ = [*sorted(self.scores, key=lambda unit: -self.scores[unit]), "", ""]
        return best, self.scores[best] - self.scores[rival] if self.scores else 0.0

    def in_words(self) -> str:
        """Return a sentence with the likeliest unit, its lead over the next one, and the
        constants.
        """
        best, rival, *_ = sorted(self.scores, key=lambda unit: -self.scores[unit])
        before = f"log-likelihood before {UNIT_WORDS[rival]}"
        tells = f"gravity tells {UNIT_WORDS[best]}, by {self.likeliest()[1]:.3g} of {before}"
        words = self._replace(known=()) if best == "Nm" else self
        return f"{tells}: {words.constants_in_words()}" if self.constants else tells

    def constants_in_words(self) -> str:
        """Return the joints' constants in words, with the maker's if known."""
        joints = ", ".join(str(joint + 1) for joint in self.constants)
        constants = ", ".join(f"{constant:.3g}" for constant in self.constants.values())
        known = ", ".join(f"{self.known[joint]:.3g}" for joint in self.constants if self.known)
        plural = "s" if len(self.constants) > 1 else ""
        of_joints = f"{constants} Nm per unit on joint{plural} {joints}"
        return f"{of_joints} (known: {known} Nm/A)" if self.known else of_joints


def _shown_by_gravity(means: BlockMeans | None, arm: Robot | None, name: str) -> GravityShown:
    """Return what gravity shows of an effort by its name in `means`; empty without means or arm."""
    if means is None or arm is None:
        return GravityShown({}, {}, ())
    fit = torque_constants(means, arm, name)
    shown = {joint: ratio for joint, ratio in fit.ratio.items() if ratio < MAX_SHOWN_RATIO}
    constants = {joint: ratio * fit.known[joint] for joint, ratio in shown.items()}
    scores = unit_scores(means, name, arm)
    own = scores.pop(OWN_FACTORS)
    if arm.measured == TORQUE:  # which has no amperes
        scores = {unit: scores[unit] for unit in ("Nm", LESS_GRAVITY)}
        return GravityShown(scores, constants, (), own)
    return GravityShown(scores, constants, fit.known, own)


def as_of(like: Robot) -> str:
    """Return in words that a meaning holds if the arm, which is unknown, is like the
    likeliest one.
    """
    return f"if the arm, which nothing tells, is like {like.name}"


def _named_unit(block: ColumnBlock) -> str | None:
    """Return the unit that an effort's name or meaning states, None for none."""
    spelled = named_unit(block.names[0])
    return spelled if spelled in UNIT_WORDS else UNITS_BY_CHANNEL.get(block.meaning() or "")


def _unit(block: ColumnBlock, shown: GravityShown, file: FileContents) -> str | None:
    """Return the unit of an effort, A, mA, Nm or LESS_GRAVITY, as stated, named, or shown by
    gravity; None if it is unknown. The account states why.
    """
    account, named = file.account, _named_unit(block)
    given = file.stated.units.get(block.meaning() or "")
    if given in UNIT_WORDS:
        account.hold("assumed", block, "option", f"in {UNIT_WORDS[given]}")
        return given
    if is_share(block):
        told = f"; gravity tells {shown.constants_in_words()}" if shown.constants else ""
        account.exclude(block, f"{SHARE_REASON}{told}", "name")
        return None
    peak, bound = np.nanmedian(np.abs(block.rows).max(axis=1)), CHANNELS[MEASURED_CURRENT].bound
    if named == "A" and peak > bound and not shown.is_of_a_factor("mA"):
        sure: Confidence = "check" if shown.contradicts("mA") else "assumed"
        sure = "proven" if shown.constants and sure != "check" else sure
        told = f"; {shown.in_words()}" if shown.constants else ""
        too_many = f"in mA: {peak:.3g} A are more than {bound:g} A{told}"
        account.hold(sure, block, "numbers", too_many)
        return "mA"
    best, lead = shown.likeliest()
    without_name = not named and block.meaning() != "effort"
    if lead > CLEAR_LEAD and not (best == LESS_GRAVITY and without_name):
        return _unit_by_gravity(block, shown, account)
    if named is None:
        account.exclude(block, UNKNOWN_UNIT)
    else:
        of_own = shown.is_of_own_factors() and named_unit(block.names[0]) != named
        factors = f", but a factor a joint explains it better: {shown.constants_in_words()}"
        doubt = f"{factors}; {OWN_FACTORS_REASON}" if of_own else ""
        account.hold("check" if doubt else "assumed", block, "name", f"in {named}{doubt}")
    return named


def _unit_by_gravity(block: ColumnBlock, shown: GravityShown, account: Account) -> str | None:
    """Return the unit of an effort for which gravity clearly shows one; the name may contradict it;
    None if it is unknown. The account states why.
    """
    named, spelled = _named_unit(block), named_unit(block.names[0]) in UNIT_WORDS
    best, sentence = shown.likeliest()[0], shown.in_words()
    if named and named != best and shown.confirms(named):
        account.hold("assumed", block, "name", f"in {named}: {shown.constants_in_words()}")
        return named
    if best == LESS_GRAVITY and not spelled and block.meaning() in ("effort", MOTOR_TORQUE):
        account.hold("check", block, "numbers", LESS_GRAVITY_REASON)
        return LESS_GRAVITY
    if shown.is_of_own_factors() and not spelled and not shown.is_of_a_factor(best):
        ahead = shown.own - shown.scores[best]
        factors = f"one factor a joint explains it better than {UNIT_WORDS[best]}, by {ahead:.3g} "
        factors += f"of log-likelihood: {shown.constants_in_words()}; {OWN_FACTORS_REASON}"
        if named is None:
            account.exclude(block, f"in no unit: {factors}")
        else:
            account.hold("check", block, "name", f"in {named} by its name, but {factors}")
        return named
    strange = best != LESS_GRAVITY and shown.contradicts(best)
    if named in (None, best) and not strange:
        if best == "Nm" and not spelled and shown.is_far_from_newton_metres():
            account.hold("check", block, "numbers", f"in {best}: {sentence}; {OR_SHARE_REASON}")
            return best
        sure = best == LESS_GRAVITY or len(shown.constants) >= MIN_BEARING_JOINTS
        account.hold("proven" if sure else "assumed", block, "numbers", f"in {best}: {sentence}")
        return best
    if best != LESS_GRAVITY and not spelled and shown.is_of_a_factor(best):
        stated = f"--unit {MEASURED_CURRENT}={shown.factor():.3g}"
        share = "a share of rated torques, with a factor a joint, or one factor would explain it"
        unknown = f"in no unit that is known: {sentence}; {share}, as {stated}"
        account.exclude(block, unknown)
        return None
    unit = best if named is None or (best == "mA" and named == "A" and not spelled) else named
    account.hold("check", block, "name" if unit == named else "numbers", f"in {unit}; {sentence}")
    return unit


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
