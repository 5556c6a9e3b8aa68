"""Data sets in a zip archive, whose files are verified by SHA-256."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

import pooch
import requests

from ur5lib.datasets.placing import is_there, place
from ur5lib.errors import InputError


def fetch_archive(
    archive: str, checksums: Mapping[str, str], target: Path, source: Path | None = None
) -> int:
    """Copy files into a folder, from a zip file in the network or from another folder.

    archive: URL of the zip file; checksums: SHA-256 by name. Every file is verified before it is
    put in place; files that exist already are kept. Returns the number of files added.
    Raises InputError for a failure of the network, the source, a checksum or the target.
    """
    missing = {f: sha for f, sha in checksums.items() if not is_there(target / f, sha)}
    if missing and source is None:
        _download(archive, missing, target)
    elif missing and source is not None:
        _copy(source, str(source), missing, target)
    return len(missing)


def _download(archive: str, checksums: Mapping[str, str], target: Path) -> None:
    pooch.get_logger().setLevel("WARNING")
    with tempfile.TemporaryDirectory() as folder:
        try:
            pooch.retrieve(
                archive,
                known_hash=None,  # archives are repacked on request; the files are verified
                fname="archive.zip",
                path=folder,
                processor=pooch.Unzip(extract_dir="."),
                downloader=pooch.HTTPDownloader(progressbar=True),
            )
        except (requests.RequestException, OSError, ValueError, KeyError) as error:
            raise InputError(
                f"{archive} could not be downloaded ({type(error).__name__}); check the "
                "network, or copy the recordings from a local folder with --from"
            ) from error
        _copy(Path(folder), archive, checksums, target)


def _copy(source: Path, origin: str, checksums: Mapping[str, str], target: Path) -> None:
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
    """Return the paths of files in a folder: by their names, or else by their SHA-256.

    In a repository, they may have other paths and names.
    """
    named = {file: source / file for file in checksums if (source / file).is_file()}
    others = [file for file in checksums if file not in named]
    endings = {Path(file).suffix for file in others}
    paths = [path for path in source.rglob("*") if path.suffix in endings and path.is_file()]
    hashed = {pooch.file_hash(path): path for path in paths}
    renamed = {file: hashed[checksums[file]] for file in others if checksums[file] in hashed}
    return named | renamed
