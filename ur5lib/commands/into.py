"""Copies of recordings with the contact force in each row, one after the other (`--into`)."""

import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5lib import __version__
from ur5lib.chain.model import Model, fit, load_model
from ur5lib.chain.recordings import Arm, Recordings
from ur5lib.chain.shown import bar, counted
from ur5lib.chain.steps import Files
from ur5lib.commands.added import FRAME, QUALITY_OF, UNKNOWN, Added, described, offline
from ur5lib.commands.copies import WRITERS, ending_of, write_copy
from ur5lib.errors import InputError, fault_of_ours, some, unknown
from ur5lib.finished import StudyFiles
from ur5lib.jobs.memory import record_of
from ur5lib.recordings.bag_files import ENDINGS_IN_FOLDER
from ur5lib.recordings.file_rows import samples_of_rows
from ur5lib.records.forces import Forces
from ur5lib.records.prediction import Prediction, held_throughout
from ur5lib.records.quality import Quality
from ur5lib.study.address import is_study, results_folder
from ur5lib.study.model import Recording
from ur5lib.study.turn import reserved
from ur5lib.tables import write_json
from ur5lib.workspace.topics import modules_of_topics

LAST = "the file before"  # name of the recording that one follows, in `after` of its entry
ABOUT_FILE = "ur5lib.json"  # in the folder of copies
STEPS = ("estimate_load", "predict_currents", "estimate_forces")
NO_FORCE = (
    "it has no efforts, no half second without a gap, or steps longer than those of the fit; or, "
    "without a fit, a hand leads the arm"
)
MOST_TRIED = 10  # files, until one can be read
Read = Callable[[Path], Recordings]


class Readers(NamedTuple):
    """How recordings are read: of several files with a role; an arm by its name; and the reader of
    many files of an arm, some of which have entries.
    """

    read: Callable[[Sequence[Path], Arm, Any], Recordings]
    arm: Callable[[str], Arm]
    of_episodes: Callable[[Arm, Sequence[Recording]], Read]


def copies_into(
    into: Path,
    named: Sequence[str],
    robot: str | None,
    patterns: Sequence[str],
    accept: Sequence[str],
    resume: bool,
    readers: Readers,
) -> Iterator[str]:
    """Copy recordings with the force in each row, and yield lines on what was made.

    named: a study, or the file of a model, and then files and folders; or these alone, with the
    robot's name, and patterns of those that nothing touches, for a fit; accept: `kind=reason`s for
    which stop signs are overruled. Raises InputError for what cannot be read, at the end where
    others could.
    """
    first, *others = named
    by_study = is_fit(first)
    files = [*map(Path, others if by_study else named)]
    if not files:
        raise InputError(f"{first}: name the files or folders to copy behind it")
    if by_study and patterns:
        raise InputError("--fit names files to fit to in place of a study; leave one of them out")
    if not by_study and robot is None:
        raise InputError(f"{first} is no study: name one before it, or the arm by --robot")
    targets, reasons = episodes_in(files, into), reasons_of(accept)
    given = (
        with_topics(*model_of(first, robot))
        if by_study
        else own_fit(str(robot), [*targets], patterns, reasons, readers)
    )
    given = replace(given, accepted=reasons)
    read = readers.of_episodes(readers.arm(given.model.robot), given.entries)
    yield from copied(targets, into, given, read, resume)


def reasons_of(accept: Sequence[str]) -> dict[str, str]:
    """Return the reasons by kind. Raises InputError for one that is no `kind=reason`."""
    pairs = [one.partition("=") for one in accept]
    if bare := [kind for kind, _, why in pairs if not why.strip()]:
        raise InputError(f'--accept {some(bare)}: write a kind and why, as constants="calibrated"')
    return {kind: why for kind, _, why in pairs}


def is_fit(address: str) -> bool:
    """Return whether an address is that of a study or of a model's file, and not of recordings."""
    path = Path(address)
    if path.is_dir():
        return (path / "configuration.yaml").is_file()
    if path.suffix and path.suffix.lower() in WRITERS:
        return False
    return path.suffix == ".json" or is_study(address)


@dataclass(frozen=True)
class Fit:
    """What forces are estimated with: a model, with the results of steps that topics added.

    by: what it was fitted to, in words; entries: of files as its study has them; causal: modules of
    topics with further estimates; accepted: reasons to overrule stop signs, by their kind.
    """

    model: Model
    by: str
    entries: Sequence[Recording] = ()
    causal: Sequence[Any] = ()
    accepted: Mapping[str, str] = field(default_factory=dict)

    @property
    def about(self) -> dict[str, str]:
        """Return what the estimates are, for a file's attributes."""
        told = {"study": self.by, "robot": self.model.robot, "frame": FRAME}
        accepted = {f"accepted {kind}": why for kind, why in self.accepted.items()}
        return told | {"version": __version__} | accepted


def model_of(address: str, robot: str | None) -> tuple[Model, str, Sequence[Recording]]:
    """Return the model of a study, or of a file that `Model.save` wrote, what it is in words, and
    the study's entries.

    Raises InputError where a study has several arms and none is named.
    """
    if address.endswith(".json"):
        return load_model(address), f"model {Path(address).name}", ()
    study = StudyFiles(results_folder(address))
    arms = sorted({one.arm.known_as for one in study.configuration().recordings})
    if robot is None and len(arms) > 1:
        raise InputError(f"{address} has the arms {', '.join(arms)}; name one by --robot")
    name = robot or arms[0]
    if name not in arms:
        raise unknown("arm", name, arms)
    entries = [one for one in study.configuration().recordings if one.arm.known_as == name]
    return study.model(name), study.folder.name, entries


def with_topics(model: Model, by: str, entries: Sequence[Recording] = ()) -> Fit:
    """Return a fit with the estimates that topics add to those of the chain."""
    files, causal = dict(model._arm), []
    for topic in modules_of_topics("copies").values():
        if known := topic.known(model):
            files |= known
            causal.append(topic)
    whole = Model._of(model._settings, model.robot, files, model._fitted)
    whole._source = model._source
    return Fit(whole, by, entries, causal)


def own_fit(
    robot: str,
    files: Sequence[Path],
    patterns: Sequence[str],
    accept: Mapping[str, str],
    readers: Readers,
) -> Fit:
    """Return the fit to those of some files that match patterns; without patterns, none.

    Raises InputError where none matches, or none can be read.
    """
    arm = readers.arm(robot)
    if not patterns:
        model = fit(_first_readable(files, readers.of_episodes(arm, ())), accept)
        taken = model._friction.fit.joints
        return with_topics(model, f"no fit: {'friction of other arms' if taken else 'arm at rest'}")
    named = [
        own
        for own in files
        if any(fnmatch(str(own), one) or fnmatch(own.name, one) for one in patterns)
    ]
    if not named:
        raise InputError(f"--fit {some(patterns)}: none of {counted(len(files), 'file')} matches")
    runs = readers.read(named, arm, "fit")
    return with_topics(fit(runs, accept), f"fit to {some(runs.names, 4)}", runs._study.recordings)


def _first_readable(files: Sequence[Path], read: Read) -> Recordings:
    for own in files[:MOST_TRIED]:
        with suppress(InputError):
            return read(own)
    return read(files[0])


def episodes_in(paths: Sequence[Path], into: Path) -> dict[Path, Path]:
    """Return by file, or bag's folder, where its copy goes: those of a folder keep their place.

    Raises InputError where two would have one place, or a copy that of its original.
    """
    found = [pair for path in paths for pair in _below(path, into)]
    targets = {own: into / place for own, place in found}
    taken = dict[Path, Path]()
    for own, target in targets.items():
        if (other := taken.setdefault(target, own)) != own:
            raise InputError(f"{other} and {own} have one name; copy them one after the other")
        if target.exists() and target.samefile(own):
            raise InputError(f"{own} would be replaced by its copy; name another folder by --into")
    if not found:
        raise InputError(f"{some([*map(str, paths)])}: no recording is there")
    return targets


def _below(path: Path, into: Path) -> Iterator[tuple[Path, Path]]:
    """Yield each recording of a path, and its place below that."""
    if not path.exists():
        raise InputError(f"{path} does not exist; check its name")
    if not path.is_dir() or _is_bag(path):
        if ending_of(path) not in WRITERS:
            endings = ", ".join(filter(None, WRITERS))
            raise InputError(f"{path}: copies are made of {endings} and folders with a bag")
        yield path, Path(path.name)
        return
    for own in sorted(path.iterdir()):
        if own.name.startswith(".") or own.resolve() == into.resolve():
            continue
        if own.is_dir():
            yield from ((one, own.name / place) for one, place in _below(own, into))
        elif ending_of(own) in WRITERS:
            yield own, Path(own.name)


def _is_bag(folder: Path) -> bool:
    """Return whether a folder is one recording: a bag with its description, or without."""
    names = [one.name for one in folder.iterdir()]
    bags = [name for name in names if name.endswith(ENDINGS_IN_FOLDER)]
    return "metadata.yaml" in names or (len(bags) == 1 and len(names) == 1 and "db3" in bags[0])


def copied(
    targets: Mapping[Path, Path], into: Path, given: Fit, read: Read, resume: bool
) -> Iterator[str]:
    """Write the copies, and yield lines on what was made.

    resume: leave copies as they are that are there. Raises InputError at the end, with the reasons,
    for files that were left out; and at once where copies are there, or are of another fit.
    """
    with reserved(into):
        if resume:
            _clear(into)
        there = {own for own, target in targets.items() if target.exists()}
        if there and not resume:
            raise InputError(
                f"{targets[min(there)]} exists; go on with --resume, or name another folder"
            )
        _expect_same(into, given)
        copier, left, columns = Copier(given, read), dict[Path, str](), dict[str, Any]()
        with bar(len(targets) - len(there)) as advance:
            for own in (one for one in targets if one not in there):
                advance(own.name)
                try:
                    columns |= copier.copy(own, targets[own])
                except InputError as error:
                    left[own] = str(error)
                except Exception as error:  # so that the others are made
                    left[own] = f"{own}: {fault_of_ours(error)}"
                if columns and not (into / ABOUT_FILE).exists():
                    write_json(given.about | {"columns": columns}, into / ABOUT_FILE)
        made = len(targets) - len(there) - len(left)
        before = f", {len(there)} were there" if there else ""
        yield f"{into}: {made} {'copy' if made == 1 else 'copies'}{before}"
        yield f"forces by {given.by}"
        if left:
            lines = [f"left out: {len(left)}", *left.values()]
            raise InputError("\n".join(lines))


def _clear(into: Path) -> None:
    """Remove what a killed process left: nobody else writes there."""
    for part in into.rglob(".*.part*"):
        shutil.rmtree(part) if part.is_dir() else part.unlink()


def _expect_same(into: Path, given: Fit) -> None:
    """Raise InputError where the copies that are there are by another fit or version."""
    file = into / ABOUT_FILE
    if not file.exists():
        return
    before = json.loads(file.read_text(encoding="utf-8"))
    for name, own in given.about.items():
        if before.get(name) != own:
            raise InputError(
                f"{into} has copies with the {name} {before.get(name)!r}, now it is {own!r}; name "
                "another folder"
            )


class Copier:
    """Writes copies of files, one after the other: one may follow directly on the last one."""

    def __init__(self, given: Fit, read: Read) -> None:
        self.given, self.read = given, read
        self._last = dict[str, Files]()

    def copy(self, own: Path, target: Path) -> dict[str, Any]:
        """Write the copy of one file, and return the columns that were added.

        Raises InputError where it cannot be read, or no force is stated.
        """
        last, self._last = self._last, {}
        runs = self.read(own)
        entries = {one.name: one for one in runs._study.recordings}
        steps = *STEPS, *(one.STEP for one in self.given.causal)
        found = self.given.model._run(runs, self.given.accepted, *steps, before=last)
        parts = [on_rows(entries[name], files, self.given) for name, files in found.items()]
        told = [load for files in found.values() if (load := taken_load(files))]
        remarks = {"remarks": "; ".join(told)} if told else {}
        first = next(iter(entries.values()))
        added = merged(parts, first.path)
        write_copy(first, target, added, self.given.about | remarks)
        self._last = {LAST: {"motion": next(reversed(found.values()))["motion"]}}
        return described(added)


def taken_load(files: Files) -> str:
    """Return in words the load that was held throughout a recording and taken off, "" for none."""
    load = record_of(Prediction, files["prediction"]).load
    taken = load is not None and load.taken
    return f"{held_throughout(load)}; what presses for as long looks alike" if taken else ""


def on_rows(recording: Recording, files: Files, given: Fit) -> list[Added]:
    """Return what is added to the rows of a recording's file.

    files: of the recording after STEPS. Raises InputError where no force is stated.
    """
    thresholds = record_of(dict[str, float], given.model._arm["threshold"])
    added = [*offline(files, thresholds)]
    if not added:
        friction = given.model._friction
        refused = friction.stopped or friction.refused
        why = refused.sentence() if refused else NO_FORCE
        raise InputError(f"{recording.path}: no force is stated: {why}")
    added += chain.from_iterable(topic.channels(files) for topic in given.causal)
    time, quality = record_of(Forces, files["forces"]).time, record_of(Quality, files["quality"])
    max_gap = given.model._settings.frames.max_gap_s
    samples = samples_of_rows(recording, time, quality.period_s, max_gap)
    return [one.on(samples) for one in added]


def merged(parts: Sequence[Sequence[Added]], path: Path) -> list[Added]:
    """Return what is added to a file with one or several recordings, each with rows of its own.

    Raises InputError where two have the same rows, as of two arms.
    """
    names = [[one.name for one in part] for part in parts]
    if any(own != names[0] for own in names):
        raise InputError(f"{path}: not all of its recordings have the same estimates")
    whole = [replace(one, values=one.values.copy()) for one in parts[0]]
    for part in parts[1:]:
        mine, its = (_known(of) for of in (whole, part))
        if (mine & its).any():
            raise InputError(f"{path}: has several arms; give each a file of its own")
        for one, other in zip(whole, part, strict=True):
            one.values[its] = other.values[its]
    return whole


def _known(added: Sequence[Added]) -> np.ndarray:
    """Return in which rows (N,) any estimate states something."""
    qualities = [one.values != UNKNOWN for one in added if one.name.startswith(QUALITY_OF)]
    return np.any(qualities, axis=0)
