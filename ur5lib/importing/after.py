"""Which of several files follows another: the arm begins there in the posture in which it ended.

An arm that returns home begins and ends all of its files in one posture. Therefore the posture
proves nothing alone: numbers in the files' paths, or their absolute stamps, must follow, too, and
no third start or end may fit as well. At home, where others do, an arm still comes to rest by
microradians elsewhere, by the motion before. There, a file is taken to follow where it is nearer to
that end than to nearly all others, and where so many of the files are that it is no chance.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy  # loads scipy.stats at its first use

from ur5lib.importing.clocks import MIN_EPOCH_STAMP
from ur5lib.importing.proposal import Proposal, is_clockless
from ur5lib.records.account import AccountRow
from ur5lib.records.motion import SAME_POSTURE
from ur5lib.timeseries.arrays import Array

ELSEWHERE = 1e-3  # rad, beyond which no other posture fits as well
AS_NEAR = 0.05  # share of other postures that may be as near, where all are home
MAX_CHANCE = 1e-3  # that so many files are as near to the end before


@dataclass(frozen=True)
class Ends:
    """First and last posture (n,) [rad] of a recording, and when they were [s], NaN without
    absolute time stamps.

    path: of its file without ending.
    """

    path: str
    first: Array
    last: Array
    began: float
    ended: float


@dataclass(frozen=True)
class Link:
    """How a recording begins in the posture in which the one before it, `before`, ended.

    difference: the largest of a joint between the two postures [rad]; gap: time between them [s],
    NaN without absolute stamps; others: number of other starts and ends; near: how many of these
    are as near; nearest: their least difference [rad]; returned: whether the recording's own end,
    or the start of the one before, is as near to its start.
    """

    before: str
    difference: float
    gap: float
    near: int
    others: int
    nearest: float
    returned: bool

    @property
    def is_alone(self) -> bool:
        """Whether no other start or end is in this posture."""
        return self.nearest > ELSEWHERE

    @property
    def chance(self) -> float:
        """Return the probability that an end without relation is as near; 1 if one of the two
        returned to its start.
        """
        return 1.0 if self.returned else (1 + self.near) / (1 + self.others)

    def row(self) -> AccountRow:
        """Return the row of the account that states this link."""
        where = f"{self.before} ended in the posture in which this begins, within "
        where += f"{self.difference:.1e} rad on all joints"
        later = "" if np.isnan(self.gap) else f", {self.gap:.3g} s before"
        rivals = f"; of {self.others} other starts and ends, the nearest is {self.nearest:.1e} away"
        if not self.is_alone:
            rivals = f"; as near are {self.near} of {self.others} other starts and ends"
        return AccountRow(
            "after", "the recording before", "numbers", "proven", where + later + rivals
        )


def ends_of(proposal: Proposal) -> Ends | None:
    """Return the ends of a proposed recording; None of postures without time, or without finite
    rows.
    """
    moving, file = proposal.moving, proposal.contents
    q = moving.in_si()["actual_q"][:, [*proposal.order]]
    known = np.flatnonzero(np.isfinite(q).all(axis=1) & np.isfinite(moving.time))
    if moving.still or not len(known):
        return None
    first, last = known[[0, -1]]
    began, ended = moving.time[[first, last]]
    if is_clockless(proposal) or began < MIN_EPOCH_STAMP:
        began = ended = np.nan
    path = re.sub(r"\.\w+$", "", str(file.path))
    return Ends(path, q[first], q[last], float(began), float(ended))


def links(ends: Mapping[str, Ends]) -> dict[str, Link]:
    """Return, by the recording's name, the proven link to the one before it; ends: of the
    recordings of one arm, by name.
    """
    pairs = {later: before for before, later in _in_order(ends)}
    found = {later: _link(before, later, ends) for later, before in pairs.items()}
    found = {name: link for name, link in found.items() if link.difference <= SAME_POSTURE}
    at_home = [link for link in found.values() if not link.is_alone]
    near = sum(link.chance <= AS_NEAR for link in at_home)
    proven = scipy.stats.binom.sf(near - 1, len(at_home), AS_NEAR) <= MAX_CHANCE
    return {
        name: link
        for name, link in found.items()
        if link.is_alone or (proven and link.chance <= AS_NEAR)
    }


def _link(before: str, later: str, ends: Mapping[str, Ends]) -> Link:
    """Return how near recording `later` begins to where `before` ended, compared with all other
    starts and ends.
    """
    earlier, own = ends[before], ends[later]
    home = np.stack([earlier.first, own.last])
    others = [one.first for name, one in ends.items() if name != later]
    others += [one.last for name, one in ends.items() if name != before]
    differences, returns = (
        np.abs(postures - own.first).max(axis=1) for postures in (np.stack(others), home)
    )
    difference = float(np.abs(own.first - earlier.last).max())
    near = int(np.count_nonzero(differences <= difference))
    nearest, gap = float(differences.min()), own.began - earlier.ended
    returned = bool(returns.min() <= difference)
    return Link(before, difference, gap, near, len(others), nearest, returned)


def _in_order(ends: Mapping[str, Ends]) -> Iterator[tuple[str, str]]:
    """Yield the pairs (before, later) of recordings that follow each other directly: by absolute
    stamps, or by a number in their paths.
    """
    stamped = {name: one for name, one in ends.items() if np.isfinite(one.began)}
    in_time = sorted(stamped, key=lambda name: stamped[name].began)
    for before, later in pairwise(in_time):
        if stamped[before].ended <= stamped[later].began:
            yield before, later
    yield from _numbered({name: ends[name].path for name in ends if name not in stamped})


def _numbered(paths: Mapping[str, str]) -> list[tuple[str, str]]:
    """Return the pairs (before, later) of recordings with paths that differ in one number, by one.

    Where several recordings fit, the number nearest to the path's end decides.
    """
    counted = {place: name for name, path in paths.items() for place in _places(path)}
    earlier = dict[str, str]()
    for place in sorted(counted, key=lambda place: place.from_end):
        before, later = counted.get(place.previous()), counted[place]
        if before and later not in earlier and before not in earlier.values():
            earlier[later] = before
    return [(before, later) for later, before in earlier.items()]


class _Place(NamedTuple):
    """A number in a path, with the text before it (head) and after it (tail); from_end: how many
    numbers follow.
    """

    from_end: int
    head: str
    number: int
    tail: str

    def previous(self) -> "_Place":
        return self._replace(number=self.number - 1)


def _places(path: str) -> Iterator[_Place]:
    parts = re.split(r"(\d+)", path)
    for k in range(1, len(parts), 2):
        from_end = (len(parts) - k) // 2
        yield _Place(from_end, "".join(parts[:k]), int(parts[k]), "".join(parts[k + 1 :]))
