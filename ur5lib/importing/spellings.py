"""The spellings of quantities, joints, axes, clocks and units in the names that recorders write."""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from ur5lib.channels import RECORDED_CHANNELS, SUFFIXES, is_unused
from ur5lib.recordings.arm_joints import of_named_joint
from ur5lib.records.account import UNKNOWN_NAME


def _words_in(text: str) -> set[str]:
    return {*text.split()}


# Quantities with a column for each joint, by a word of their name. The first counts.
JOINT_QUANTITY_WORDS = {
    "qdd": _words_in("qdd ddq qddot qpp acceleration accelerations accel acc beschleunigung"),
    "qd": _words_in("qd dq qdot qp velocity velocities vel speed speeds spd geschwindigkeit"),
    "q": _words_in("q position positions pos posn angle angles ang theta winkel achswinkel"),
    "current": _words_in("i current currents curr cur amp amps ampere strom motorstrom"),
    "torque": _words_in("m torque torques torq trq tq tau moment moments drehmoment motormoment"),
    "effort": _words_in("effort efforts eff input inputs"),
}
TOOL_QUANTITY_WORDS = {
    "actual_TCP_force": _words_in("force wrench"),
    "actual_TCP_speed": _words_in("speed velocity"),
    "actual_TCP_pose": _words_in("pose vector position positions pos rot coord"),
}
SPATIAL_QUANTITY_WORDS = {  # of three columns
    "force": _words_in("force forces f"),
    "torque": _words_in("torque torques moment t m n"),
    "position": _words_in("position positions translation"),
}
WHOLE_NAMES = {  # in full: of a polling script, of LeRobot's lists, of a force sensor's columns
    **{"tqd": "target_qd", "tqdd": "target_qdd", "tcp": "actual_TCP_pose"},
    **{"tcps": "actual_TCP_speed", "tcpf": "actual_TCP_force"},
    **{"observation.state": "actual_q", "observation.position": "actual_q"},
    **{"observation.velocity": "actual_qd", "observation.effort": "effort"},
    **{"action": "target_q", "ft": "wrench", "ft_f": "force", "ft_t": "torque"},
}
# Meanings of measured efforts, the first three of which may be torques.
EFFORTS = "effort", "actual_current_as_torque", "actual_torque", "actual_current"
TORQUES = EFFORTS[:3]
TARGET_OR_TORQUE = "tq"  # the target of q in polling scripts, elsewhere a torque
COMMAND_WORDS = _words_in(  # the last two of a policy
    "target tgt desired des ref reference cmd command commanded setpoint goal soll computed "
    "action actions"
)
DERIVED_WORDS = _words_in(  # of what was computed from a measured state
    "estimate estimates estimated estimator observer observed filtered filter smoothed kalman ekf "
    "predicted prediction simulated simulation sim"
)
# Words in which a path ends behind its quantity.
CONTAINER_WORDS = _words_in("data value values signals")
TOOL_WORDS = _words_in("tcp tool cartesian transform tf eef")
MODEL_WORDS = _words_in("gravity grav coriolis model dynamics")  # torques that are computed
SUBTRACTION_WORDS = _words_in("less without minus compensated")  # that leave a measured torque
EXTERNAL_WORDS = _words_in("ext external extern hat")  # torques that are ascribed to contact
GRIPPER_WORDS = _words_in("gripper finger fingers hand jaw robotiq")
LOAD_WORDS = _words_in("load loads")  # of servos, ‰ of the stall torque
COUNT_WORDS = _words_in("counts pulse pulses puls increments inc ticks cts")  # of encoders
SHARE_WORDS = COUNT_WORDS | _words_in("percent percentage pct permille promille")
SHARE_WORDS |= _words_in("normalized normalised")
WRENCH_WORDS, WRENCH_WIDTH = _words_in("wrench ft force"), 6
SHARE_SIGNS = {"%", "‰", "pu", "p.u.", *SHARE_WORDS}  # in brackets
IMU_WORDS = _words_in("imu mag magnetometer")  # mx is a magnetic field there
TEMPERATURE_WORDS = _words_in("temperature temperatures temp temps")
LETTERED_JOINTS = ("SLURBT", "SLEURBT")  # of Yaskawa's arms, the longest last
JOINT_WORDS = _words_in("joint joints jnt axis axes actuator j a achse ist")  # A1 Ist [Grad]
ARM_NAME = re.compile(  # one of several arms
    r"(?<![A-Za-z0-9])(left|right|leader|follower|master|slave|[lr]|ur\d+e?"
    r"|(?:arm|robot|panda|franka|iiwa)_?[\dab])(?![A-Za-z0-9])",
    re.IGNORECASE,
)
ROTATION_NAMES = (  # of a pose, beside x, y, z
    *(("rx", "ry", "rz"), ("w", "p", "r"), ("a", "b", "c"), ("roll", "pitch", "yaw")),
    *(("qx", "qy", "qz", "qw"), ("x", "y", "z", "w"), ("o", "a", "t"), ("q1", "q2", "q3", "q4")),
)
CLOCK_NAME = re.compile(r"time|stamp|clock|zeit|(^|[/_ ])t$|sec(s|onds)?$", re.IGNORECASE)
NAME_COLUMN = re.compile(r"(^|[._/])name[\d\[\]._]*$")  # a column of joints' names
BRACKETED_UNIT = re.compile(r" *[\[(](?!J?\d*[\])])([^\])]*)[\])]$", re.IGNORECASE)  # a name's unit
APPENDED_UNIT = re.compile(r"_(mA|A|Nm|deg|rad|degs|rads|deg_s|rad_s|ms|us|ns|s)$")
NUMBERED_MOTOR = r"(.*?[mM]otor)[ _.]?(\d)[ _./](.{1,})"  # a torque may be of its side
NUMBERED_JOINT = r"(.*?)(?:[jJ]oint|[aA]xis|[aA]ctuator|(?<![A-Za-z])[jJaA])[ _.]?(\d)"
UNIT_SPELLINGS = {  # of bracketed and appended units, as a study writes them
    **{"mA": "mA", "A": "A", "Nm": "Nm", "N m": "Nm", "N·m": "Nm", "N.m": "Nm", "N*m": "Nm"},
    **dict.fromkeys(
        ("°", "deg", "degree", "degrees", "Grad", "°/s", "deg/s", "deg_s", "degs", "Grad/s"), "deg"
    ),
    **dict.fromkeys(("rad", "radian", "rad/s", "rad_s", "rads", "rad s-1"), "rad"),
    **dict.fromkeys(("s", "sec", "seconds"), "s"),
    **{"ms": "ms", "msec": "ms", "us": "us", "µs": "us", "μs": "us", "ns": "ns", "nsec": "ns"},
}
OTHER_TORQUES = {  # Nm of one, by the letters of a bracketed unit
    **{"mnm": 1e-3, "knm": 1e3, "ncm": 0.01, "kgfm": 9.80665, "kgm": 9.80665},
    **{"kgfcm": 0.0980665, "kgcm": 0.0980665, "lbfft": 1.355818, "lbft": 1.355818},
    **{"lbfin": 0.1129848, "lbin": 0.1129848, "ozfin": 7.061552e-3, "ozin": 7.061552e-3},
}
# What a quantity is of which the unit alone is named, as `axis1_rad_s`.
UNIT_MEANINGS = {
    **dict.fromkeys(
        ("°/s", "deg/s", "deg_s", "degs", "Grad/s", "rad/s", "rad_s", "rads"), "actual_qd"
    ),
    **{"A": "actual_current", "mA": "actual_current", "Nm": "actual_current_as_torque"},
}


def words(name: str) -> set[str]:
    """Return the words of a name in lower case."""
    name = re.sub(r"(?<=[a-zD])D(?=D?ot)", "d", name)  # qDot, qDDot are one word
    split = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return {*re.findall(r"[a-z]+", split.lower())}


def named_unit(name: str) -> str | None:
    """Return the unit that a name states, as a study writes it, None for none; `rad` and `deg` also
    for their derivatives.
    """
    return UNIT_SPELLINGS.get(unit_text(name))


def unit_text(name: str) -> str:
    """Return the unit at the end of a name as it is written, "" for none."""
    found = (pattern.search(without_joint(name)) for pattern in (BRACKETED_UNIT, APPENDED_UNIT))
    return next((stated[1].strip() for stated in found if stated), "")


def newton_metres(name: str) -> float | None:
    """Return how many Nm one unit of a name is, None for Nm itself, another quantity or none."""
    return OTHER_TORQUES.get("".join(re.findall("[a-z]", unit_text(name).lower())))


def names_joints(stem: str) -> bool:
    """Return whether a name is that of joints without a quantity, as `joint`, `J`, `panda_joint`,
    or a joint's letter.
    """
    split = re.findall(r"[a-z]+", last_part(stem).lower())
    return not split or split[-1] in JOINT_WORDS or stem in {*"".join(LETTERED_JOINTS)}


def lettered_joints(names: Iterable[str]) -> tuple[str, ...]:
    """Return columns that are named by the letters of an arm's joints, with one quantity or none
    behind them (`S_POS`, `L_POS`), in their order.
    """
    by_tail = defaultdict[str, dict[str, str]](dict)
    for name in names:
        if lettered := re.fullmatch(r"([A-Z])((?:[ _.]\w+)?)", without_unit(name)):
            by_tail[lettered[2]][lettered[1]] = name
    for own in by_tail.values():
        if whole := [letters for letters in LETTERED_JOINTS if {*letters} <= {*own}]:
            return tuple(own[letter] for letter in whole[-1])
    return ()


def names_share(name: str) -> bool:
    """Return whether a name states a share of a rating or range, or counts, which are no unit."""
    unit = BRACKETED_UNIT.search(name)
    return bool(words(name) & SHARE_WORDS) or bool(unit and unit[1].strip() in SHARE_SIGNS)


def without_joint(name: str) -> str:
    """Return a name without a number at its end, which a unit may follow."""
    return re.sub(r"[ _.]?\d$", "", name) if re.search(r"[A-Za-z]_[A-Za-z]+_\d$", name) else name


def without_unit(name: str) -> str:
    """Return a column's name without a unit at its end."""
    return APPENDED_UNIT.sub("", BRACKETED_UNIT.sub("", name))


def place_of(name: str) -> tuple[str, int]:
    """Return a column's name without unit and joint, number or axis; and the place that these give,
    -1 for none.
    """
    name = without_unit(name)
    if of_joint := of_named_joint(name):
        return of_joint
    if numbered := re.fullmatch(r"(.*?)[ _.]*[(\[]?[jJ]?(\d)[)\]]?", name):
        return numbered[1], int(numbered[2])
    if numbered := re.fullmatch(NUMBERED_MOTOR, name):
        return f"{numbered[1]} {numbered[3]}", int(numbered[2])
    if numbered := re.fullmatch(NUMBERED_JOINT + r"[ _./](.{1,})", name):  # Joint1_Pos, J1 q
        return numbered[1] + numbered[3], int(numbered[2])
    if part := re.fullmatch(r"(?:(.*)[ _./])?([ftmnFTM])([xyz])", name):  # Fx, wrench_tz
        return f"{part[1] or ''}_{part[2]}", "xyz".index(part[3])
    if axis := re.fullmatch(r"(.*?)_?(?<!velocit)([xyz])", name):
        return axis[1], "xyz".index(axis[2])
    return name, -1


def names_command(stem: str) -> bool:
    """Return whether a name is that of a commanded quantity: by a word, or as `q_d`,
    `O_dP_EE_c`.
    """
    bare = without_unit(stem)
    return bool(words(stem) & COMMAND_WORDS) or bool(re.search(r"[a-z]_[dc]$", bare, re.IGNORECASE))


def is_computed(path: str) -> bool:
    """Return whether a path has a word of commands, or of computed quantities, as an observer's."""
    return bool(words(path) & (DERIVED_WORDS | COMMAND_WORDS))


def quantity(stem: str, width: int, joints: int) -> str | None:
    """Return the meaning of a name: an RTDE channel, or a kind of joint or spatial quantity; None
    for none.

    stem: the name without joints' numbers and units; width: number of its columns; joints: number
    of the file's arm.
    """
    last = last_part(stem)
    if (whole := WHOLE_NAMES.get(last.lower())) and width in (3, 6, 7, joints):
        return whole
    if last in SUFFIXES and width in (len(SUFFIXES[last]), joints):
        return last
    its = words(last) | ({"target"} if names_command(stem) else set())
    if width == 6 and its & {"wrench", "ft"} and not its & (TOOL_WORDS | COMMAND_WORDS):
        return "wrench"
    if width == joints and not its & TOOL_WORDS:
        return _of_joints(its)
    if its & COMMAND_WORDS:
        return None
    spatial = (
        _first_meaning(its, SPATIAL_QUANTITY_WORDS) if width == 3 and not its & IMU_WORDS else None
    )
    if spatial in ("force", "torque"):
        return spatial
    if its & TOOL_WORDS or width == 7:
        meaning = _first_meaning(its, TOOL_QUANTITY_WORDS)
        return None if width == 7 and meaning != "actual_TCP_pose" else meaning
    return spatial


def names_positions(stem: str) -> bool:
    """Return whether a name is that of joint positions, measured or commanded."""
    last = last_part(stem)
    its = words(last)
    other = its & (TOOL_WORDS | TEMPERATURE_WORDS | GRIPPER_WORDS)
    whole = WHOLE_NAMES.get(last.lower())
    named = not other and _first_meaning(its, JOINT_QUANTITY_WORDS) == "q"
    return named or whole == "actual_q"


def kind_of_quantity(word: str) -> str | None:
    """Return the kind of joint quantity that a word names, as q, qd or load; None for none."""
    return _first_meaning({word.lower()}, JOINT_QUANTITY_WORDS | {"load": LOAD_WORDS})


def is_of_motors(stem: str) -> bool:
    """Return whether a name has a word of the motors' side, or "raw"."""
    return bool(words(stem) & {"motor", "motors", "motormoment", "raw"})


def unused(stem: str, columns: Sequence[str], joints: int) -> str:
    """Return why a quantity of no channel is left out, by its name and those of its columns."""
    name = last_part(stem)
    its = words(name)
    if len(columns) > WRENCH_WIDTH and its & WRENCH_WORDS:
        return f"{len(columns)} columns, no wrench: external joint torques, by their number"
    of_joints = kind_of_quantity(name) and {place_of(column)[1] for column in columns} - {-1}
    if of_joints and 1 < len(of_joints) < joints:
        missing = joints - len(of_joints)
        return f"of {len(of_joints)} joints, and the arm has {joints}: {missing} missing"
    if names_share(columns[0]):
        return "a share of a rating, or counts, by its name: in no unit"
    reasons = {
        frozenset(EXTERNAL_WORDS): "a torque that the controller ascribes to contact",
        frozenset(MODEL_WORDS): "computed by the controller, not measured",
        frozenset(JOINT_QUANTITY_WORDS["qdd"]): "accelerations, which no study reads: it derives "
        "them from the positions",
        frozenset(LOAD_WORDS): "a load of servos, a share of their stall torque, maybe with the "
        "direction in bit 10: no unit is known",
        frozenset(GRIPPER_WORDS): "of a gripper, no joint of the arm",
        frozenset(TEMPERATURE_WORDS): "temperatures of other things than this arm's joints",
    }
    named = (reason for spellings, reason in reasons.items() if its & spellings)
    known = name in RECORDED_CHANNELS or is_unused(columns[0])
    return next(named, "a known channel that no step reads" if known else UNKNOWN_NAME)


def last_part(path: str) -> str:
    """Return the part of a path that names the quantity: the last one, or the one before if that
    names joints alone, as in `position/left_joint`.
    """
    parts = path.rstrip("/").split("/")
    *above, last = [part for part in parts if part.lower() not in CONTAINER_WORDS] or parts[-1:]
    of_joints = not words(ARM_NAME.sub("", last)) - JOINT_WORDS
    told = of_joints and above and any(map(kind_of_quantity, words(above[-1])))
    return above[-1] if told else last


def _first_meaning(its: set[str], meanings: Mapping[str, set[str]]) -> str | None:
    """Return the first meaning with a word in common with `its`; None for none."""
    return next((meaning for meaning, spellings in meanings.items() if its & spellings), None)


def _of_joints(its: set[str]) -> str | None:
    kind = _first_meaning(its, JOINT_QUANTITY_WORDS)
    if its & TEMPERATURE_WORDS:
        return "joint_temperatures"
    if its & (EXTERNAL_WORDS | GRIPPER_WORDS) or (kind is None and not its & COMMAND_WORDS):
        return None
    if its & MODEL_WORDS and not its & SUBTRACTION_WORDS:
        return None
    if kind == "effort":
        return kind
    if its & COMMAND_WORDS:
        return "target_moment" if kind == "torque" else f"target_{kind or 'q'}"
    return {"qdd": None, "torque": "actual_current_as_torque"}.get(kind or "", f"actual_{kind}")
