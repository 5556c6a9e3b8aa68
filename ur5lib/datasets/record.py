"""Files of a record at Zenodo, which lists them with their sizes and MD5."""

import tempfile
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

import pooch
import requests

from ur5lib.datasets.placing import is_there, place
from ur5lib.errors import InputError

TIMEOUT = 30  # s
PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.- ")


class Listed(NamedTuple):
    """A file of a record: its URL, size [bytes] and MD5."""

    name: str
    url: str
    size: int
    md5: str


class Record(NamedTuple):
    """The files of a record, and Zenodo's name of its licence, empty without one."""

    files: list[Listed]
    licence: str


def fetch_record(
    record: str, leave_out: Collection[str], target: Path, source: Path | None = None
) -> Record:
    """Copy the files of a record into a folder, from the network or from another folder.

    record: URL of its listing, which is always read; leave_out: names of files. Every file is
    verified before it is put in place; files that exist already are kept. Returns the files in
    place, and the licence. Raises InputError for a failure of the network, the listing, the source,
    a checksum or the target.
    """
    listed = read_listing(record)
    wanted = [file for file in listed.files if file.name not in leave_out]
    for file in wanted:
        if is_there(target / file.name, file.md5, "md5"):
            continue
        if source is None:
            _download(file, target)
        else:
            _copy(file, source, target)
    return Record(wanted, listed.licence)


def read_listing(record: str) -> Record:
    """Return a record's files and licence. Raises InputError if its listing cannot be read."""
    try:
        answer = requests.get(record, timeout=TIMEOUT)
        answer.raise_for_status()
        listing = answer.json()
        licence = listing.get("metadata", {}).get("license", {}).get("id", "")
        return Record([_listed(entry) for entry in listing["files"]], str(licence))
    except (requests.RequestException, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"the list of files at {record} could not be read ({type(error).__name__}); check the "
            "network, or download the files by hand and use `ur5 import`"
        ) from error


def _listed(entry: dict[str, Any]) -> Listed:
    name, (kind, md5) = str(entry["key"]), entry["checksum"].split(":")
    if kind != "md5" or not {*name} <= PLAIN or name.startswith("."):
        raise ValueError(name)  # a name that might leave the folder, or another kind of checksum
    return Listed(name, entry["links"]["self"], int(entry["size"]), md5)


def _download(file: Listed, target: Path) -> None:
    pooch.get_logger().setLevel("WARNING")
    with tempfile.TemporaryDirectory(dir=_made(target), prefix=".") as folder:
        try:
            path = pooch.retrieve(
                file.url,
                known_hash=f"md5:{file.md5}",
                fname=file.name,
                path=folder,
                downloader=pooch.HTTPDownloader(progressbar=True, timeout=TIMEOUT),
            )
        except (requests.RequestException, OSError, ValueError) as error:
            raise InputError(
                f"{file.url} could not be downloaded ({type(error).__name__}); check the network "
                f"and the disk space ({file.size / 1e6:,.0f} MB), and fetch again"
            ) from error
        Path(path).rename(target / file.name)


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder} cannot be written ({error.strerror}); check its name and the permissions"
        ) from error
    return folder


def _copy(file: Listed, source: Path, target: Path) -> None:
    if not (source / file.name).is_file():
        raise InputError(f"{source} lacks {file.name}; use --from with a folder that contains it")
    place(source / file.name, target / file.name, file.md5, "md5")
