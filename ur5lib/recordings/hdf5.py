"""Arrays of an HDF5 file, which MATLAB's MAT files of version 7.3 are too."""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.recordings.quality import Finding
from ur5lib.recordings.storage import Arrays, damaged, optional_import


def hdf5_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the numbers of an HDF5 file by their path in it, None wanted: all of them.

    Raises InputError when it is damaged or no HDF5.
    """
    h5py = optional_import("h5py")
    try:
        with h5py.File(path) as file:
            paths = _paths(file) if wanted is None else wanted
            return {name: values for name in paths if (values := _numbers(file, name)) is not None}
    except Exception as error:  # of damaged files, the library may raise anything
        raise damaged(path, "an HDF5 file", error) from error


def _paths(file: Any) -> Iterator[str]:
    names: list[str] = []
    file.visit(names.append)  # follows no link to another file
    return iter(names)


def _numbers(file: Any, name: str) -> np.ndarray | None:
    """Return a data set of numbers with one or two dimensions, None for anything else."""
    found = file.get(name)
    kind, shape = (getattr(found, key, None) for key in ("dtype", "shape"))
    if kind is None or kind.kind not in "iuf" or not shape or len(shape) > 2:
        return None
    return np.asarray(found[()])
