"""Arms and recordings as objects, of what `ur5 describe` and `ur5 import` write as files."""

from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, Literal

import yaml

from ur5lib.chain.recordings import Arm, Recordings
from ur5lib.chain.steps import Chain, Files
from ur5lib.errors import InputError, some
from ur5lib.importing.files import as_entries
from ur5lib.importing.written import expect_all, imported_files, print_account, user_statement
from ur5lib.records.quality import Quality
from ur5lib.robots.description import (
    PROJECT_FOLDER,
    load_robot,
    no_description,
    robot_names,
    robot_path,
)
from ur5lib.study.address import YAML_SUFFIXES
from ur5lib.study.model import Recording, Study
from ur5lib.study.reading import parse_study, read_plain
from ur5lib.study.selection import Selection
from ur5lib.tables import ByKey
from ur5lib.workspace.extensions import take_up_all

Role = Literal["fit", "validate", "contact"]


def read_arm(name: str | Path) -> Arm:
    """Return an arm: by its name in the library or in robots/, its file there, or a URDF.

    Of a URDF, robots/<name>.yaml is written, as by `ur5 describe`, unless it is there. Raises
    InputError for an unknown name, and a description that is wrong.

        >>> ur5lib.read_arm("ur5e").name
        'ur5e'
    """
    take_up_all()
    path = Path(name)
    own = path.stem if path.suffix in (*YAML_SUFFIXES, ".urdf") else str(name)
    if path.suffix == ".urdf" and own not in robot_names():
        from ur5lib.commands.described import describe_urdf  # torch, which takes seconds to load

        describe_urdf(path, None, None, own)
    if own not in robot_names():
        here = f"; put {path} into {PROJECT_FOLDER}/" if path.suffix in YAML_SUFFIXES else ""
        raise InputError(no_description(own) + here)
    return Arm(own, load_robot(robot_path(own)))


def read(
    files: str | Path | Sequence[str | Path],
    arm: Arm | str | None = None,
    role: Role | None = None,
) -> Recordings:
    """Return recordings of any known format, or those of a study's YAML file, of one arm.

    What import took the columns for is printed. arm: whose recordings they are, by default what
    the files or the study tell; role: `fit` or `validate` of what nothing touches, or `contact`;
    by default as import finds it, or as the study says. Raises InputError where a file cannot be
    used.

        >>> runs = ur5lib.read(["free1.csv", "free2.csv"], "ur5e")
        >>> runs.names
        ['free1', 'free2']
    """
    take_up_all()
    paths = [Path(files)] if isinstance(files, str | Path) else [*map(Path, files)]
    if not paths:
        raise InputError("no file is named to be read; name at least one")
    name = arm.name if isinstance(arm, Arm) else arm
    if len(paths) == 1 and paths[0].suffix in YAML_SUFFIXES:
        return _recordings(_of_arm(parse_study(read_plain(paths[0]), str(paths[0])), name))
    imported = imported_files(paths, user_statement(name, None, None, []))
    expect_all(imported)
    entries: list[dict[str, Any]] = yaml.safe_load(as_entries(imported))
    stated = {} if role is None else {"role": role}
    plain = {
        "study": "notebook",
        "title": "Recordings",
        "recordings": [e | stated for e in entries],
    }
    print_account(imported)
    return _recordings(_of_arm(parse_study(plain, "the files"), None))


def _of_arm(study: Study, name: str | None) -> Study:
    """Return a study with the recordings of an arm alone, or of its only one."""
    arms = [*study.arms()]
    if name is None and len(arms) > 1:
        raise InputError(f"these recordings are of {some(arms)}; name one of them as arm")
    kept = [one for one in study.recordings if name in (None, one.arm.known_as)]
    if not kept:
        raise InputError(
            f"no recording is of {name}, but of {some(arms)}; name one of these as arm"
        )
    return study.model_copy(update={"recordings": kept})


def _recordings(study: Study) -> Recordings:
    """Return the recordings of a study, read, with what is found in them."""
    selection = Selection(study)
    arm, files = Files(), {name: Files() for name in selection.entries}
    chain = Chain(selection, next(iter(study.arms())), arm, files, {})
    chain.run("describe_arm")
    for name, entry in selection.entries.items():
        chain.run("read_postures" if entry.at_rest else "read_recording", name)
    alone = study.model_copy(update={"recordings": []})
    qualities = {one.name: cache(partial(_quality, one, alone)) for one in study.recordings}
    return Recordings(study, arm, files, ByKey(qualities))


def _quality(entry: Recording, study: Study) -> Quality:
    """Return what `ur5 check` finds in a recording."""
    from ur5lib.commands.check import look_through

    return look_through(entry, study)[0]
