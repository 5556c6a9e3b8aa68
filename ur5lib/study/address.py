"""The address of a study, the same for all commands: its name, YAML file, or folder of results."""

from collections.abc import Iterator
from os.path import exists, isdir, isfile  # unlike pathlib's, of names that are too long, too
from pathlib import Path
from shlex import quote
from typing import Any

from ur5lib.errors import InputError, perhaps, unknown
from ur5lib.recordings.echo_start import is_echoed

RESULTS_FOLDER = Path("results")
YAML_SUFFIXES = (".yaml", ".yml")
# An address of one of these files means its folder of results.
REPORTS = ("report.html", "report.pdf", "details.html", "results.json")
# Patterns of study files in the working folder.
STUDIES = ("*.yaml", "config/*.yaml", "workflow/studies/*.yaml")
NO_STUDY = "this folder has no study; make one by `ur5 new .`, or name a file"


def study_file(address: str) -> Path:
    """Return the YAML file of a study.

    Raises InputError for a folder of recordings, and where the working folder has no study of this
    name, or several.
    """
    path = _without_report(address)
    if path.suffix in YAML_SUFFIXES and not exists(path):
        _expect_no_neighbour(path)
    if isfile(path) or path.suffix in YAML_SUFFIXES:
        return path
    if isdir(path) and path.parent.name != RESULTS_FOLDER.name and not isdir(path / "tables"):
        entries = f"ur5 import {quote(str(path))}/* --output {path.resolve().name}.yaml"
        raise InputError(f"{path} is a folder of recordings, no study; write one: {entries}")
    names = dict(studies())
    found = [file for file, name in names.items() if name == path.name]
    if not names:
        raise InputError(f"{address}: {NO_STUDY}")
    if not found:
        raise unknown("study", path.name, sorted(set(names.values())))
    if len(found) > 1:
        raise InputError(f"{found[0]} and {found[1]} are both of the study {path.name}; name one")
    return found[0]


def results_folder(address: str) -> Path:
    """Return the folder of results of a study, which may not exist yet.

    Raises InputError where the working folder has no such study.
    """
    path = _without_report(address)
    if path.suffix not in YAML_SUFFIXES and (isdir(path) or len(path.parts) > 1):
        return path
    if isdir(RESULTS_FOLDER / path):
        return RESULTS_FOLDER / path
    return RESULTS_FOLDER / _name(study_file(address))


def is_study(address: str) -> bool:
    """Return whether an address is that of a study, and not of a recording."""
    path = Path(address)
    is_yaml = path.suffix in YAML_SUFFIXES and not is_echoed(path)
    return not isfile(path) or is_yaml or path.name in REPORTS


def _without_report(address: str) -> Path:
    """Return an address as a path; of a report file, the path of its folder."""
    path = Path(address)
    return path.parent if path.name in REPORTS else path


def _expect_no_neighbour(path: Path) -> None:
    """Raise InputError if a YAML file in the folder of a missing one has almost the same name."""
    if isdir(path.parent):
        files = [one.name for one in path.parent.iterdir() if one.suffix in YAML_SUFFIXES]
        if near := perhaps(path.name, files):
            raise InputError(f"{path} does not exist{near}")


def studies() -> Iterator[tuple[Path, str]]:
    """Yield the YAML file and the name of each study in the working folder."""
    for pattern in STUDIES:
        for file in sorted(Path().glob(pattern)):
            try:
                yield file, _name(file)
            except InputError:
                continue  # a file of another program


def _name(file: Path) -> str:
    """Return the name of a study. Raises InputError where the file states none."""
    from ur5lib.study.reading import read_plain

    plain: Any = read_plain(file)
    if not isinstance(plain.get("study"), str):
        raise InputError(f"{file} is no study: it needs `study`, `title` and `recordings`")
    return str(plain["study"])
