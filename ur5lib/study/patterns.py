"""Entries of many files: a pattern in `file` stands for an entry of each file that it matches."""

import re
from collections.abc import Iterable, Iterator, Mapping
from glob import glob
from pathlib import Path
from typing import Any

WILDCARD = re.compile(r"[*?\[]")
DAY = re.compile(r"(?<!\d)(20\d\d)[-_]?(\d\d)[-_]?(\d\d)(?!\d)")
NOT_OF_NAMES = re.compile(r"[^A-Za-z0-9_.-]+")


def is_pattern(entry: Any) -> bool:
    """Return whether the file of a recording's entry is a pattern, as in 2026-*/*.csv."""
    if not isinstance(entry, dict) or "simulate" in entry:
        return False
    file, folder = entry.get("file"), entry.get("folder")
    if not isinstance(file, str) or not isinstance(folder, str) or not WILDCARD.search(file):
        return False
    return not Path(folder, file).exists()


def of_each_file(entry: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the entries that an entry with a pattern stands for, in the order of their paths.

    To the name, what the path has beyond the folder is added, without suffix; the date is the first
    in the path, as 2026-03-09, 2026_03_09 or 20260309, unless the entry has one.
    """
    folder = Path(entry["folder"])
    found = (Path(file) for file in glob(entry["file"], root_dir=folder, recursive=True))
    for file in sorted(file for file in found if (folder / file).is_file()):
        own = NOT_OF_NAMES.sub("-", str(file.with_suffix("")))
        day = DAY.search(str(file))
        date = {"date": "-".join(day.groups())} if day else {}
        yield date | {**entry, "file": str(file), "name": f"{entry.get('name')}_{own}"}


def names_by_pattern(entries: Iterable[Any]) -> frozenset[str]:
    """Return the names of the recordings that a study takes by patterns."""
    patterns = (entry for entry in entries if is_pattern(entry))
    return frozenset(str(one["name"]) for entry in patterns for one in of_each_file(entry))
