"""Reading of a study: all of its errors are reported at once.

An entry with a pattern as its `file` becomes an entry for each file that matches.
"""

import math
import os
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from glob import glob
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ur5lib.channels import TORQUE
from ur5lib.errors import InputError, some
from ur5lib.robots.description import PROJECT_FOLDER, load_robot, robot_path
from ur5lib.stand import layout
from ur5lib.strict import FAST_DUMPER, expect_few_values, explain, quoted, read_yaml
from ur5lib.study.accept import joined
from ur5lib.study.model import PREVIOUS, Study
from ur5lib.study.succession import in_succession, wrong_succession

PlainData = Mapping[str, Any]  # a configuration, or a part of it, before it is validated
WILDCARD = re.compile(r"[*?\[]")
DAY_IN_PATH = re.compile(r"(?<!\d)(20\d\d)[-_]?(\d\d)[-_]?(\d\d)(?!\d)")
FORBIDDEN_CHARACTERS = re.compile(r"[^A-Za-z0-9_.-]+")
ENTRY_PLACE = re.compile(r"recordings\[\d+\]")  # start of a mistake's key
CODE_KEY = "__use_yte__"  # Snakemake runs code in a file with this key
TRUTH_SUFFIXES = (".parquet", ".json")
FILE_KEYS = {"folder", "file", "force_sensor", "imu", "truth", "home_deg", "directions"}


def read_study(path: Path) -> Study:
    """Read a study from its YAML file. Raises InputError with all its mistakes."""
    return parse_study(read_plain(path), str(path))


def read_plain(path: Path) -> PlainData:
    """Return a study as plain data. Raises InputError where the file has no YAML mapping."""
    try:
        raw = read_yaml(path)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); check its name and the current folder"
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
        place = f"{path}, line {mark.line + 1}" if mark else str(path)
        reason = problem or str(error)
        raise InputError(f"{place}: cannot be read as YAML ({reason}); correct it") from error
    if not isinstance(raw, dict):
        raise InputError(
            f"{path} is not a study: it needs `study`, `title` and `recordings`; of recordings, "
            "`ur5 import` writes one"
        )
    if CODE_KEY in raw:
        raise InputError(
            f"{path}: `{CODE_KEY}` tells Snakemake to run code that the file holds, but a study is "
            "data; remove the key, and write values instead of expressions"
        )
    return raw


def parse_study(raw: PlainData, source: str) -> Study:
    """Return the study that a configuration describes.

    raw: the configuration as plain data; source: its file, for the messages.
    Raises InputError with one line for each error found.
    """
    expect_few_values(raw, source)
    raw, stated = _with_each_file(raw)
    problems = [
        *_without_files(raw),
        *(fault for k, entry in _entries(raw) for fault in _faults(stated[k], entry, raw)),
        *_repeated_names(raw),
        *_repeated_files(raw),
        *_devices_on_two_hosts(raw),
        *_missing_results(raw),
        *_wrong_reference(raw.get("reference")),
    ]
    try:
        study = _with_arms(Study.model_validate(_with_files(raw)))
        if all(recording.robot for recording in study.recordings):
            problems += [*_different_arms(study), *_wrong_arms(study), *_misfits(study)]
            problems += wrong_succession(study)
    except ValidationError as error:
        schema = Study.model_json_schema()
        mistakes = (explain(_as_stated(detail, stated), schema) for detail in error.errors())
        problems = [*mistakes, *problems]
    if problems:
        raise InputError("\n".join(f"{source}: {problem}" for problem in _each_once(problems)))
    return study


def study_of_results(raw: PlainData, source: str) -> Study:
    """Return the study that a configuration of finished results describes; the recordings that it
    names may be gone.

    Arguments and errors: as of `parse_study`.
    """
    try:
        return _with_arms(Study.model_validate(_with_files(raw)))
    except ValidationError as error:
        schema = Study.model_json_schema()
        mistakes = (f"{source}: {explain(detail, schema)}" for detail in error.errors())
        raise InputError("\n".join(mistakes)) from error


def _each_once(problems: Iterable[str]) -> Iterator[str]:
    """Yield each mistake once, with the names of the other entries that have the same."""
    alike: dict[str, dict[str, str]] = {}
    for problem in problems:
        place, general = ENTRY_PLACE.search(problem), ENTRY_PLACE.sub("…", problem, count=1)
        alike.setdefault(general, {}).setdefault(place[0] if place else "", problem)
    for by_entry in alike.values():
        first, *others = by_entry
        yield f"{by_entry[first]}; the same in {some(others)}" if others else by_entry[first]


def is_pattern(entry: Any) -> bool:
    """Return whether the file of a recording's entry is a pattern, as in 2026-*/*.csv."""
    if not isinstance(entry, dict) or "simulate" in entry:
        return False
    file, folder = entry.get("file"), entry.get("folder")
    if not isinstance(file, str) or not isinstance(folder, str) or not WILDCARD.search(file):
        return False
    return not os.path.exists(Path(folder, file))


def of_each_file(entry: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield an entry for each file that the pattern of an entry matches, in the order of their
    paths.

    The path within the folder, without suffix, is added to the name. The date is the first in the
    path, as 2026-03-09, 2026_03_09 or 20260309, unless the entry has one.
    """
    folder = Path(entry["folder"])
    matches = (Path(file) for file in glob(entry["file"], root_dir=folder, recursive=True))
    may_be_folder = entry.get("format") == "rosbag"
    there = (file for file in matches if may_be_folder or (folder / file).is_file())
    for file in sorted(there):
        path_in_folder = FORBIDDEN_CHARACTERS.sub("-", str(file.with_suffix("")))
        day = DAY_IN_PATH.search(str(file))
        date = {"date": "-".join(day.groups())} if day else {}
        yield date | {**entry, "file": str(file), "name": f"{entry.get('name')}_{path_in_folder}"}


def _with_each_file(raw: PlainData) -> tuple[PlainData, list[int]]:
    """Return the configuration with an entry for each file that a pattern matches, and for each
    entry the index of the one in the file that it comes from.
    """
    recordings = raw.get("recordings")
    if not isinstance(recordings, list):
        return raw, []
    entries, places = [], []
    for k, entry in enumerate(recordings):
        expanded = ([*of_each_file(entry)] if is_pattern(entry) else []) or [entry]
        if is_pattern(entry) and entry.get("after") == PREVIOUS:
            expanded = in_succession(expanded)
        entries += expanded
        places += [k] * len(expanded)
    return {**raw, "recordings": entries}, places


def _as_stated(error: ErrorDetails, stated: list[int]) -> ErrorDetails:
    """Return an error of a recording's entry with the entry's index as in the file, before patterns
    were expanded; stated: that index for each entry.
    """
    key, *rest = error["loc"]
    if key == "recordings" and rest and isinstance(rest[0], int):
        error["loc"] = (key, stated[rest[0]], *rest[1:])
    return error


def _without_files(raw: PlainData) -> Iterator[str]:
    """Yield an error for each pattern that no file matches."""
    for _, entry in _entries(raw):
        if is_pattern(entry) and os.path.isdir(entry["folder"]):
            yield (
                f"recordings: no file in {entry['folder']} matches `file` {quoted(entry['file'])} "
                f"of {entry.get('name')}; correct the pattern, or add the recordings"
            )


def _entries(raw: PlainData) -> list[tuple[int, PlainData]]:
    """Return the recordings' entries that are mappings, each with its index."""
    entries = enumerate(_listed(raw, "recordings"))
    return [(k, entry) for k, entry in entries if isinstance(entry, dict)]


def _listed(raw: PlainData, key: str) -> list[Any]:
    """Return the value of a key of the configuration; [] if it is no list."""
    value = raw.get(key)
    return value if isinstance(value, list) else []


def _faults(stated: int, entry: PlainData, raw: PlainData) -> Iterator[str]:
    """Yield the errors of a recording's entry that its schema cannot show.

    stated: its index in the file.
    """
    place = f"recordings[{stated}]"
    folder = entry.get("folder")
    if "simulate" in entry:
        for key in sorted(entry.keys() & FILE_KEYS):
            yield f"`{place}.{key}` is of real files, but the entry has `simulate`; remove one"
    elif isinstance(folder, str) and not os.path.isdir(folder):
        missing = _topmost_missing(Path(folder))
        lies = "is" if missing == Path(folder) else "lies in"
        yield (
            f"`{place}.folder` {lies} {quoted(str(missing))}, which does not exist in "
            f"{Path.cwd()}; run in the study's folder, correct the path, or fetch the data "
            "(`ur5 fetch`)"
        )
    else:
        yield from _wrong_truth(place, folder, entry.get("truth"))
    if entry.get("robot") is None and raw.get("robot") is None:
        yield (
            f"`{place}.robot` is missing; name the arm there, or as `robot` of the study for all "
            "recordings"
        )
    if entry.get("gravity") is not None and entry.get("mounting") is not None:
        yield f"`{place}` has both `gravity` and `mounting`; remove one"
    if entry.get("untouched") is not None and entry.get("role") in ("fit", "validate"):
        yield (
            f"`{place}.untouched` is a span of a recording with the role contact; nothing touches "
            f"the arm in one with the role {entry['role']}; remove the key"
        )
    start, end = _extent(entry)
    if end <= start:
        yield f"`{place}.to_s` is {end:g}, not after `from_s`, {start:g}; correct one"


def _topmost_missing(folder: Path) -> Path:
    """Return the first folder on the path of a missing folder that does not exist."""
    missing = folder
    while missing.parent != missing and not os.path.isdir(missing.parent):
        missing = missing.parent
    return missing


def _wrong_truth(place: str, folder: Any, truth: Any) -> Iterator[str]:
    """Yield an error if a truth does not lie in its recording's folder."""
    if not isinstance(folder, str) or not isinstance(truth, str):
        return
    files = [os.path.join(folder, truth + suffix) for suffix in TRUTH_SUFFIXES]
    leaves = os.path.isabs(truth) or ".." in Path(truth).parts
    if leaves or not all(map(os.path.isfile, files)):
        yield (
            f"`{place}.truth` is {quoted(truth)}; give the path within the recording's folder of "
            f"a file {' and a file '.join(TRUTH_SUFFIXES)}, without these suffixes"
        )


def _missing_results(raw: PlainData) -> Iterator[str]:
    for name in _listed(raw, "compare_with"):
        if name == raw.get("study"):
            yield f"`compare_with` names {quoted(name)}, this study itself; name another"
        elif isinstance(name, str) and not os.path.isdir(Path("results", name, "tables")):
            yield (
                f"`compare_with` names {quoted(name)}, but results/{name} holds no results; "
                "build that study first by `ur5 run`"
            )


def _wrong_reference(file: Any) -> Iterator[str]:
    """Yield an error if a file of published values is no YAML mapping."""
    if isinstance(file, str) and os.path.isfile(file):
        try:
            read_plain(Path(file))
        except InputError:
            yield f"`reference`: {file} does not hold published values; name another file"


def _with_files(raw: PlainData) -> PlainData:
    """Return the configuration with the files that the test stand will write in the entries of
    simulated recordings.
    """
    entries = [*_listed(raw, "recordings")]
    for k, entry in _entries(raw):
        if isinstance(plan := entry.get("simulate"), dict):
            files: dict[str, object] = {"folder": f"raw/{raw.get('study')}/{entry.get('name')}"}
            if entry.get("format") in layout.FORMATS:
                sensors = [name for name in layout.SENSOR_COLUMNS if plan.get(name) is not None]
                files |= layout.device_keys(entry["format"], sensors)
            entries[k] = {**entry, **files}
    return {**raw, "recordings": entries} if entries else raw


def _with_arms(study: Study) -> Study:
    """Return the study with its own arm and reasons to overrule stop signs in each recording that
    has none.
    """
    recordings = [
        recording.model_copy(
            update={
                "robot": recording.robot or study.robot,
                "accept": joined(study.accept, recording.accept),
            }
        )
        for recording in study.recordings
    ]
    return study.model_copy(update={"recordings": recordings})


def study_text(study: Study) -> str:
    """Return a study with every default filled in, as YAML that `parse_study` reads."""
    plain = study.model_dump(exclude_none=True)
    for recording in plain["recordings"]:
        if "simulate" in recording:  # the test stand names its files
            for key in FILE_KEYS & recording.keys():
                del recording[key]
    return yaml.dump(plain, Dumper=FAST_DUMPER, sort_keys=False, allow_unicode=True)


def _different_arms(study: Study) -> Iterator[str]:
    """Yield errors for different arms with one name: their recordings would be fitted together."""
    arms = study.arms()
    for recording in study.recordings:
        if recording.arm.itself() != arms[recording.arm.known_as]:
            yield (
                f"recordings: the arm of {recording.name} differs from another called "
                f"{recording.arm.known_as}; give each its own `name`, or move it to `robot` of the "
                "study"
            )


def _wrong_arms(study: Study) -> Iterator[str]:
    """Yield errors of the user's own arms, with overridden numbers or a calibration."""
    for arm in study.arms().values():
        own = robot_path(arm.arm).parent == PROJECT_FOLDER
        if own or arm.override or arm.calibration:
            try:
                arm.description()
            except InputError as error:
                yield str(error)


def _misfits(study: Study) -> Iterator[str]:
    """Yield errors for simulated recordings with a plan that does not fit their arm."""
    described = cache(load_robot)
    for recording in study.recordings:
        if (plan := getattr(recording, "simulate", None)) is None:
            continue
        try:
            robot = described(robot_path(recording.arm.arm))
        except InputError as error:
            yield str(error)
            continue
        place = f"`recordings.{recording.name}"
        misfits = plan.misfits(recording.arm.known_as, len(robot.joints), robot.models)
        yield from (f"{place}.simulate.{misfit}" for misfit in misfits)
        of_ur = recording.format in layout.FORMATS_OF_UR
        if of_ur and (len(robot.joints) != 6 or robot.measured == TORQUE):
            yield f"{place}.format` is {recording.format}, of UR arms alone; give rtde-csv"


def _repeated_names(raw: PlainData) -> Iterator[str]:
    names = Counter(str(entry["name"]) for _, entry in _entries(raw) if "name" in entry)
    for name in sorted(name for name, count in names.items() if count > 1):
        yield f"recordings: {name!r} is used twice as a name; give each recording its own"


def _repeated_files(raw: PlainData) -> Iterator[str]:
    """Yield errors for recordings that share frames of one arm: validation on fitted data proves
    nothing.
    """
    files = defaultdict(list)
    for _, entry in _entries(raw):
        if isinstance(folder := entry.get("folder"), str):
            path = str(Path(folder, str(entry.get("file", ""))))
            files[path, _positions(entry)].append(entry)
    for (path, _), entries in sorted(files.items()):
        extents = sorted(map(_extent, entries))
        if any(end > start for (_, end), (start, _) in pairwise(extents)):
            names = " and ".join(str(entry.get("name")) for entry in entries)
            yield (
                f"recordings: {names} use the same {path}; give each its own file, or its own part "
                "of it by `from_s` and `to_s`"
            )


def _positions(entry: PlainData) -> str:
    """Return what an entry reads as positions, by which two arms in one file differ."""
    columns, channels = entry.get("columns"), entry.get("channels")
    if isinstance(channels, dict):
        return str(channels.get("actual_q", ""))
    of_joints = (str(name).startswith("actual_q") for name in columns or ())
    return str([*of_joints]) if isinstance(columns, list) else ""


def _extent(entry: PlainData) -> tuple[float, float]:
    """Return start and end [s] of the part of a file that an entry uses."""
    start, end = entry.get("from_s"), entry.get("to_s")
    return (
        float(start) if isinstance(start, int | float) else 0.0,
        float(end) if isinstance(end, int | float) else math.inf,
    )


def _devices_on_two_hosts(raw: PlainData) -> Iterator[str]:
    hosts = raw.get("hosts")
    lists = hosts.values() if isinstance(hosts, dict) else []
    named = [device for devices in lists if isinstance(devices, list) for device in devices]
    for device in sorted({str(device) for device in named if named.count(device) > 1}):
        yield f"hosts: {device} is listed twice; list it under the host that timestamps its samples"
