"""One run in two recordings, found by its contents, whatever its format, name and length.

Positions come again where a motion is repeated, but the noise of the efforts recorded with them
does not.
"""

import hashlib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from ur5lib.channels import MEASURED_EFFORTS, MOST_JOINTS, Effort, columns, joint_count
from ur5lib.recordings.less_gravity import TORQUE_LESS_GRAVITY
from ur5lib.timeseries.arrays import Array, Labels

# In rad, and in A or Nm: coarser than formats write, finer than noise, with borders between
# decimals.
RESOLUTION, RESOLUTION_OF_EFFORTS = np.pi / 3000, np.pi / 300
AS_RECORDED = [*MEASURED_EFFORTS, TORQUE_LESS_GRAVITY]
MAX_ROWS_KEPT = 256  # rows that are kept
MIN_ROWS_COMPARED = 8  # rows from which on two recordings are compared
MIN_COMMON_SHARE = 0.5  # share of common rows; copies have nearly all, other runs almost none
MAX_STEPS = 1e9  # steps; damaged cells are larger
EXACT_INTEGER_BITS = 53  # of an integer that every reader of JSON knows


def fingerprint(frames: pd.DataFrame) -> list[int]:
    """Return the least hashes of the rows, which two copies of a run have in common.

    A bottom-k sketch (A. Broder, On the resemblance and containment of documents, 1997). frames:
    channels of the robot; empty if efforts were not recorded.
    """
    joints = joint_count(frames)
    steps = dict.fromkeys(columns("actual_q", joints), RESOLUTION)
    efforts = columns(Effort.measured_in(frames).channel, joints)
    steps |= dict.fromkeys(efforts, RESOLUTION_OF_EFFORTS)
    if not {*steps} <= {*frames}:
        return []
    complete = np.all([frames[name].notna() for name in steps], axis=0)
    rounded = {name: _rounded(frames[name].to_numpy()[complete], steps[name]) for name in steps}
    hashes = pd.util.hash_pandas_object(pd.DataFrame(rounded), index=False).to_numpy()
    return [
        int(one) for one in np.unique(hashes >> np.uint64(64 - EXACT_INTEGER_BITS))[:MAX_ROWS_KEPT]
    ]


def efforts_in(frames: pd.DataFrame) -> str:
    """Return a hash of the efforts of all rows, which a command that is sent again has in common;
    empty if they were not recorded, or never change. frames: as read, without gravity added.
    """
    named = {name for channel in AS_RECORDED for name in columns(channel, MOST_JOINTS)}
    names = [name for name in frames if name in named]
    if not names or frames[names].nunique().max() < 2:
        return ""
    return hashlib.sha256(frames[names].to_numpy(float).tobytes()).hexdigest()


def _rounded(values: Array, step: float) -> Labels:
    return np.rint(values / step).clip(-MAX_STEPS, MAX_STEPS).astype("int32")


def same_runs(fingerprints: Mapping[str, Sequence[int]]) -> Iterator[tuple[str, str]]:
    """Yield the pairs of recordings that are of one run, one maybe of a part of it; fingerprints:
    by recording.
    """
    holders = defaultdict(list)
    for name, rows in fingerprints.items():
        for row in rows:
            holders[row].append(name)
    pairs = (pair for names in holders.values() for pair in combinations(names, 2))
    for one, other in dict.fromkeys(pairs):
        if _are_alike(fingerprints[one], fingerprints[other]):
            yield one, other


def spare_copy(pair: tuple[str, str], roles: Mapping[str, str]) -> str:
    """Return which of two recordings of one run may be left out of a study; empty for none.

    roles: by recording. A fitted one stays; if both are fitted, or one of the roles must be wrong,
    the user has to decide.
    """
    held = [roles.get(name, "") for name in pair]
    if sorted(held) == ["fit", "validate"]:
        return pair[held.index("validate")]
    return pair[1] if held in (["validate"] * 2, ["contact"] * 2) else ""


def _are_alike(one: Sequence[int], other: Sequence[int]) -> bool:
    """Return whether the shorter of two recordings has mostly rows of the other."""
    last = min(
        (rows[-1] for rows in (one, other) if len(rows) == MAX_ROWS_KEPT),
        default=1 << EXACT_INTEGER_BITS,
    )
    comparable = [{row for row in rows if row <= last} for rows in (one, other)]
    fewest, common = min(map(len, comparable)), len(comparable[0] & comparable[1])
    return fewest >= MIN_ROWS_COMPARED and common > MIN_COMMON_SHARE * fewest
