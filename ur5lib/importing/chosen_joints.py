"""The columns of a file that are of the joints, or of the arm, that the user names."""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError
from ur5lib.importing.account import Account
from ur5lib.importing.spellings import CLOCK_NAME
from ur5lib.recordings.messages import JOINT_FIELDS

JOINT_MARK = "\0"  # where a column's name has the joint's


def joint_columns(names: Iterable[str], joints: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the columns of the named joints, in the order of `joints`, by quantity: the column's
    name without the joint's.
    """
    found = defaultdict[str, dict[str, str]](dict)
    longest_first = sorted(joints, key=len, reverse=True)
    for name in names:
        joint = next((one for one in longest_first if _has(one, name)), None)
        if joint:
            found[_whole(joint).sub(JOINT_MARK, name)][joint] = name
    return {
        quantity.replace(JOINT_MARK, "").rstrip("/._ "): tuple(columns[one] for one in joints)
        for quantity, columns in found.items()
        if len(columns) == len(joints)
    }


def of_joints(
    arrays: Mapping[str, np.ndarray], joints: Sequence[str], path: Path, account: Account
) -> dict[str, np.ndarray]:
    """Return arrays without the columns of joints that the user did not name; the account states
    these.

    Raises InputError where the file has no column of each joint.
    """
    chosen = joint_columns(arrays, joints)
    if not chosen:
        raise InputError(
            f"{path}: --joints {','.join(joints)}: no quantity has a column of each; its columns "
            f"are {', '.join([*arrays][:12])}"
        )
    own = {name for names in chosen.values() for name in names}
    like = [
        re.compile(re.escape(names[0]).replace(re.escape(joints[0]), ".+"))
        for names in chosen.values()
    ]
    others = [
        name
        for name in arrays
        if name not in own and not CLOCK_NAME.search(name) and any(p.fullmatch(name) for p in like)
    ]
    return _without(arrays, others, "another joint than those of --joints", account)


def of_prefix(
    arrays: Mapping[str, np.ndarray], prefix: str, path: Path, account: Account
) -> dict[str, np.ndarray]:
    """Return the arrays with a prefix in their names, and clocks; the account states the others.

    Raises InputError where no name has it.
    """
    own = [name for name in arrays if _has(prefix.rstrip("/._ "), name)]
    if not own:
        names = ", ".join([*arrays][:12])
        raise InputError(f"{path}: --prefix {prefix}: no column has it; its columns are {names}")
    rest = [name for name in arrays if name not in own]
    places = {_place(name) for name in rest if not CLOCK_NAME.search(name)} - {""}
    others = [n for n in rest if not CLOCK_NAME.search(n) or _place(n) in places]
    return _without(arrays, others, f"not of the arm {prefix}", account)


def joint_arrays(arrays: Iterable[str], joints: Sequence[str]) -> set[str]:
    """Return the names of a bag's arrays to be read: those of the named joints, their stamps, and
    all that are of no joints.
    """
    wanted = set[str]()
    for name in arrays:
        place, _, field = name.rpartition("/")
        if field not in JOINT_FIELDS:
            wanted.add(name)
            continue
        for topic in (place, place.rpartition("/")[0]):
            wanted |= {f"{topic}/stamp", f"{topic}/bag_stamp"}
            wanted |= {f"{topic}/{field}/{joint}" for joint in joints}
    return wanted


def _without(
    arrays: Mapping[str, np.ndarray], others: Sequence[str], why: str, account: Account
) -> dict[str, np.ndarray]:
    for name in others:
        account.state("left out", (name,), name, "name", why)
    return {name: values for name, values in arrays.items() if name not in others}


def _place(name: str) -> str:
    return name.rpartition("/")[0]


def _has(part: str, name: str) -> bool:
    return _whole(part).search(name) is not None


def _whole(part: str) -> re.Pattern[str]:
    """Return the pattern that finds a part of a name as a whole word."""
    return re.compile(rf"(?<![A-Za-z0-9]){re.escape(part)}(?![A-Za-z0-9])")
