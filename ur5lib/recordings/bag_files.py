"""The files of a bag: itself, or those of a folder, unpacked where they are compressed."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from rosbags.rosbag2.storage_mcap import zstd

from ur5lib.errors import InputError, some
from ur5lib.recordings.array_files import PACKED_ENDING
from ur5lib.recordings.limits import Unpacking
from ur5lib.strict import read_yaml

ENDINGS_IN_FOLDER = (".bag", ".db3", ".mcap", ".db3.zstd", ".mcap.zstd")
DESCRIPTION = "metadata.yaml"
# `rosbag record` may put the date of a part before its number.
PART_NUMBER = re.compile(r"(?:_\d{4}(?:-\d\d){5})?_(\d+)$")
PIECE_BYTES = 1 << 20  # bytes that are unpacked at a time


def bag_files(path: Path) -> tuple[list[Path], int]:
    """Return the files of a bag in order, and how many parts its description lists that the folder
    lacks.

    path: a file, or a folder with a ROS 2 bag or the numbered parts of a bag. Raises InputError
    where a folder has no bag, or several.
    """
    if not path.is_dir():
        return [path], 0
    found = sorted((file for file in path.iterdir() if _is_bag(file)), reverse=True)
    files = {file.name.removesuffix(PACKED_ENDING): file for file in found}  # unpacked ones first
    listed = _listed_parts(path)
    if present := [files[name] for name in listed if name in files]:
        return present, len(listed) - len(present)
    if not files:
        raise InputError(f"{path} is a folder without a ROS bag (.bag, .db3, .mcap); name a file")
    parts = {_part(name): file for name, file in files.items()}
    numbers = {number for _, number in parts}
    if len(files) > 1 and (len({stem for stem, _ in parts}) > 1 or numbers != {*range(len(files))}):
        raise InputError(
            f"{path} holds {len(files)} bags and no {DESCRIPTION} that makes them one: "
            f"{some([file.name for file in files.values()])}; name one of them"
        )
    return [parts[part] for part in sorted(parts)], 0


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """Yield a file, or the temporary file that it unpacks to. Raises InputError where that is too
    large.
    """
    if path.suffix != PACKED_ENDING:
        yield path
        return
    unpacking = Unpacking(path)
    with TemporaryDirectory() as folder:
        whole = Path(folder, path.stem)
        with zstd.open(path) as packed, whole.open("wb") as plain:
            while piece := packed.read(PIECE_BYTES):
                unpacking.count(len(piece))
                plain.write(piece)
        yield whole


def _is_bag(path: Path) -> bool:
    return path.name.endswith(ENDINGS_IN_FOLDER) and path.is_file()


def _listed_parts(folder: Path) -> list[str]:
    """Return the names of a bag's parts as its description lists them; empty without a
    description.
    """
    try:
        listed = read_yaml(folder / DESCRIPTION)["rosbag2_bagfile_information"]
        names = [Path(name).name for name in listed["relative_file_paths"]]
    except (InputError, OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
        return []
    return [name.removesuffix(PACKED_ENDING) for name in names]


def _part(name: str) -> tuple[str, int]:
    """Return a bag's name without the number of the part, and that number, 0 if it has none."""
    stem, _, ending = name.rpartition(".")
    found = PART_NUMBER.search(stem)
    return f"{stem[: found.start()] if found else stem}.{ending}", int(found[1]) if found else 0
