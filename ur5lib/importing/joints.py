"""The number of joints that the names and widths of a file's arrays tell."""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5lib.channels import MOST_JOINTS
from ur5lib.errors import InputError
from ur5lib.importing.blocks import MEANINGS, TOOL, place_of

JOINTS = 6  # of the maker's arms
MORE = (7, 8, 9)  # joints, a gripper's fingers among them


class OfJoints(NamedTuple):
    """Columns with one value for each joint: their title, their kind of quantity, their number."""

    title: str
    kind: str
    joints: int


def joints_of(path: Path, arrays: Mapping[str, np.ndarray]) -> int:
    """Return of how many joints a file holds the positions: six, or more by their names.

    Raises InputError where they are more than an arm's.
    """
    found = [*_of_joints(arrays)]
    counts = {block.joints for block in found if block.kind == "q"}
    more = max(counts & {*MORE}, default=None)
    if more is None or JOINTS in counts:
        return JOINTS
    if more <= MOST_JOINTS:
        return more
    position = next(block for block in found if block.kind == "q" and block.joints == more)
    others = ", ".join(b.title for b in found if b.joints == more and b is not position)
    raise InputError(
        f"{path} holds {more} joints: {position.title} are positions"
        + (f", and beside them are {others}" if others else "")
        + f"; arms have up to {MOST_JOINTS}. Describe the arm by its URDF (`ur5 describe`), and "
        "write the entry by hand, without a gripper's joints (docs/robots.md)"
    )


def joints_of_nameless(columns: int) -> int:
    """Return of how many joints a table without names has blocks, beside its first column."""
    fitting = (count for count in (JOINTS, *MORE[:2]) if columns % count == 0)
    return next(fitting, JOINTS)


def _of_joints(arrays: Mapping[str, np.ndarray]) -> Iterator[OfJoints]:
    """Yield arrays with a column for each joint, and single columns that are numbered."""
    numbered = defaultdict[str, dict[int, str]](dict)
    for name, values in arrays.items():
        if values.ndim == 2 and 1 not in values.shape:
            if kind := _kind(name):
                yield OfJoints(name, kind, min(values.shape))
        else:
            stem, place = place_of(name)
            numbered[stem][place] = name
    for stem, places in numbered.items():
        order = sorted(places)
        whole = order == list(range(order[0], order[0] + len(order))) and order[0] in (0, 1)
        if whole and (kind := _kind(stem)):
            yield OfJoints(f"{places[order[0]]} … {places[order[-1]]}", kind, len(order))


def _kind(name: str) -> str | None:
    """Return the kind of a quantity of joints by its name."""
    last = name.rstrip("/").rsplit("/", 1)[-1]
    words = {*re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", last).lower())}
    known = (kind for kind, own in MEANINGS.items() if words & own)
    return None if words & TOOL else next(known, None)
