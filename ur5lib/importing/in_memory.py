"""Arms and recordings as objects, of what `ur5 describe` and `ur5 import` write as files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, NamedTuple, TypeGuard, get_args

import yaml

from ur5lib.chain.as_files import as_files, named
from ur5lib.chain.recordings import Arm, Recordings, as_recordings
from ur5lib.chain.shown import LOGGER
from ur5lib.chain.steps import Chain, Files
from ur5lib.errors import InputError, briefly, expect_known, expect_text, fault_of_ours, some
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedFiles, ReadPart, as_entries, import_files
from ur5lib.importing.parted_runs import runs_of
from ur5lib.importing.written import expect_all, expect_no_study
from ur5lib.recordings.echo_start import is_echoed
from ur5lib.records.quality import Quality
from ur5lib.robots.description import (
    PROJECT_FOLDER,
    described,
    load_robot,
    no_description,
    robot_names,
    robot_path,
)
from ur5lib.study.address import YAML_SUFFIXES
from ur5lib.study.model import Study
from ur5lib.study.reading import parse_study, read_plain
from ur5lib.study.selection import Selection
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
    path = Path(expect_text(name, "arm"))
    own = path.stem if path.suffix in (*YAML_SUFFIXES, ".urdf") else str(name)
    if path.suffix == ".urdf" and own not in robot_names():
        from ur5lib.commands.described import describe_urdf  # torch, which takes seconds to load

        describe_urdf(path, None, None, own)
    if own not in robot_names():
        here = f"; put {path} into {PROJECT_FOLDER}/" if path.suffix in YAML_SUFFIXES else ""
        raise InputError(no_description(own) + here)
    return Arm(own, load_robot(robot_path(own)))


def read(
    recordings: object,
    arm: Arm | str | None = None,
    role: Role | Mapping[str, Role] | None = None,
    *,
    columns: str | Sequence[str] | Mapping[str, str] = (),
    unit: Mapping[str, str] | None = None,
    rate: float | None = None,
    like: Recordings | None = None,
) -> Recordings:
    """Return recordings of any format that is read, or those of a study's YAML file, of one arm.

    recordings: a file; a data frame, with a clock as column or index; an array (N, M), which has no
    names; arrays by name, each (N,) or (N, n); or several of these, as a list, or by name as a
    mapping. A frame gives to the last bit what it gives as CSV, arrays what they give as a NumPy
    archive. A line of each is logged (INFO of the logger `ur5lib`), and printed where nothing takes
    logs; `account` of the result has what each column was taken for.

    arm: of the recordings, by default what the files or the study state; role: `fit` or `validate`
    of what nothing touches, or `contact`, of all or by name; by default as import finds it, or as
    the study says. As of `ur5 import`, columns: the channels of a table's columns in order, `-` to
    skip one, or the names of columns or arrays by channel; unit: by channel; rate: of rows without
    a clock [Hz]. like: recordings of the same logger, which show how these are read, as one at
    rest, or a short one, does not: arm, form, columns, units and clock are theirs unless stated.
    Raises InputError where a recording cannot be used.

        >>> runs = ur5lib.read(["free1.csv", "free2.csv"], "ur5e")
        >>> runs.names
        ['free1', 'free2']
        >>> again = ur5lib.read(runs["free1"].device("robot"), "ur5e")
        >>> again.names
        ['recording']
    """
    take_up_all()
    given = named(recordings)
    if not given:
        raise InputError("no recording is given to be read; name at least one")
    stated, before = _statement(arm, role, columns, unit, rate), _read_before(like)
    stated = replace(
        stated,
        robot=stated.robot or before.stated.robot,
        columns=stated.columns or before.stated.columns,
        units={**before.stated.units, **stated.units},
        rate=stated.rate or before.stated.rate,
    )
    file = Path(given[0][1]) if len(given) == 1 and given[0][0] == "" else Path()
    if file.suffix in YAML_SUFFIXES and not is_echoed(file):
        if columns or unit or rate or role:
            raise InputError(f"{file} is a study: write columns, units, rates and roles into it")
        return recordings_of(_of_arm(parse_study(read_plain(file), str(file)), stated.robot))
    with TemporaryDirectory() as folder:
        try:
            files = expect_no_study([*as_files(given, Path(folder))])
            imported = import_files(runs_of(files), stated, before.parts)
            expect_all(imported)
            study = _of_arm(_study_of(imported, role, folder), "")
            runs = recordings_of(study)
        except InputError as error:
            raise InputError(_in_python(str(error), folder)) from error
        except Exception as error:
            raise fault_of_ours(error) from error
        for entry in study.recordings:
            if entry.folder.startswith(folder):  # what is found there must be read before it goes
                runs[entry.name].findings()
    runs._read_as = ReadAs(replace(stated, robot=runs.robot), _moved(imported, folder))
    for name in runs.names:
        LOGGER.info(runs.line(name))
    return runs


class ReadAs(NamedTuple):
    """How recordings were read: what was stated of them, and the form of each file."""

    stated: UserStatement
    parts: tuple[ReadPart, ...] = ()


def _read_before(like: object) -> ReadAs:
    """Return how the recordings were read that others are to be read like.

    Raises InputError for anything but recordings of files or data.
    """
    if like is None:
        return ReadAs(UserStatement())
    known = as_recordings(like)._read_as
    if not isinstance(known, ReadAs):
        raise InputError("like: these are of a study; copy the entry of one, with another file")
    return known


def _moved(imported: ImportedFiles, folder: str) -> tuple[ReadPart, ...]:
    """Return the parts of an import, without the temporary folder in which they were read."""
    for one in (one for part in imported.parts for one in part.imported):
        if str(one.entry["folder"]).startswith(folder):
            one.entry["folder"] = ""
    return imported.parts


def _statement(
    arm: object, role: object, columns: object, unit: object, rate: object
) -> UserStatement:
    """Return what a caller states of recordings. Raises InputError for what states nothing."""
    if role is not None:
        for own in role.values() if isinstance(role, Mapping) else [role]:
            expect_known("role", own, get_args(Role))
    name = arm.name if isinstance(arm, Arm) else arm
    if name is not None:
        described(expect_text(name, "arm"))
    if not (unit is None or isinstance(unit, Mapping)):
        raise InputError(f'unit: {briefly(unit)} states none; write {{"actual_current": "mA"}}')
    units = {expect_text(one, "channel"): _unit(own) for one, own in (unit or {}).items()}
    if not (rate is None or (_is_number(rate) and 0 < rate < math.inf)):
        raise InputError(f"rate: {briefly(rate)} is none; state the rows per second [Hz]")
    return UserStatement(str(name or ""), _columns(columns), rate, units)


def _columns(given: Any) -> tuple[str, ...]:
    """Return the stated columns as channels in order, or as `channel=name` of a mapping."""
    if isinstance(given, Mapping):
        pairs = ((expect_text(k, "channel"), expect_text(v, "column")) for k, v in given.items())
        return tuple(f"{channel}={name}" for channel, name in pairs)
    listed = given.split(",") if isinstance(given, str) else given
    if not isinstance(listed, Iterable):
        raise InputError(f"columns: {briefly(given)} names none; list channels, as actual_q")
    return tuple(expect_text(one, "channel") for one in listed)


def _unit(given: object) -> str:
    return str(given) if _is_number(given) else expect_text(given, "unit")


def _is_number(given: object) -> TypeGuard[float]:
    return isinstance(given, Real) and not isinstance(given, bool)


def _in_python(message: str, folder: str) -> str:
    """Return a message of `ur5 import` for callers in Python: without the temporary folder, and
    with arguments in place of options.
    """
    message = re.sub(rf"{re.escape(folder)}/\d+/", "", message)
    message = re.sub(r"with --(\w+) ", r"with \1=", message)
    message = message.replace("a log that moves with it", "a log that moves with it, or as `like`")
    return re.sub(r"--(columns|unit|rate)\b", r"`\1`", message)


def _study_of(
    imported: ImportedFiles, role: Role | Mapping[str, Role] | None, folder: str
) -> Study:
    """Return a study of the imported recordings; folder: the temporary one of data given in memory.

    Raises InputError for the role of a recording that is not there.
    """
    entries: list[dict[str, Any]] = yaml.safe_load(as_entries(imported))
    names = [entry["name"] for entry in entries]
    roles = role if isinstance(role, Mapping) else dict.fromkeys(names, role)
    for name in roles:
        expect_known("recording", name, names)
    for row in (row for entry in entries for row in entry["account"]):
        row |= {key: _in_python(text, folder) for key, text in row.items()}
    for entry in entries:
        entry["role"] = roles.get(entry["name"]) or entry["role"]
    plain = {"study": "notebook", "title": "Recordings", "recordings": entries}
    return parse_study(plain, "the recordings")


def _of_arm(study: Study, name: str) -> Study:
    """Return a study with the recordings of one arm, by name, or "" if all are of one arm. Raises
    InputError otherwise.
    """
    arms = [*study.arms()]
    if not name and len(arms) > 1:
        raise InputError(f"these recordings are of {some(arms)}; name one of them as arm")
    kept = [one for one in study.recordings if name in ("", one.arm.known_as)]
    if not kept:
        raise InputError(
            f"no recording is of {name}, but of {some(arms)}; name one of these as arm"
        )
    return study.model_copy(update={"recordings": kept})


def recordings_of(study: Study) -> Recordings:
    """Return the recordings of a study, read, with what is found in them."""
    selection = Selection(study)
    arm, files = Files(), {name: Files() for name in selection.entries}
    chain = Chain(selection, next(iter(study.arms())), arm, files, {})
    chain.run("describe_arm")
    for name, entry in selection.entries.items():
        chain.run("read_postures" if entry.at_rest else "read_recording", name)
    return Recordings(study, arm, files, Checks(study))


class Checks(Mapping[str, Quality]):
    """What `ur5 check` finds in each recording of a study, by name; a recording is checked when
    first asked for.
    """

    def __init__(self, study: Study) -> None:
        """Take the study; nothing is read yet."""
        self._entries = {one.name: one for one in study.recordings}
        self._alone = study.model_copy(update={"recordings": []})
        self._known = dict[str, Quality]()

    def __getitem__(self, name: str) -> Quality:
        """Return what is found in a recording."""
        from ur5lib.commands.check import look_through

        if name not in self._known:
            self._known[name] = look_through(self._entries[name], self._alone)[0]
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        """Yield the recordings' names."""
        return iter(self._entries)

    def __len__(self) -> int:
        """Return how many recordings there are."""
        return len(self._entries)
