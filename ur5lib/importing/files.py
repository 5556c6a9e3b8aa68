"""Import of recordings: each file is analysed, read back through its entry, and checked."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from ur5lib.commands.check import look_through, severe
from ur5lib.errors import InputError, printable
from ur5lib.importing.blocks import NAMELESS_PREFIX
from ur5lib.importing.contents import NO_STATEMENT, FileContents, UserStatement, contents
from ur5lib.importing.entry import StudyEntry, entry_of, identifier, place_of_file
from ur5lib.importing.identity import UNDESCRIBED_ARM
from ur5lib.importing.proposal import propose
from ur5lib.recordings.entries import SKIPPED_COLUMN
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_text

YAML_WIDTH = 100  # characters a line of YAML


@dataclass(frozen=True)
class ImportedRecording:
    """A recording's entry in a study, and the evidence for it as comments."""

    entry: StudyEntry
    comments: list[str]

    @property
    def arm(self) -> str:
        """Return the arm that it is of."""
        return str(self.entry["robot"])


class ImportedFiles(list[ImportedRecording]):
    """The files that were imported; refused: the reasons why the others were not."""

    refused: tuple[str, ...] = ()


def import_files(paths: Iterable[Path], stated: UserStatement = NO_STATEMENT) -> ImportedFiles:
    """Return the entries of recordings, each read back and checked; stated: by the user.

    Raises InputError, with all reasons, where no file can be read and has positions.
    """
    imported: dict[Path, ImportedRecording] = {}
    refused: dict[Path, str] = {}
    headers: dict[Path, list[str]] = {}
    for path in paths:
        try:
            file = contents(path, stated)
            headers[path] = file.header.columns
            imported[path] = _checked(file)
        except InputError as error:
            refused[path] = str(error)
    for path, columns in headers.items():
        if columns[:1] == [f"{NAMELESS_PREFIX}1"]:
            alike = [
                recording for other, recording in imported.items() if headers[other] == columns
            ]
            _take_columns(path, alike, imported)
    files = ImportedFiles(imported[path] for path in headers if path in imported)
    files.refused = tuple(reason for path, reason in refused.items() if path not in imported)
    if files.refused and not files:
        raise InputError("\n".join(files.refused))
    _name_each_once(files)
    return files


def _take_columns(
    path: Path, alike: Sequence[ImportedRecording], imported: dict[Path, ImportedRecording]
) -> None:
    """Read a file without names like the one of as many columns of which most are named."""
    other, present = min(alike, key=_skipped, default=None), imported.get(path)
    if other is None or (
        present and (present.arm != other.arm or _skipped(present) <= _skipped(other))
    ):
        return
    source = Path(other.entry["folder"], other.entry["file"])
    assumed = f"# assumed: columns, units and robot as in {source}, which has as many columns"
    checks = [line for line in other.comments if line.startswith("# check")]
    role = {"role": present.entry["role"]} if present else {}
    imported[path] = ImportedRecording(other.entry | place_of_file(path) | role, [*checks, assumed])


def _checked(file: FileContents) -> ImportedRecording:
    """Return the entry of a file, with the stop signs of a recording that is read through it."""
    proposal = propose(file)
    entry, comments = entry_of(proposal), proposal.contents.evidence.lines()
    if proposal.arm == UNDESCRIBED_ARM:
        return ImportedRecording(entry, comments)
    complaints = contradictions(entry)
    as_validate = entry | {"role": "validate"}
    if complaints and entry["role"] == "fit" and not contradictions(as_validate):
        further = [line for line in comments if not line.startswith("# assumed: role")]
        return ImportedRecording(
            as_validate, [*further, f"# assumed: role validate, as {complaints[0]}"]
        )
    return ImportedRecording(
        entry, [*(f"# check: {complaint}" for complaint in complaints), *comments]
    )


def contradictions(recording: StudyEntry) -> list[str]:
    """Return the stop signs and errors of a recording that is read through an entry."""
    plain = {"study": "import", "title": "Import", "recordings": [recording]}
    try:
        study = parse_study(plain, "the entry")
        quality, _ = look_through(study.recordings[0], study)
    except InputError as error:
        return [str(error)]
    return severe(quality)


def _skipped(recording: ImportedRecording) -> int:
    """Return how many columns an entry skips."""
    return list(recording.entry.get("columns", [])).count(SKIPPED_COLUMN)


def _name_each_once(imported: Sequence[ImportedRecording]) -> None:
    names = set[str]()
    for number, recording in enumerate(imported, 1):
        if recording.entry["name"] in names:
            recording.entry["name"] += f"_{number}"
        names.add(recording.entry["name"])


def as_entries(imported: Sequence[ImportedRecording]) -> str:
    """Return entries as YAML with comments, to be pasted below `recordings:` of a study."""
    parts = []
    for item in imported:
        text = yaml.safe_dump([item.entry], sort_keys=False, width=YAML_WIDTH, allow_unicode=True)
        parts.append("".join(f"{printable(line)}\n" for line in item.comments) + text)
    return "\n".join(parts)


def write_study(imported: Sequence[ImportedRecording], path: Path) -> None:
    """Write a study of recordings. Raises InputError where the file exists already."""
    if path.exists():
        raise InputError(f"{path} exists; name another file, or add the entries with --add")
    name = identifier(path.stem)
    plain = {"study": name, "title": f"Recordings of {name}"}
    head = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    write_text(f"{head}recordings:\n{as_entries(imported)}", path)


def add_to_study(imported: Sequence[ImportedRecording], path: Path) -> None:
    """Append the entries of recordings to a study that ends with its recordings.

    Raises InputError where the study would not hold its own recordings and these, or one twice.
    """
    before = path.read_text(encoding="utf-8").rstrip() + "\n"
    plain = yaml.safe_load(before)
    names = {recording["name"] for recording in plain.get("recordings") or []}
    if twice := sorted(names & {recording.entry["name"] for recording in imported}):
        raise InputError(f"{path} has a recording {twice[0]} already; rename it there, or the file")
    for indent in ("", "  "):
        lines = "".join(f"{indent}{line}\n" for line in as_entries(imported).splitlines())
        try:
            joined = yaml.safe_load(before + lines)
        except yaml.YAMLError:
            continue
        if len(joined.get("recordings") or []) == len(names) + len(imported):
            parse_study(joined, str(path))
            write_text(before + lines, path)
            return
    raise InputError(f"{path} does not end with its recordings; paste the entries below them")
