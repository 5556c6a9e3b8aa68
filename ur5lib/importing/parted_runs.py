"""Runs with quantities in files of their own, as q.csv, qd.csv and i.csv of one folder."""

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ur5lib.channels import MOST_JOINTS
from ur5lib.errors import InputError
from ur5lib.importing.spellings import COMMAND_WORDS, TOOL_WORDS, kind_of_quantity, words
from ur5lib.recordings.array_files import format_of
from ur5lib.recordings.delimited import TextTable
from ur5lib.records.quality import Log

TEXT_ENDINGS = (".csv", ".txt", ".tsv", ".dat")
LEROBOT_INFO, LEROBOT_DATA = "meta/info.json", "data/**/*.parquet"
STAMP_WORDS = {"t", "time", "times", "timestamp", "timestamps", "stamp", "stamps", "clock"}
STATE_WORDS = {"state", "states", "trajectory"}  # positions and velocities
BESIDE_QUANTITY = {"joint", "joints", "actual", "measured", "motor", "wrench", "ft", "force"}
BESIDE_QUANTITY |= STATE_WORDS
QUALIFYING_WORDS = BESIDE_QUANTITY | COMMAND_WORDS | TOOL_WORDS | STAMP_WORDS


@dataclass(frozen=True)
class PartedRun:
    """One run that was logged into several files of a folder, one for each quantity, of which the
    file of the positions is the first.
    """

    folder: Path
    files: tuple[str, ...]
    name: str

    def __str__(self) -> str:
        """Return the path of the first file, and the names of the others."""
        return ", ".join([str(self.folder / self.files[0]), *self.files[1:]])


def runs_of(paths: Iterable[Path]) -> list[Path | PartedRun]:
    """Return files in order; those of one run with a quantity each are joined as a PartedRun. A
    folder without a bag is replaced by its text files.
    """
    runs = dict[tuple[Path, str], list[Path]]()
    for path in (file for given in paths for file in _text_files(given)):
        runs.setdefault((path.parent, _rest_of_name(path)), []).append(path)
    return [
        run
        for (folder, name), files in runs.items()
        for run in ([_parted(folder, name, files)] if _is_parted(files) else files)
    ]


def _text_files(path: Path) -> list[Path]:
    """Return the text files of a folder, or of a LeRobot data set those of its data; the path
    itself if it is none, or has a bag or no text files.
    """
    if (path / LEROBOT_INFO).is_file():
        return sorted(path.glob(LEROBOT_DATA)) or [path]
    inside = [file for file in path.iterdir() if file.is_file()] if path.is_dir() else []
    bags = any(format_of(file) == "rosbag" or file.name == "metadata.yaml" for file in inside)
    return ([] if bags else sorted(filter(_is_text, inside))) or [path]


def _is_text(path: Path) -> bool:
    return path.suffix.lower() in TEXT_ENDINGS and path.is_file()


def _parts(path: Path) -> list[str]:
    return re.split(r"[^A-Za-z0-9]+", path.name.split(".")[0])


def _quantity_words(parts: Collection[str]) -> Iterator[str]:
    """Yield the words of a file's name that name its quantity."""
    for word in sorted({word for part in parts for word in words(part)}):
        if kind_of_quantity(word) or word in QUALIFYING_WORDS:
            yield word


def _rest_of_name(path: Path) -> str:
    """Return the parts of a file's name that name no quantity, which the files of a run have in
    common.
    """
    parts = _parts(path)
    return "_".join(
        part for part in parts if not {*_quantity_words([part])} == words(part) != set()
    )


def _is_parted(files: list[Path]) -> bool:
    """Return whether each file contains one quantity, no two the same, and one of them
    positions.
    """
    told = [(*_quantity_words(_parts(path)),) for path in files]
    positions = any(map(_names_positions, files))
    each_once = len({*told}) == len(files) > 1 and all(told)
    return positions and each_once and all(_is_text(path) and _is_narrow(path) for path in files)


def _names_positions(path: Path) -> bool:
    found = {*_quantity_words(_parts(path))}
    positions = found & STATE_WORDS or any(kind_of_quantity(word) == "q" for word in found)
    return bool(positions) and not found & COMMAND_WORDS


def _is_narrow(path: Path) -> bool:
    """Return whether a table has at most the columns of one quantity and a clock, or of the two
    quantities of a state.
    """
    try:
        count = len(TextTable(Log(path, "robot", [])).cells)
    except InputError:
        return False
    is_state = {*_quantity_words(_parts(path))} & STATE_WORDS and count % 2 == 0
    return (count / 2 if is_state else count - 1) <= MOST_JOINTS


def _parted(folder: Path, name: str, files: list[Path]) -> PartedRun:
    ordered = sorted(files, key=lambda path: not _names_positions(path))
    named = name or folder.absolute().name
    return PartedRun(folder, tuple(path.name for path in ordered), named)
