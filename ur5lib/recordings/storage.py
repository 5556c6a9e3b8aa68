"""What the readers of files that hold arrays share."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.errors import InputError

Arrays = dict[str, np.ndarray]  # by path in the file, (n,) or (n, k) or (k, n)


def optional_import(package: str) -> Any:
    """Return a package that only some formats need. Raises InputError where it is missing."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise InputError(
            f"this format needs the package {package}, which is not installed; install the extra "
            "`formats`: pip install --editable '.[formats]'"
        ) from error


def damaged(path: Path, kind: str, error: Exception) -> InputError:
    """Return the error of a file that a library could not read."""
    if isinstance(error, InputError):
        return error
    if isinstance(error, FileNotFoundError | IsADirectoryError | PermissionError):
        return InputError(
            f"{path} is missing or cannot be read ({error.strerror or 'no such file'}); "
            "add the file, or remove the recording from the study"
        )
    return InputError(
        f"{path} cannot be read as {kind}: it is damaged, incomplete or of another format; copy "
        "it again from its source, or correct `format` in the study"
    )
