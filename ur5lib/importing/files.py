"""Import of recordings: each file is analysed, read back through its entry, and checked."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any

import yaml
from rich.table import Table

from ur5lib.commands.check import look_through, severe
from ur5lib.errors import InputError, fault_of_ours
from ur5lib.importing.after import Ends, ends_of, links
from ur5lib.importing.alike import form_of, precedents, unlike
from ur5lib.importing.blocks import NAMELESS_PREFIX
from ur5lib.importing.contents import (
    NO_STATEMENT,
    FileContents,
    UserStatement,
    arm_labels,
    contents,
)
from ur5lib.importing.coupled_axes import are_coupled
from ur5lib.importing.doubts import with_remedy
from ur5lib.importing.efforts import EFFORT_MEANINGS
from ur5lib.importing.entry import StudyEntry, entry_of, episodes, identifier, place_of_file
from ur5lib.importing.form_of_file import FormOfFile
from ur5lib.importing.identity import ORDER, UNDESCRIBED_ARM
from ur5lib.importing.parted_runs import PartedRun
from ur5lib.importing.proposal import Proposal, meanings, propose
from ur5lib.importing.spellings import CLOCK_NAME
from ur5lib.importing.two_files import joined, sensor_in
from ur5lib.recordings.entries import SKIPPED_COLUMN, UNKNOWN
from ur5lib.records.account import NOTHING, AccountRow
from ur5lib.study.reading import parse_study
from ur5lib.study.turn import reserved
from ur5lib.tables import write_new_text, write_text

CONFIDENCE_STYLES = {"check": "yellow", "left out": "dim", "evidence": "dim"}
TO_BE_CORRECTED = "to be corrected"  # what a recording with a stop sign is taken for
WITH_SENSORS = ("rtde-csv", "table-csv")  # formats with a file of the sensor beside
YAML_WIDTH = 100  # characters a line of YAML


@dataclass(frozen=True)
class ImportedRecording:
    """A recording's entry in a study, and its account: what each column was taken for.

    ends: its first and last posture, None if unknown.
    """

    entry: StudyEntry
    account: list[AccountRow]
    ends: Ends | None = None

    def as_plain(self) -> StudyEntry:
        """Return the entry with its account, to be written as YAML."""
        return self.entry | {"account": [_Row(asdict(row)) for row in self.account]}

    @property
    def arm(self) -> str:
        """Return the name of the recording's arm."""
        return str(self.entry["robot"])


class ImportedFiles(list[ImportedRecording]):
    """The imported recordings; refused: for each other file, why it was not imported."""

    refused: tuple[str, ...] = ()
    parts: tuple["ReadPart", ...] = ()


def import_files(
    paths: Iterable[Path | PartedRun],
    stated: UserStatement = NO_STATEMENT,
    like: Sequence["ReadPart"] = (),
) -> ImportedFiles:
    """Return the entries of recordings, each read back and checked.

    stated: by the user; like: files that were read before, whose form is that of these. Raises
    InputError, with all reasons, where no file is readable and has positions.
    """
    parts = [part for path in paths for part in _parts(path, stated)]
    every = [*parts, *like]
    forms = {k: part.form for k, part in enumerate(every) if part.form}
    for k, precedent in precedents(forms):
        if k < len(parts):
            parts[k].propose_like(precedent, stated)
    for part in parts:
        if given := [
            one for other in like if other.layout == part.layout for one in other.imported
        ]:
            _take_columns(part, given, at_any_rate=True)
        elif not part.imported or part.layout[2:3] == [f"{NAMELESS_PREFIX}1"]:
            same = (other.imported for other in every if other.layout == part.layout)
            _take_columns(part, [*chain.from_iterable(same)])
    _join_sensors(parts, stated)
    _name_arms(parts)
    files = ImportedFiles(chain.from_iterable(part.imported for part in parts))
    files.parts = tuple(part for part in parts if part.imported)
    files.refused = tuple(part.refused for part in parts if part.refused and not part.imported)
    if files.refused and not files:
        raise InputError("\n".join(files.refused))
    _name_each_once(files)
    _name_the_one_before(files)
    for one in files:
        one.account[:] = map(with_remedy, one.account)
    return files


@dataclass
class ReadPart:
    """A file, or one of several arms in it, and the result of its import.

    label: of that arm; layout: label, format and columns; form: how it was read; refused: why it
    was not imported.
    """

    file: Path | PartedRun
    label: str = ""
    layout: list[str] = field(default_factory=list)
    imported: list[ImportedRecording] = field(default_factory=list)
    form: FormOfFile | None = None
    refused: str = ""

    def propose(
        self,
        stated: UserStatement,
        precedent: FormOfFile | None = None,
        known: FileContents | None = None,
    ) -> None:
        """Import the file, like a precedent if one is given; known: the file's contents if already
        read.
        """
        stated = replace(stated, prefix=self.label) if self.label else stated
        try:
            file = replace(known or contents(self.file, stated), precedent=precedent)
            self.layout = [self.label, file.format, *file.account.order]
            self.imported, self.form = _checked(_proposed(self.file, file))
        except InputError as error:
            self.refused = f"arm {self.label} of {error}" if self.label else str(error)
        except Exception as error:  # so that the other files are imported
            self.refused = f"{self.file}: {fault_of_ours(error)}"

    def propose_like(self, precedent: FormOfFile, stated: UserStatement) -> None:
        """Import the file like a precedent, unless that brings a stop sign."""
        alone, form = self.imported, self.form
        self.propose(stated, precedent)
        if _is_stopped(self.imported) and not _is_stopped(alone):
            self.imported, self.form = alone, form


def _is_stopped(imported: Iterable[ImportedRecording]) -> bool:
    return any(row.taken_for == TO_BE_CORRECTED for one in imported for row in one.account)


def _parts(path: Path | PartedRun, stated: UserStatement) -> list[ReadPart]:
    """Return the imported file as one part, or a part for each of the arms in it."""
    try:
        file = contents(path, stated)
    except InputError as error:
        return [ReadPart(path, refused=str(error))]
    except Exception as error:  # so that the other files are imported
        return [ReadPart(path, refused=f"{path}: {fault_of_ours(error)}")]
    chosen = stated.prefix or stated.joint_names or stated.columns
    labels = [] if chosen else arm_labels(file)
    parts = [ReadPart(path, label) for label in labels] or [ReadPart(path)]
    for part in parts:
        part.propose(stated, known=None if labels else file)
    return parts


def _join_sensors(parts: list[ReadPart], stated: UserStatement) -> None:
    """Add the files of a force sensor to the entry whose efforts follow the force; of several
    entries, to the one that follows it best.
    """
    alone = [part for part in parts if not part.imported]
    alone += [ReadPart(stated.sensor)] if stated.sensor else []
    robots = [one for part in parts for one in part.imported if one.entry["format"] in WITH_SENSORS]
    for part in alone:
        sensor = sensor_in(part.file, stated) if isinstance(part.file, Path) else None
        found = [(joined(one.entry, sensor), one) for one in robots] if sensor else []
        matches = [(match, one) for match, one in found if match is not None]
        if matches:
            (_, added, row), one = max(matches, key=lambda pair: pair[0][0])
            one.entry.update(added)
            told = [own for own in one.account if own.subject != "role" or "role" not in added]
            one.account[:] = [row, *told]
            part.refused = ""
        elif sensor:
            part.refused = (
                f"{part.file}: has a force and no positions, and the efforts of no robot's file "
                "follow it; name the robot's file beside it, or write it as `force_sensor` of its "
                "entry, with `offset_s`"
            )
    if stated.sensor and not any("force_sensor" in one.entry for one in robots):
        raise InputError(alone[-1].refused or f"{stated.sensor}: has no force and clock in columns")


def _name_arms(parts: Sequence[ReadPart]) -> None:
    """Append the arms' labels to the names of entries from one file; if one of its arms is refused,
    a row in the others' accounts says why.
    """
    for part in (part for part in parts if part.label):
        beside = [one for other in parts if other.file == part.file for one in other.imported]
        for one in part.imported:
            one.entry["name"] += f"_{identifier(part.label)}"
        for one in beside if not part.imported else ():
            one.account.insert(0, AccountRow(part.label, NOTHING, "numbers", "check", part.refused))
        part.refused = "" if beside else part.refused


def _take_columns(
    part: ReadPart, alike: Sequence[ImportedRecording], at_any_rate: bool = False
) -> None:
    """Read a file that is refused, or without column names, like the file of the same form with the
    fewest skipped columns, if that skips fewer, or at_any_rate.
    """
    other, present = min(alike, key=_skipped, default=None), next(iter(part.imported), None)
    if (
        not isinstance(part.file, Path)
        or other is None
        or (
            present
            and not at_any_rate
            and (present.arm != other.arm or _skipped(present) <= _skipped(other))
        )
    ):
        return
    source = Path(other.entry["folder"], other.entry["file"])
    reason = "columns, units and robot are those of that file, which has the same form"
    as_there = AccountRow("columns", f"as in {source}", "position", "assumed", reason)
    shows_role = present or other
    checks = [row for row in other.account if row.confidence == "check" and row.subject != "role"]
    role = [row for row in shows_role.account if row.subject == "role"]
    entry = other.entry | place_of_file(part.file) | {"role": shows_role.entry["role"]}
    stops = _to_be_corrected(contradictions(entry))
    part.imported = [ImportedRecording(entry, [*stops, *checks, as_there, *role])]


def _proposed(path: Path | PartedRun, file: FileContents) -> Proposal:
    """Return the proposal for a file. If no positions are found since a column was taken for the
    clock by its place, the file is read without a clock.

    Raises InputError where neither way shows positions.
    """
    try:
        return propose(file)
    except InputError as error:
        if not file.has_clock() or any(map(CLOCK_NAME.search, file.clocks.stamps)):
            raise
        untimed, column = contents(path, file.stated, timed=False), next(iter(file.clocks.stamps))
        with suppress(InputError):
            proposal = propose(untimed)
            rising = f"{column} rises like one, but it belongs to the columns behind it"
            untimed.account.tell("assumed", "clock", "none", "numbers", rising)
            return proposal
        raise error


def _checked(proposal: Proposal) -> tuple[list[ImportedRecording], FormOfFile]:
    """Return the recordings of a file, one or one per episode, with the stop signs of the first in
    their account; and how the file was read.
    """
    if proposal.arm != UNDESCRIBED_ARM and are_coupled(proposal.moving, proposal.arm):
        _leave_efforts_out(proposal)
    entry, account = entry_of(proposal), proposal.contents.account.rows(meanings(proposal))
    account.sort(key=lambda row: f"[{UNKNOWN}]" not in row.taken_for)  # which forbids all forces
    first, *others = [entry | part for part in episodes(proposal)] or [entry]
    if proposal.arm != UNDESCRIBED_ARM:
        complaints, by_role = contradictions(first), entry["role"] == "fit"
        if complaints and by_role and not contradictions(first | {"role": "validate"}):
            first, *others = [one | {"role": "validate"} for one in (first, *others)]
            role = AccountRow("role", "validate", "numbers", "check", complaints[0])
            account = [*(row for row in account if row.subject != "role"), role]
        else:
            doubted = any(r.subject == ORDER and r.confidence == "check" for r in account)
            unknown = UNKNOWN in first.get("units", {}).values()
            order = "if the joints are in this order, " if doubted and not unknown else ""
            account = [*_to_be_corrected(order + one for one in complaints), *account]
    ends = None if others else ends_of(proposal)
    recordings = [ImportedRecording(one, account, ends) for one in (first, *others)]
    return recordings, form_of(proposal)


def _leave_efforts_out(proposal: Proposal) -> None:
    """Leave the efforts out of a proposal, in place: without the joints' angles, gravity shows
    nothing of them.
    """
    for name in [name for name in proposal.channels if name in EFFORT_MEANINGS]:
        proposal.units.pop(name, None)
        for block in proposal.channels.pop(name):
            why = "read only when the angle of joint 3 is, which is counted with joint 2"
            proposal.contents.account.exclude(block, why)


def _to_be_corrected(complaints: Iterable[str]) -> list[AccountRow]:
    """Return a row of an account for each stop sign."""
    stop = AccountRow("recording", TO_BE_CORRECTED, "numbers", "check")
    return [replace(stop, reason=one) for one in complaints]


def contradictions(recording: StudyEntry) -> list[str]:
    """Return the stop signs, or the error, that a recording gives when read through its entry."""
    plain = {"study": "import", "title": "Import", "recordings": [recording]}
    try:
        study = parse_study(plain, "the entry")
        quality, _ = look_through(study.recordings[0], study, only_stops=True)
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


def _name_the_one_before(imported: Sequence[ImportedRecording]) -> None:
    """Write into the entries of each arm, and their accounts, which recording each follows."""
    of_arms = dict[tuple[str, int], dict[str, Ends]]()
    for one in imported:
        if one.ends is not None:
            of_arms.setdefault((one.arm, len(one.ends.first)), {})[one.entry["name"]] = one.ends
    found = {name: link for ends in of_arms.values() for name, link in links(ends).items()}
    for one in imported:
        if link := found.get(one.entry["name"]):
            one.entry["after"] = link.before
            one.account.append(link.row())


def as_entries(imported: Sequence[ImportedRecording]) -> str:
    """Return entries as YAML with their accounts, to be pasted below `recordings:` of a study."""
    form: dict[str, Any] = {"sort_keys": False, "width": YAML_WIDTH, "allow_unicode": True}
    return "\n".join(yaml.dump([item.as_plain()], Dumper=_Dumper, **form) for item in imported)


class _Row(dict[str, str]):
    """A row of an account, written on one line."""


class _Dumper(yaml.SafeDumper):
    """Writes a row of an account as {subject: …, taken_for: …}."""


_Dumper.add_representer(
    _Row,
    lambda dumper, row: dumper.represent_mapping("tag:yaml.org,2002:map", row, flow_style=True),
)


def account_table(imported: Sequence[ImportedRecording], everything: bool = False) -> Table:
    """Return a table of what each column was taken for; files with equal rows appear once.

    everything: with the rows of evidence.
    """
    table = Table("file", "columns", "taken for", "by", "how sure", "why")
    for column in table.columns:
        column.overflow = "fold"
    alike = dict[tuple[tuple[str, ...], ...], list[ImportedRecording]]()
    for item in imported:
        rows = tuple((r.subject, r.taken_for, r.evidence, r.confidence) for r in item.account)
        alike.setdefault(rows, []).append(item)
    for first, *others in alike.values():
        name = first.entry["name"] + (f" and {len(others)} more" if others else "")
        shown = [row for row in first.account if everything or row.confidence != "evidence"]
        for row in sorted(shown, key=lambda row: row.confidence != "check"):
            style = CONFIDENCE_STYLES.get(row.confidence, "")
            cells = row.subject, row.taken_for, row.evidence, row.confidence, row.reason
            table.add_row(name, *cells, style=style)
            name = ""
        table.add_section()
    return table


def expect_new(path: Path) -> None:
    """Raise InputError where the file of a study exists already."""
    if path.exists():
        raise InputError(f"{path} exists; name another file, or add the entries with --add")


def write_study(imported: Sequence[ImportedRecording], path: Path) -> None:
    """Write a study of recordings. Raises InputError where the file exists already."""
    name = identifier(path.stem)
    plain = {"study": name, "title": f"Recordings of {name}"}
    head = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    write_new_text(f"{head}recordings:\n{as_entries(imported)}", path)


def add_to_study(imported: Sequence[ImportedRecording], path: Path) -> None:
    """Append the entries of recordings to a study file that ends with its list of recordings.

    Waits while another process does. Raises InputError if it does not end so, or has a recording of
    the same name.
    """
    with reserved(path, wait=True):
        _append(imported, path)


def _append(imported: Sequence[ImportedRecording], path: Path) -> None:
    before = path.read_text(encoding="utf-8").rstrip() + "\n"
    plain = yaml.safe_load(before)
    names = {recording["name"] for recording in plain.get("recordings") or []}
    if twice := sorted(names & {recording.entry["name"] for recording in imported}):
        raise InputError(f"{path} has a recording {twice[0]} already; rename it there, or the file")
    for one in imported:
        if row := unlike(one.entry, plain.get("recordings") or []):
            one.account.insert(0, with_remedy(row))
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
