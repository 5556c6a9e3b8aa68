"""The arm of a file and the order of its joints: as stated, by names, by a pose, by gravity."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ur5lib.checks.arm import torque_constants
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.checked import described, described_arms
from ur5lib.checks.readings import (
    CLEAR_LEAD,
    SLOPE_BOUNDS_OR_NONE,
    Order,
    Reading,
    readings,
    usual_orders,
)
from ur5lib.errors import InputError
from ur5lib.importing.blocks import JOINTS_OF_UR, ColumnBlock
from ur5lib.importing.contents import FileContents
from ur5lib.importing.motion import ImportedMotion
from ur5lib.importing.poses import (
    POSE,
    ROTATION_VECTOR,
    Pose,
    PosedReadings,
    fitting,
    form_of_rotation,
    poses,
)
from ur5lib.importing.spellings import lettered_joints, place_of
from ur5lib.recordings.arm_joints import JOINT_NAMES
from ur5lib.recordings.echo_start import MESSAGE_FORMATS
from ur5lib.records.account import Confidence, Evidence
from ur5lib.records.codes import Found
from ur5lib.robots.description import UNNAMED_ARM, Robot

MIN_TRAVEL = 0.05  # rad, of a joint of an arm that its flange tells
MOST_POSES = 8  # columns that are compared with the flange
CLEAR_LEAD_OVER_NAMES = 3 * CLEAR_LEAD  # lead from which on numbers outdo the numbers of columns
ORDER = "the joints' order"
UNDESCRIBED_ARM = UNNAMED_ARM
TIE = 0.5  # nats, by which no arm is likelier than another
NAME_IT = "name the right arm, as with --robot ur5e, or describe it (`ur5 describe`)"
JOINT_WORDS = ("shoulder pan", "shoulder lift", "elbow", "wrist 1", "wrist 2", "wrist 3")
USUAL_ORDER = "no name tells it; the other order, by names, is that of drivers of URs"
MAX_SHOWN_RATIO = 100.0  # beyond this many times the maker's constant, gravity shows none
MAKERS_TOLERANCE = 0.1  # share by which a joint's constant may differ from the maker's


class ArmIdentity(NamedTuple):
    """A file's arm and the column of each of its joints. robot: None if the arm has no description;
    like: of an arm that nothing but efforts identifies, the likeliest one, if they have its
    constants: their unit is a guess with it.
    """

    arm: str
    robot: Robot | None
    order: Order
    like: Robot | None = None


def identified(
    moving: ImportedMotion, means: BlockMeans | None, placed: PosedReadings
) -> ArmIdentity:
    """Return the arm and the column of each joint: as stated, by names, by a pose, by gravity.

    means: over blocks with all efforts, None without a motion; placed: readings by the pose.
    """
    file, fitting_arms = moving.file, arms_of(moving.file)
    stated = _stated_arm(moving)
    names = [stated] if stated else fitting_arms
    orders = usual_orders(file.joints)
    if not names:
        remedy = "describe yours, `ur5 describe arm.urdf`, and name it with --robot"
        gripper = "or, where one column is a gripper's, name the arm as well"
        none = f"no described arm has {file.joints} joints; {remedy}; {gripper}"
        file.account.tell("check", "robot", UNDESCRIBED_ARM, "numbers", none)
        return ArmIdentity(UNDESCRIBED_ARM, None, orders[0])
    arms = [described(name) for name in fitting_arms]
    likely = readings(means, arms, orders, SLOPE_BOUNDS_OR_NONE) if means else []
    of_names = [reading for reading in likely if reading.arm in names]
    order = _stated_order(file) or _order(moving, of_names, placed)
    if file.precedent and file.precedent.arm != UNDESCRIBED_ARM and not stated:
        stated, of_form = file.precedent.arm, f"as in {file.precedent.name}, of the same form"
        file.account.tell("check", "robot", stated, "numbers", of_form)
        return ArmIdentity(stated, described(stated), order)
    if stated:
        by: Evidence = "option" if file.stated.robot else "name"
        how = "as given" if file.stated.robot else "by the name of file, folder or columns"
        if placed.arms() == [stated] and placed.beaten:
            shown = f"{how}; the pose, within {1000 * placed.good[0].miss:.1f} mm"
            file.account.tell("proven", "robot", stated, "numbers", shown + placed.next_best())
        else:
            file.account.tell("assumed", "robot", stated, by, how)
        return ArmIdentity(stated, described(stated), order)
    return _arm(file, means, [one for one in likely if one.order == order], placed, order)


def _stated_arm(moving: ImportedMotion) -> str:
    """Return the arm that the user states, or a name of the file, "" for none."""
    file = moving.file
    return file.stated.robot or _arm_in_names(moving, arms_of(file)) or ""


def arms_of(file: FileContents) -> list[str]:
    """Return the names of described arms with as many joints as a file, and with gravity that may
    identify columns.
    """
    arms = described_arms()
    return [n for n, arm in arms.items() if len(arm.joints) == file.joints and tells_columns(arm)]


def tells_columns(arm: Robot) -> bool:
    """Return whether an arm's gravity is described and the file's columns are of its joints, not of
    a controller's counts.
    """
    return arm.tells_gravity() and not arm.is_counted()


def _by_arm(file: FileContents) -> Confidence:
    """Return how sure an order by gravity is: without a stated arm, it is that of a guess."""
    return "assumed" if file.stated.robot else "check"


def _names_others(file: FileContents) -> bool:
    """Return whether messages name joints that are not those of an arm, in whatever order."""
    return any(finding.code == Found.UNNAMED_JOINTS for finding in file.findings)


def posed(moving: ImportedMotion) -> PosedReadings:
    """Return the readings that put the flange at a recorded pose; empty without a pose or motion.

    The account states what is a pose, which no effort can be then, and the arm that it proves.
    """
    file, q, found = moving.file, moving.in_si()["actual_q"], PosedReadings([])
    arms = [described(name) for name in arms_of(file)]
    taken = {id(block) for block in moving.blocks.values()}
    others = [b for b in file.blocks if id(b) not in taken]
    whole = np.isfinite(q).all(axis=1)
    if not arms or not whole.any() or np.ptp(q[whole], axis=0).max() < MIN_TRAVEL:
        return found
    for pose in poses(others, moving.position.clock)[:MOST_POSES]:
        unit, position = pose.in_metres()
        placed = fitting(q, position, arms, usual_orders(file.joints))
        if placed.good and not found.good:
            found = _held(moving, pose, unit, placed)
        elif pose.blocks[0].is_nameless() and placed.is_near(position):
            file.account.exclude(pose.blocks[0], f"a pose in {unit}: {placed.within(pose.title)}")
        elif pose.blocks[0].meaning() == POSE and not placed.good:
            why = "no pose of the flange, or of a tool on it, in m, base frame"
            file.account.exclude(pose.blocks[0], why)
    return found


def _held(moving: ImportedMotion, pose: Pose, unit: str, placed: PosedReadings) -> PosedReadings:
    """Return readings by a pose; the account gets its row of evidence, and what follows for it, for
    the positions and for the arm.
    """
    account, stated = moving.file.account, _stated_arm(moving)
    best, within, next_best = placed.good[0], placed.within(pose.title), placed.next_best()
    q = moving.in_si()["actual_q"][:, best.order]
    turn = form_of_rotation(pose, q, described(best.arm)) if pose.rotation.shape[1] else ""
    row, words = placed.row(unit, f"; {turn}" if turn else "")
    is_rtde = len(pose.blocks) == 1 and pose.blocks[0].meaning() == POSE
    right = turn.startswith(ROTATION_VECTOR) or not turn
    if is_rtde and unit == "m" and pose.rotation.shape[1] == 3 and right:
        account.hold("assumed", pose.blocks[0], pose.blocks[0].evidence, f"in {unit}: {within}")
    else:
        form = f", with {turn}" if turn else ""
        for block in pose.blocks:
            why = f"a pose in {unit}, {within}{form}; no step reads this form"
            account.exclude(block, why)
    account.speak(pose.blocks[0], [row], words)
    if placed.beaten:
        own = moving.units.get("actual_q", "rad")
        account.prove(moving.position, f"positions in {own}: {within}{next_best}")
    if stated and stated not in placed.arms():
        reason = f"the recorded pose is the flange of {best.arm}, or a tool on it: {within}"
        account.tell("check", "robot", stated, "numbers", reason + next_best)
    elif len(placed.orders()) == 1 and placed.beaten:
        proof = f"{within}{next_best}, {in_words(best.order)}"
        return placed._replace(proof=proof)
    return placed


def _order(moving: ImportedMotion, likely: Sequence[Reading], placed: PosedReadings) -> Order:
    """Return the columns of the joints: by names, or else by pose and gravity. The account states
    why, and where numbers contradict names.
    """
    file, title, posed = moving.file, moving.position.title, placed.orders()
    as_read = tuple(range(moving.file.joints))
    scores = {reading.order: reading.score for reading in reversed(likely)}
    best = max(scores, key=lambda order: scores[order], default=as_read)
    lead = scores[best] - scores[as_read] if scores else 0.0
    ahead = min((scores[as_read] - s for o, s in scores.items() if o != as_read), default=0.0)
    named, by_gravity = names_order(moving), lead > CLEAR_LEAD_OVER_NAMES
    so = f"gravity explains the efforts so, by {lead:.3g} of log-likelihood before base to wrist"
    as_named, tell = f"as named in {title}", file.account.tell
    if named and posed and as_read not in posed:
        tell("check", ORDER, as_named, "name", f"the pose fits another: {in_words(posed[0])}")
    elif placed.proof:
        tell("proven", ORDER, in_words(posed[0]), "numbers", placed.proof)
        return posed[0]
    elif named and by_gravity and not posed:
        tell("check", ORDER, as_named, "name", f"or {in_words(best)}: {so}")
    elif named == "number" and scores and ahead <= CLEAR_LEAD:
        unproven = f"gravity shows no order: {ahead:.3g} of log-likelihood before the others"
        tell("check", ORDER, as_named, "name", unproven)
    elif named:
        least = f"no number clearly contradicts: {ahead:.3g} of log-likelihood before other orders"
        tell("assumed", ORDER, as_named, "name", least if scores else "nothing contradicts it")
    elif file.precedent and file.precedent.order:
        like = f"as in {file.precedent.name}, of the same form: one driver, one order"
        tell("check", ORDER, in_words(file.precedent.order), "numbers", like)
        return file.precedent.order
    elif len(posed) == 1:
        return posed[0]
    elif by_gravity:
        tell(_by_arm(file), ORDER, in_words(best), "numbers", f"no name tells it, and {so}")
        return best
    elif ahead > CLEAR_LEAD:
        before = f"no name tells it; gravity, by {ahead:.3g} of log-likelihood before the other"
        tell("assumed", ORDER, "base to wrist", "numbers", f"{before} orders (elbow, wrist first)")
    elif not _may_be_by_name(file) and not _names_others(file):
        tell("assumed", ORDER, "base to wrist", "position", USUAL_ORDER)
    else:
        unproven = "what moves shows no other to be likelier, and no name tells it"
        tell("check", ORDER, "base to wrist", "position", unproven)
    return as_read


def _stated_order(file: FileContents) -> Order:
    """Return the column of each joint as the user states it, () where not. Raises InputError for
    another number of joints.
    """
    numbers = file.stated.joint_numbers
    if numbers and len(numbers) != file.joints:
        raise InputError(
            f"{file.path}: --joints has {len(numbers)} numbers, but positions {file.joints} "
            "columns; give the joint of each"
        )
    order = tuple(numbers.index(joint) for joint in range(1, len(numbers) + 1))
    if order:
        file.account.tell("assumed", ORDER, in_words(order), "option", "as given")
    return order


def names_order(moving: ImportedMotion) -> Literal["name", "number", ""]:
    """Return what determines the joints' order: names of a driver's joints, or by the user, or
    numbers; or RTDE's numbers of a UR, which any recorder may write; "" for neither.
    """
    file, block = moving.file, moving.position
    first_name = block.names[0]
    if file.header.entry or first_name in file.stated.names():
        return "name"
    if file.format in MESSAGE_FORMATS:
        codes = Found.UNNAMED_JOINTS, Found.NAMELESS_JOINTS
        unnamed = [f for f in file.findings if f.code in codes]
        topics = (topic for finding in unnamed for topic in finding.channels)
        return "" if any(first_name.startswith(f"{topic}/") for topic in topics) else "name"
    if len(block.names) > 1 and any(joint.search(first_name) for joint in JOINT_NAMES):
        return "name"
    if lettered_joints(block.names) or (_counts(block) and not _may_be_by_name(file)):
        return "name"
    rtde = re.search(r"(actual|act)_?q", first_name, re.IGNORECASE)
    return "number" if len(block.names) > 1 and rtde else ""


def _counts(block: ColumnBlock) -> bool:
    """Return whether the file's names of a block number the joints from 0 or 1, whatever is
    before.
    """
    places = [place_of(name)[1] for name in block.names]
    first = min(places[0], 1)
    return (
        len(places) > 1
        and not (block.is_nameless() or block.of_array)
        and places == [*range(first, first + len(places))]
    )


def _may_be_by_name(file: FileContents) -> bool:
    """Return whether columns may be in the order of a UR's names, elbow first, though numbered."""
    arm = described(file.stated.robot) if file.stated.robot in described_arms() else None
    return file.joints == JOINTS_OF_UR and (arm is None or arm.has_ur_motors())


def _arm(
    file: FileContents,
    means: BlockMeans | None,
    likely: Sequence[Reading],
    placed: PosedReadings,
    order: Order,
) -> ArmIdentity:
    """Return the likeliest arm of a file that names none.

    It is certain by the pose alone. By gravity, if the constants are the maker's and it is likelier
    by far than the next, it is a guess: a factor of the efforts makes them those of another arm.
    """
    possible = [*dict.fromkeys(reading.arm for reading in placed.good)]
    rivals = [reading for reading in (placed.beaten,) if reading and reading.arm not in possible]
    tell, likely = file.account.tell, [r for r in likely if r.arm in possible or not possible]
    if len(possible) == 1:
        alone = f"no other described arm has {file.joints} joints; {NAME_IT}"
        next_best = f"{rivals[0].arm} is within {1000 * rivals[0].miss:.3g} mm" if rivals else alone
        reason = f"the pose, within {1000 * placed.good[0].miss:.1f} mm; {next_best}"
        tell("proven" if rivals else "check", "robot", possible[0], "numbers", reason)
        return ArmIdentity(possible[0], described(possible[0]), order)
    if means is None or not means.currents or not likely:
        tell("check", "robot", UNDESCRIBED_ARM, "numbers", f"nothing tells the arm; {NAME_IT}")
        return ArmIdentity(UNDESCRIBED_ARM, None, order)
    best, *others = likely
    constants, are_known = _constants(means, best)
    grounds = f"{best.arm} is the likeliest by the efforts{f', with {constants}' * bool(constants)}"
    lead = best.score - others[0].score if others else np.inf
    rival = [f"the next, {r.arm}, has a log-likelihood less by {lead:.3g}" for r in others[:1]]
    grounds += f"; {''.join(rival) or 'no other of as many joints is described'}"
    like = described(best.arm) if are_known else None
    if like and lead >= CLEAR_LEAD:
        guess = f"if its efforts have the unit that they have then: {grounds}; {NAME_IT}"
        tell("check", "robot", best.arm, "numbers", guess)
        return ArmIdentity(best.arm, like, order, like)
    if lead < TIE:
        grounds = f"{best.arm} and {others[0].arm} are as likely by the efforts"
    tell("check", "robot", UNDESCRIBED_ARM, "numbers", f"no arm is clear: {grounds}; {NAME_IT}")
    return ArmIdentity(UNDESCRIBED_ARM, None, order, like)


def _constants(means: BlockMeans, reading: Reading) -> tuple[str, bool]:
    """Return in words the torque constants that gravity shows of a reading, and whether all are
    near the maker's.
    """
    arm, ordered = described(reading.arm), means.part(columns=reading.order)
    units = zip(means.currents, reading.units, strict=True)
    effort, unit = next((pair for pair in units if pair[1] != "neither"), ("", ""))
    if not effort:
        return "", False
    per_ampere = np.array(arm.maker_torque_constants()) ** (unit == "Nm")
    per_ampere *= 1e3 if unit == "mA" else 1.0
    efforts = {effort: ordered.currents[effort] / per_ampere}
    fit = torque_constants(replace(ordered, currents=efforts), arm, effort)
    texts = [
        f"{ratio * fit.known[joint]:.3g} Nm/A on joint {joint + 1} (known: {fit.known[joint]:.3g})"
        if ratio < MAX_SHOWN_RATIO
        else f"nothing of gravity on joint {joint + 1}"
        for joint, ratio in fit.ratio.items()
    ]
    agree = [abs(ratio - 1) < 2 * MAKERS_TOLERANCE for ratio in fit.ratio.values()]
    return " and ".join(texts), bool(agree) and all(agree)


def _arm_in_names(moving: ImportedMotion, arms: Sequence[str]) -> str | None:
    """Return the only arm in the name of the file, of its folder, or of the positions, if any."""
    path, columns = moving.file.path, " ".join(moving.position.names)
    for name in (path.name, path.absolute().parent.name, columns):
        parts = {*re.split(r"[^a-z0-9]+", name.lower())}
        named = [arm for arm in arms if arm in parts]
        if len(named) == 1:
            return named[0]
    return None


def in_words(order: Order) -> str:
    """Return the names of the joints in the order of the file's columns."""
    numbered = [f"joint {k + 1}" for k in range(len(order))]
    words = JOINT_WORDS if len(order) == len(JOINT_WORDS) else numbered
    return ", ".join(words[order.index(column)] for column in range(len(order)))
