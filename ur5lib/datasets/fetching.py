"""Download of a data set by its name."""

from pathlib import Path

from ur5lib.datasets.archive import fetch_archive
from ur5lib.datasets.catalogue import catalogue
from ur5lib.datasets.record import fetch_record
from ur5lib.errors import InputError


def fetch(name: str, target: Path | None = None, source: Path | None = None) -> str:
    """Fetch a data set, and return a sentence about it.

    target: the folder to write to, by default raw/<name>; source: a folder to copy from instead of
    the network. Raises InputError for an unknown name, for one that must be downloaded by hand, and
    as `fetch_archive` and `fetch_record`.
    """
    if name not in catalogue():
        raise InputError(f"unknown data set {name!r}; available: {', '.join(catalogue())}")
    dataset, folder = catalogue()[name], target or Path("raw") / name
    if dataset.archive:
        added = fetch_archive(dataset.archive, dataset.checksums, folder, source)
        return f"{folder}: {len(dataset.checksums)} files verified, {added} of them new"
    if dataset.record:
        files, licence = fetch_record(dataset.record, dataset.leave_out, folder, source)
        return (
            f"{folder}: {len(files)} files verified by the MD5 of {dataset.record}, which states "
            f"the licence {licence or '(none)'}"
        )
    raise InputError(
        f"{name} cannot be downloaded by a program: put the files of {dataset.address} into "
        f"{folder} by hand, and let `ur5 import` write the entries"
    )
