"""What an HDF5 file does not contain itself: links and arrays that lead to other files."""

from pathlib import Path
from typing import Any

import h5py

from ur5lib.errors import InputError

MAX_LINKS = 16  # that HDF5 follows one after the other


def expect_inside(file: Any, name: str, path: Path, links: int = 0) -> None:
    """Raise InputError where a name in an HDF5 file leads to another file, which stays unopened.

    links: number of links inside the file that were followed to this name.
    """
    parts = name.strip("/").split("/")
    for k in range(len(parts) if links <= MAX_LINKS else 0):
        above, rest = "/".join(parts[:k]), "/".join(parts[k + 1 :])
        link = file.get(f"{above}/{parts[k]}", getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise _elsewhere(path, name, link.filename)
        if isinstance(link, h5py.SoftLink):
            target = link.path if link.path.startswith("/") else f"{above}/{link.path}"
            expect_inside(file, f"{target}/{rest}", path, links + 1)
            return


def expect_own_numbers(array: Any, path: Path) -> None:
    """Raise InputError where the numbers of an HDF5 array are in another file."""
    others = [name for name, *_ in array.external or ()]
    if array.is_virtual:
        others += [one.file_name for one in array.virtual_sources() if one.file_name != "."]
    if others:
        raise _elsewhere(path, array.name, others[0])


def _elsewhere(path: Path, name: str, other: str) -> InputError:
    return InputError(
        f"{path}: {name.strip('/')} is in another file, {other}, and links to other files are not "
        "followed; copy its numbers into this file, or name the other one in the study"
    )
