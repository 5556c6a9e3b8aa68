"""Verification and copying of published files."""

import os
import shutil
from pathlib import Path

import pooch

from ur5lib.errors import InputError


def is_there(path: Path, checksum: str, kind: str = "sha256") -> bool:
    """Return whether a file exists. Raises InputError if its checksum is another."""
    if not path.exists():
        return False
    if pooch.file_hash(path, alg=kind) != checksum:
        raise InputError(
            f"{path} differs from the published file; move it away and fetch again, "
            "or put your own recording into another folder"
        )
    return True


def place(source: Path, target: Path, checksum: str, kind: str = "sha256") -> None:
    """Copy a file under a temporary name, verify it and rename it.

    Raises InputError if its checksum is another, or it cannot be written.
    """
    aside = target.with_name(f".{target.name}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, aside)
        if pooch.file_hash(aside, alg=kind) != checksum:
            raise InputError(
                f"{source} is not the published file (its checksum differs); download it again"
            )
        os.replace(aside, target)
    except OSError as error:
        raise InputError(
            f"{target} cannot be written ({error.strerror}); "
            "check its name, the disk space and the permissions"
        ) from error
    finally:
        if aside.exists():
            aside.unlink()
