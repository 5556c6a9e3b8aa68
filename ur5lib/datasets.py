"""Download of published recordings, with verification of every file."""

import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pooch
import requests

from ur5lib.errors import InputError


@dataclass(frozen=True)
class Dataset:
    """A published data set: its archive, and the SHA-256 of each of its files.

    archive: URL of a zip file; folder: path of the files inside it;
    checksums: SHA-256 by path within that folder.
    """

    archive: str
    folder: str
    checksums: Mapping[str, str]


def read_checksums(path: Path) -> dict[str, str]:
    """Read the SHA-256 of each file from a list written by `sha256sum`."""
    lines = (line.split(maxsplit=1) for line in path.read_text(encoding="utf-8").splitlines())
    return {file: checksum for checksum, file in lines}


COMMIT = "dce0de88e75fc6af2a6336d75917244832c1a15e"
DATASETS = {
    "thesis": Dataset(
        archive=f"https://github.com/kkufieta/ur5_modeling_force_estimate/archive/{COMMIT}.zip",
        folder=f"ur5_modeling_force_estimate-{COMMIT}/JointSpaceControl_Model_C_ForceEstim/"
        "RecordedUR5Data",
        checksums=read_checksums(Path(__file__).with_name("thesis.sha256")),
    )
}


def fetch(dataset: Dataset, target: Path, source: Path | None = None) -> int:
    """Copy a data set into a folder, from the network or from another folder.

    Every file is verified before it is put in place; files that exist already are kept.
    Returns the number of files added.
    Raises InputError when the network, the source, a checksum or the target is at fault.
    """
    missing = [file for file in dataset.checksums if not _is_there(dataset, target, file)]
    if missing and source is None:
        _download(dataset, target, missing)
    elif missing and source is not None:
        _copy(dataset, target, missing, source, str(source))
    return len(missing)


def _is_there(dataset: Dataset, target: Path, file: str) -> bool:
    path = target / file
    if not path.exists():
        return False
    if pooch.file_hash(path) != dataset.checksums[file]:
        raise InputError(
            f"{path} differs from the published file; move it away and fetch again, "
            "or put your own recording into another folder"
        )
    return True


def _download(dataset: Dataset, target: Path, files: list[str]) -> None:
    members = [f"{dataset.folder}/{file}" for file in files]
    pooch.get_logger().setLevel("WARNING")
    with tempfile.TemporaryDirectory() as folder:
        try:
            pooch.retrieve(
                dataset.archive,
                known_hash=None,  # archives are repacked on request; the files are verified
                fname="archive.zip",
                path=folder,
                processor=pooch.Unzip(members=members, extract_dir="."),
                downloader=pooch.HTTPDownloader(progressbar=True),
            )
        except (requests.RequestException, OSError, ValueError, KeyError) as error:
            raise InputError(
                f"{dataset.archive} could not be downloaded ({type(error).__name__}); check the "
                "network, or copy the recordings from a local folder with --from"
            ) from error
        _copy(dataset, target, files, Path(folder) / dataset.folder, dataset.archive)


def _copy(dataset: Dataset, target: Path, files: list[str], source: Path, origin: str) -> None:
    absent = [file for file in files if not (source / file).is_file()]
    if absent:
        raise InputError(
            f"{origin} lacks {len(absent)} of {len(files)} files, e.g. {absent[0]}; "
            "use --from with a folder that contains all of them"
        )
    for file in files:
        _copy_verified(source / file, target / file, dataset.checksums[file])


def _copy_verified(source: Path, target: Path, checksum: str) -> None:
    aside = target.with_name(f".{target.name}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, aside)
        if pooch.file_hash(aside) != checksum:
            raise InputError(
                f"{source} is not the published file (its SHA-256 differs); download it again"
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
