"""A recording as a MAT file of version 5, which MATLAB, Octave and scipy read."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.exporting.contents import Contents, channels
from ur5lib.tables import write_aside


def write_mat(contents: Contents, path: Path) -> None:
    """Write a structure for each table: `time` (N, 1) [s], channels (N, k), and their `units`.

    `start_epoch_s` is time zero in seconds since 1970, NaN where unknown. Raises InputError where
    the file cannot be written or a table is too large for the format.
    """
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    start = np.nan if contents.start is None else contents.start
    structures = {name: _structure(table) for name, table in contents.tables.items()}
    variables = {"recording": contents.name, "start_epoch_s": start, **structures}

    def write(aside: Path) -> None:
        savemat(
            aside,
            variables,
            appendmat=False,
            long_field_names=True,
            do_compression=True,
            oned_as="column",
        )

    try:
        write_aside(path, write)
    except MatWriteError as error:
        raise InputError(
            f"{path}: {contents.name} is too long for a MAT file; export it with --to mcap"
        ) from error


def _structure(table: pd.DataFrame) -> dict[str, Any]:
    groups = channels([*table])
    units = table.attrs["units"]
    arrays = {name: table[columns].to_numpy() for name, columns in groups.items()}
    joined = {name: ", ".join({units[c]: None for c in group}) for name, group in groups.items()}
    return {"time": table.index.to_numpy(), **arrays, "units": {"time": "s", **joined}}
