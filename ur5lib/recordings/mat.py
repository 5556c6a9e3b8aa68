"""Arrays of MATLAB's MAT files, of version 7.3 and before."""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.recordings.hdf5 import hdf5_arrays
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.storage import Arrays, damaged

HDF5_INSIDE = b"\x89HDF\r\n\x1a\n"  # behind the 512 bytes of MATLAB's own head


def mat_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the numbers of a MAT file by name, fields of structures by `structure/field`.

    Raises InputError when it is damaged or no MAT file.
    """
    import scipy.io

    try:
        with path.open("rb") as stream:
            head = stream.read(520)
        if head[512:] == HDF5_INSIDE or head.startswith(HDF5_INSIDE):
            return hdf5_arrays(path, wanted, findings)
        content = scipy.io.loadmat(path, simplify_cells=True)
    except Exception as error:  # of damaged files, the library may raise anything
        raise damaged(path, "a MAT file", error) from error
    return {name: values for name, values in _leaves(content) if wanted is None or name in wanted}


def _leaves(part: dict[str, Any], above: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for name, value in part.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{name}/")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim in (1, 2):
            yield above + name, value
