"""Files of a workspace's own formats, with the readers that it adds (docs/extensions.md)."""

import re
from collections.abc import Callable, Collection
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import ENDINGS, Arrays, array_format
from ur5lib.records.quality import Finding
from ur5lib.workspace.extensions import additions

OWN_FORMAT = "own"  # the formats' common name in a study; endings distinguish them
Read = Callable[[Path], dict[str, Any]]


@cache
def own_readers() -> dict[str, Read]:
    """Return the workspace's readers by the endings of their files.

    Raises InputError where one is no function, or ur5lib reads files of that ending.
    """
    readers = {}
    for source, ending, read in additions("formats"):
        if not re.fullmatch(r"\.[a-z0-9_]+", ending) or ending in ENDINGS or not callable(read):
            raise InputError(
                f"{source}: {ending!r} is read by ur5lib, is no ending such as `.log`, or has no "
                "function; correct it"
            )
        readers[ending] = read
    return readers


@array_format(OWN_FORMAT, "a file of an own format", *own_readers())
def own_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers that the workspace's reader for files with this ending returns.

    Raises InputError where there is no reader, or it fails.
    """
    readers, ending = own_readers(), path.suffix.lower()
    if ending not in readers:
        raise InputError(
            f"{path}: no extension reads `{ending}` (but {', '.join(readers) or 'nothing'}); add "
            "its reader to extensions/formats.py in the workspace"
        )
    try:
        arrays = {name: np.asarray(own) for name, own in readers[ending](path).items()}
    except InputError:
        raise
    except Exception as error:  # whatever a user's code does
        raise InputError(
            f"{path}: the reader of `{ending}` fails ({type(error).__name__}: {error}); "
            "correct it, or copy the file again from its source"
        ) from error
    return {n: own for n, own in arrays.items() if own.dtype.kind in "iuf" and own.ndim in (1, 2)}
