"""Download of a published data set, with its files verified."""

import shutil
import zipfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import pooch
import requests
from pooch.hashes import hash_matches

from ur5lib.datasets.catalogue import catalogue
from ur5lib.errors import InputError, unknown
from ur5lib.tables import made, write_aside

TIMEOUT_S = 30
MOST_GB = 10  # of an archive, and of its unpacked files; the catalogue's largest has less than 1
NAME_CHARACTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.- ")


def is_there(path: Path, checksum: str) -> bool:
    """Return whether a file exists; checksum: SHA-256, or another kind as in `md5:…`.

    Raises InputError if its checksum differs.
    """
    if path.exists() and not hash_matches(path, checksum):
        raise InputError(
            f"{path} differs from the published file; move it away and fetch again, "
            "or put your own recording into another folder"
        )
    return path.exists()


def place(source: Path, target: Path, checksum: str) -> None:
    """Copy a file under a temporary name, verify it and rename it.

    Raises InputError if its checksum differs, or it cannot be written.
    """

    def copy(aside: Path) -> None:
        shutil.copyfile(source, aside)
        if not hash_matches(aside, checksum):
            raise InputError(
                f"{source} is not the published file (its checksum differs); download it again"
            )

    write_aside(target, copy)


def fetch_archive(
    archive: str,
    checksums: Mapping[str, str],
    target: Path,
    source: Path | None = None,
    unverified: int = 0,
) -> int:
    """Copy files into a folder, from a zip file in the network or from another folder.

    archive: URL of the zip file; checksums: SHA-256 by name; unverified: number of files in the
    archive without a listed SHA-256. All listed files are verified before they are put in place;
    existing files are kept. Returns the number of verified files added. Raises InputError for a
    failure of the network, the source, a checksum or the target.
    """
    missing = {f: sha for f, sha in checksums.items() if not is_there(target / f, sha)}
    others = unverified and len(others_beside(target, checksums)) < unverified
    if not (missing or others):
        return 0
    with _folder_in(target) as folder:
        unpacked = source or _unpacked(archive, folder)
        _copy_all(unpacked, str(source or archive), missing, target)
        if others:
            _copy_others(unpacked, checksums, target)
    return len(missing)


@contextmanager
def _folder_in(target: Path) -> Iterator[Path]:
    """Yield a new temporary folder in another; one that a killed run left is deleted first."""
    folder, existed = target / ".fetching", target.exists()
    shutil.rmtree(folder, ignore_errors=True)
    try:
        yield made(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if not existed:
            with suppress(OSError):  # if it is not empty
                target.rmdir()


def _unpacked(url: str, folder: Path) -> Path:
    """Download and unpack a zip file in a folder, and return the folder with its files.

    Raises InputError if that fails.
    """
    remedy = "check the network, or copy the recordings from a local folder with --from"
    archive = folder / "archive.zip"
    # the server packs archives on request: only their files have checksums
    _retrieve(url, None, archive, remedy, int(MOST_GB * 1e9))
    try:
        with zipfile.ZipFile(archive) as packed:
            size_gb = sum(file.file_size for file in packed.infolist()) / 1e9
            if size_gb <= MOST_GB:
                packed.extractall(folder / "files")
    except zipfile.BadZipFile as error:
        raise InputError(
            f"{url} gives no zip file, but perhaps a web page, or a part of one; {remedy}"
        ) from error
    except Exception as error:  # for damaged archives, zipfile raises anything
        raise InputError(f"{url} could not be unpacked ({error}); {remedy}") from error
    if size_gb > MOST_GB:
        raise InputError(f"{url} unpacks to {size_gb:,.0f} GB, more than {MOST_GB}; {remedy}")
    return folder / "files"


def _retrieve(url: str, checksum: str | None, path: Path, remedy: str, most: int) -> None:
    """Download a file, and verify it. Raises InputError with the remedy if that fails.

    most: largest number of bytes; a larger file is not the published one.
    """
    pooch.get_logger().setLevel("WARNING")
    downloader = pooch.HTTPDownloader(progressbar=True, timeout=TIMEOUT_S)

    def download(url: str, aside: str, pool: Any) -> None:
        with open(aside, "wb") as file:
            downloader(url, _Bounded(file, most, url, remedy), pool)

    try:
        pooch.retrieve(url, checksum, path.name, path.parent, downloader=download)
    except (requests.RequestException, OSError, ValueError, KeyError) as error:
        raise InputError(
            f"{url} could not be downloaded ({type(error).__name__}); {remedy}"
        ) from error


class _Bounded:
    """A file to be written, of at most a given size."""

    def __init__(self, file: BinaryIO, most: int, url: str, remedy: str) -> None:
        self.file, self.most = file, most
        self.fault = f"{url} sends more than {most:,} bytes; {remedy}"

    def write(self, chunk: bytes) -> None:
        """Write a part. Raises InputError beyond the size."""
        if self.file.tell() + len(chunk) > self.most:
            raise InputError(self.fault)
        self.file.write(chunk)

    def flush(self) -> None:
        """Write what is buffered."""
        self.file.flush()


def others_beside(folder: Path, checksums: Mapping[str, str]) -> list[Path]:
    """Return the files of a folder that have the ending of a listed file, but are not listed;
    checksums: SHA-256 by listed name.
    """
    endings = {Path(file).suffix for file in checksums}
    files = (
        path for path in folder.glob("*") if path.is_file() and {*path.name} <= NAME_CHARACTERS
    )
    return [path for path in sorted(files) if path.suffix in endings and path.name not in checksums]


def _copy_others(source: Path, checksums: Mapping[str, str], target: Path) -> None:
    for folder in sorted({path.parent for path in located(checksums, source).values()}):
        for path in others_beside(folder, checksums):
            if not (target / path.name).exists():
                place(path, target / path.name, pooch.file_hash(path))


def _copy_all(source: Path, origin: str, checksums: Mapping[str, str], target: Path) -> None:
    paths = located(checksums, source)
    absent = [file for file in checksums if file not in paths]
    if absent:
        raise InputError(
            f"{origin} lacks {len(absent)} of {len(checksums)} files, e.g. {absent[0]}; "
            "use --from with a folder that contains all of them"
        )
    for file, checksum in checksums.items():
        place(paths[file], target / file, checksum)


def located(checksums: Mapping[str, str], source: Path) -> dict[str, Path]:
    """Return the paths of the listed files in a folder, found by their names or else by their
    SHA-256; checksums: SHA-256 by name.

    In a repository, they may have other paths and names.
    """
    named = {file: source / file for file in checksums if (source / file).is_file()}
    others = [file for file in checksums if file not in named]
    endings = {Path(file).suffix for file in others}
    paths = [path for path in source.rglob("*") if path.suffix in endings and path.is_file()]
    hashed = {pooch.file_hash(path): path for path in paths}
    renamed = {file: hashed[checksums[file]] for file in others if checksums[file] in hashed}
    return named | renamed


class RemoteFile(NamedTuple):
    """A file of a record: its URL, size [bytes] and checksum, as in `md5:…`."""

    name: str
    url: str
    size: int
    checksum: str


class ZenodoRecord(NamedTuple):
    """The files of a record, and Zenodo's name of its licence, empty without one."""

    files: list[RemoteFile]
    licence: str


def fetch_record(
    record: str, leave_out: Collection[str], target: Path, source: Path | None = None
) -> ZenodoRecord:
    """Copy the files of a record into a folder, from the network or from another folder.

    record: URL of its listing, which is always read; leave_out: names of files. Every file is
    verified before it is put in place; files that exist already are kept. Returns the record's
    files, now in the folder, and its licence. Raises InputError for a failure of the network, the
    listing, the source, a checksum or the target.
    """
    listing = read_listing(record)
    files = [file for file in listing.files if file.name not in leave_out]
    for file in files:
        if is_there(target / file.name, file.checksum):
            continue
        if source is None:
            _download(file, target)
        elif (source / file.name).is_file():
            place(source / file.name, target / file.name, file.checksum)
        else:
            raise InputError(
                f"{source} lacks {file.name}; use --from with a folder that contains it"
            )
    return ZenodoRecord(files, listing.licence)


def read_listing(record: str) -> ZenodoRecord:
    """Return a record's files and licence. Raises InputError if its listing cannot be read."""
    try:
        answer = requests.get(record, timeout=TIMEOUT_S)
        answer.raise_for_status()
        listing = answer.json()
        licence = listing.get("metadata", {}).get("license", {}).get("id", "")
        return ZenodoRecord([_listed(entry) for entry in listing["files"]], str(licence))
    except (requests.RequestException, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"the list of files at {record} could not be read ({type(error).__name__}); check the "
            "network, or download the files by hand and use `ur5 import`"
        ) from error


def _listed(entry: dict[str, Any]) -> RemoteFile:
    name, checksum = str(entry["key"]), str(entry["checksum"])
    if not checksum.startswith("md5:") or not {*name} <= NAME_CHARACTERS or name.startswith("."):
        raise ValueError(name)  # a name that might leave the folder, or another kind of checksum
    return RemoteFile(name, entry["links"]["self"], int(entry["size"]), checksum)


def _download(file: RemoteFile, target: Path) -> None:
    space = f"the disk space ({file.size / 1e6:,.0f} MB)"
    with _folder_in(target) as folder:
        aside = folder / file.name
        remedy = f"check the network and {space}, and fetch again"
        _retrieve(file.url, file.checksum, aside, remedy, file.size)
        aside.rename(target / file.name)


def fetch(name: str, target: Path | None = None, source: Path | None = None) -> str:
    """Fetch a data set, and return a sentence about it.

    target: the folder to write to, by default raw/<name>; source: a folder to copy from instead of
    the network. Raises InputError for an unknown name, for one that must be downloaded by hand, and
    as `fetch_archive` and `fetch_record`.
    """
    if name not in catalogue():
        raise unknown("data set", name, catalogue())
    dataset, folder = catalogue()[name], target or Path("raw") / name
    if dataset.archive or (dataset.checksums and source):
        checksums, archive = dataset.checksums, dataset.archive or dataset.address
        added = fetch_archive(archive, checksums, folder, source, dataset.unverified)
        others = len(others_beside(folder, checksums)) if dataset.unverified else 0
        more = f"; {others} others, whose checksums are unknown, are not" if others else ""
        return f"{folder}: {len(checksums)} files verified, {added} of them new{more}"
    if dataset.record:
        files, licence = fetch_record(dataset.record, dataset.leave_out, folder, source)
        return (
            f"{folder}: {len(files)} files verified by the MD5 of {dataset.record}, which states "
            f"the licence {licence or '(none)'}"
        )
    raise InputError(
        f"{name} cannot be downloaded by a program: put the files of {dataset.address} into "
        f"{folder} by hand, and let `ur5 import` write the entries"
        + "; `--from <folder>` verifies a copy"
        * bool(dataset.checksums)
    )
