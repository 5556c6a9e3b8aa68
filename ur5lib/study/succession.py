"""The order in which an arm was driven: `after` in the entries of a study."""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any

from ur5lib.errors import perhaps, some
from ur5lib.study.model import PREVIOUS, Study


def in_succession(entries: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the entries of a pattern's files in the order of the numbers in their paths.

    Each is `after` the previous one, the first after none.
    """
    first, *others = sorted(entries, key=lambda entry: _by_numbers(entry["file"]))
    named = ({**own, "after": before["name"]} for before, own in pairwise([first, *others]))
    return [{key: value for key, value in first.items() if key != "after"}, *named]


def _by_numbers(path: str) -> list[tuple[int, str]]:
    """Return the parts of a path with numbers as integers, to sort run-9 before run-10."""
    parts = re.split(r"(\d+)", path)
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]


def before(name: str, after: Mapping[str, str | None]) -> list[str]:
    """Return the recordings that one follows, directly or not, the oldest first.

    after: by recording, the one that it follows directly, or None.
    """
    chain = list[str]()
    while (earlier := after.get(name)) is not None and earlier not in chain:
        chain.append(name := earlier)
    return chain[::-1]


def wrong_succession(study: Study) -> Iterator[str]:
    """Yield errors where `after` names no recording that can precede."""
    entries = {one.name: one for one in study.recordings}
    after = {one.name: one.after for one in study.recordings if one.after}
    for name, earlier in after.items():
        place, there = f"`recordings.{name}.after`", entries.get(earlier)
        if earlier == PREVIOUS and there is None:
            yield f"{place} is `{PREVIOUS}`, but `file` is no pattern; name the recording before it"
        elif there is None:
            yield (
                f"{place} names {earlier!r}, which is no recording of the study"
                f"{perhaps(earlier, entries)}; correct the name, or remove the key"
            )
        elif there.at_rest:
            yield f"{place} names {earlier}, postures without time; remove the key"
        elif there.arm.known_as != entries[name].arm.known_as:
            yield (
                f"{place} names {earlier}, a recording of {there.arm.known_as}, not of "
                f"{entries[name].arm.known_as}; name one of the same arm, or remove the key"
            )
    yield from _twice_followed(after)
    yield from _circles(after)


def _twice_followed(after: Mapping[str, str]) -> Iterator[str]:
    for earlier in dict.fromkeys(after.values()):
        names = [name for name, own in after.items() if own == earlier]
        if len(names) > 1:
            yield (
                f"recordings: `after` of {some(names)} names {earlier}, but one recording "
                f"comes directly after another; correct one, or write `after: {PREVIOUS}` for the "
                "files of a pattern"
            )


def _circles(after: Mapping[str, str]) -> Iterator[str]:
    """Yield an error for each circle of recordings, at the first of them."""
    found = set[str]()
    for name in after:
        chain = before(name, after)
        if name in chain and name not in found:
            found |= {*chain}
            yield (
                f"`recordings.{name}.after`: {' after '.join([name, *chain[::-1]])} is a circle; "
                "remove the key of the first recording of the session"
            )
