"""The joints of arms among all joints that a message names: those of grippers, rails and heads."""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from ur5lib.channels import MOST_JOINTS

JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
JOINT_NAMES = [  # of drivers, and as the teach panel has them
    re.compile(name, re.IGNORECASE)
    for name in (
        r"shoulder[ _]?pan|(?<![a-z])base(?=[ _.][a-z]+$|$)",
        r"shoulder[ _]?lift|(?<![a-z])shoulder(?![ _]?pan)",
        *("elbow", r"wrist[ _]?1", r"wrist[ _]?2", r"wrist[ _]?3"),
    )
]
SEVEN_JOINT_NAMES = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")  # joints of a seven-jointed arm
SEVEN_JOINT_NAME = re.compile(
    rf"(?<![A-Za-z0-9])({'|'.join(SEVEN_JOINT_NAMES)})(?![A-Za-z0-9])", re.IGNORECASE
)
OTHER_JOINTS = re.compile(
    "gripper|finger|knuckle|thumb|hand|jaw|robotiq|rail|linear|prismatic|slide|track|wheel|caster|"
    "head|torso|neck|leg|base_joint",
    re.IGNORECASE,
)
LAST_NUMBER = re.compile(r"(\d)(?=\D*$)")
FEWEST_JOINTS = 4  # of an arm


Places = list[tuple[int, str]]  # and names
Parted = Callable[[str], tuple[str, int | None] | None]  # of a name: the rest and the place, if any


class ArmJoints(NamedTuple):
    """The names of an arm's joints in its order, and their common label, as `left`, maybe empty."""

    label: str
    names: tuple[str, ...]


def joint_order(names: tuple[str, ...]) -> list[int] | None:
    """Return the places of joints 1 to 6 of a UR among names; None unless each joint is named
    once.
    """
    places = [[k for k, name in enumerate(names) if joint.search(name)] for joint in JOINT_NAMES]
    return [found[0] for found in places] if all(len(found) == 1 for found in places) else None


def arms_among(names: Sequence[str]) -> list[ArmJoints]:
    """Return the arms of which the joints are among the names.

    They are found by the names of a UR's joints or a seven-jointed arm's, else by one name with
    numbers, else by a common first word, else as all names but those of a gripper, rail or head.
    """
    left = [name for name in names if not OTHER_JOINTS.search(name)]
    whole = [*range(len(JOINTS))]
    urs = [one for one in _groups(left, _of_ur) if sorted(p for p, _ in one[1]) == whole]
    groups = urs or [*filter(_is_arm, _groups(left, _of_seven))]
    groups = groups or [*filter(_is_arm, _groups(left, _numbered))]
    if not groups:
        by_word = [*filter(_is_arm, _groups(left, _first_word))]
        are_arms = len(by_word) > 1 or any(len(joints) >= len(JOINTS) for _, joints in by_word)
        groups = by_word if are_arms else [*filter(_is_arm, _groups(left, _any))]
    return [ArmJoints(_label(stem), tuple(n for _, n in sorted(g))) for stem, g in groups]


def _is_arm(group: tuple[str, Places]) -> bool:
    """Return whether a group has as many joints as an arm, each with a place of its own."""
    places = [place for place, _ in group[1]]
    return FEWEST_JOINTS <= len(places) <= MOST_JOINTS and len({*places}) == len(places)


def _groups(names: Sequence[str], parted: Parted) -> Iterator[tuple[str, Places]]:
    """Yield, for each rest of a name without its joint, the joints' places and names.

    parted: returns of a name the rest and the place, None for a name to leave out.
    """
    groups = defaultdict[str, Places](list)
    for k, name in enumerate(names):
        if (parts := parted(name)) is not None:
            groups[parts[0]].append((k if parts[1] is None else parts[1], name))
    yield from groups.items()


def of_named_joint(name: str) -> tuple[str, int] | None:
    """Return (name without the joint, place of the joint from 0) for the joint of a UR or a
    seven-jointed arm; None if a name has neither.
    """
    return _of_ur(name) or _of_seven(name)


def _of_ur(name: str) -> tuple[str, int] | None:
    places = [k for k, joint in enumerate(JOINT_NAMES) if joint.search(name)]
    return (JOINT_NAMES[places[0]].sub("", name), places[0]) if len(places) == 1 else None


def _of_seven(name: str) -> tuple[str, int] | None:
    found = SEVEN_JOINT_NAME.search(name)
    return found and (SEVEN_JOINT_NAME.sub("", name), SEVEN_JOINT_NAMES.index(found[1].lower()))


def _numbered(name: str) -> tuple[str, int] | None:
    found = LAST_NUMBER.search(name)
    return found and (name[: found.start()] + name[found.end() :], int(found[1]))


def _first_word(name: str) -> tuple[str, None] | None:
    word = re.split(r"[_./ ]", name)[0]
    return (word, None) if word else None


def _any(name: str) -> tuple[str, None] | None:
    return ("", None) if name else None


def _label(stem: str) -> str:
    """Return the common part of joints' names without the word joint, usable in a path."""
    return "_".join(word for word in re.split(r"[^A-Za-z0-9]+", stem) if word not in ("", "joint"))
