"""Import of recordings: each file is analysed, read back through its entry, and checked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from ur5lib.commands.check import look_through, severe
from ur5lib.errors import InputError, printable
from ur5lib.importing.contents import Contents, contents
from ur5lib.importing.entry import Entry, entry, identifier
from ur5lib.importing.proposal import propose
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_text

WRAPPED = 100  # characters a line of YAML


@dataclass(frozen=True)
class Imported:
    """A recording's entry in a study, and the evidence for it as comments."""

    entry: Entry
    comments: list[str]

    @property
    def arm(self) -> str:
        """Return the arm that it is of."""
        return str(self.entry["robot"])


class ImportedFiles(list[Imported]):
    """The files that were imported; refused: the reasons why the others were not."""

    refused: tuple[str, ...] = ()


def import_files(
    paths: Sequence[Path], arms: Sequence[str], trusted: bool = False
) -> ImportedFiles:
    """Return the entries of recordings, each read back and checked.

    arms: the possible ones; trusted: whether the names in the files are right, whatever contradicts
    them. Raises
    InputError, with all reasons, where no file can be read, is unambiguous, and agrees with its
    entry.
    """
    files, refused = list[Contents](), dict[Path, str]()
    proposed, whole = dict[Path, Imported](), dict[Path, Imported]()  # whole: nothing is ambiguous
    for path in paths:
        try:
            files.append(contents(path))
            proposal = propose(files[-1], arms, trusted)
            proposed[path] = Imported(entry(proposal), files[-1].evidence.lines())
            if not files[-1].evidence.ambiguous:
                whole[path] = proposed[path]
        except InputError as error:
            refused[path] = str(error)
    for file in (file for file in files if file.path not in whole):
        own = proposed.get(file.path)
        same = {path: one for path, one in whole.items() if own and one.arm == own.arm}
        if other := _of_same_columns(file, files, same if own else proposed):
            proposed[file.path] = _like(other, file, own)
    imported = ImportedFiles()
    for path in (path for path in paths if path in proposed):
        recording, contradicted = _checked(proposed[path])
        if trusted:
            recording.comments.extend(f"# assumed, although {fault}" for fault in contradicted)
            contradicted = []
        refused[path] = "\n".join(contradicted)
        imported += [] if contradicted else [recording]
    imported.refused = tuple(reason for path in paths if (reason := refused.get(path, "")))
    if imported.refused and not imported:
        raise InputError("\n".join(imported.refused))
    names = set[str]()
    for number, one in enumerate(imported, 1):
        if one.entry["name"] in names:
            one.entry["name"] += f"_{number}"
        names.add(one.entry["name"])
    return imported


def as_entries(imported: Sequence[Imported]) -> str:
    """Return entries as YAML with comments, to be pasted below `recordings:` of a study."""
    parts = []
    for item in imported:
        text = yaml.safe_dump([item.entry], sort_keys=False, width=WRAPPED, allow_unicode=True)
        parts.append("".join(f"{printable(line)}\n" for line in item.comments) + text)
    return "\n".join(parts)


def write_study(imported: Sequence[Imported], path: Path) -> None:
    """Write a study of recordings. Raises InputError where the file exists already."""
    if path.exists():
        raise InputError(f"{path} exists; name another file, or paste the entries into it")
    name = identifier(path.stem)
    plain = {"study": name, "title": f"Recordings of {name}"}
    head = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    write_text(f"{head}recordings:\n{as_entries(imported)}", path)


def _checked(imported: Imported) -> tuple[Imported, list[str]]:
    """Return an entry and complaints about it; if only the role `fit` is wrong, use `validate`."""
    complaints = contradictions(imported.entry)
    as_validate = imported.entry | {"role": "validate"}
    if not complaints or imported.entry["role"] != "fit" or contradictions(as_validate):
        return imported, complaints
    reason = complaints[0].split(": ", 1)[-1]
    comments = [line for line in imported.comments if not line.startswith("# assumed: role")]
    return Imported(as_validate, [*comments, f"# assumed: role validate, as {reason}"]), []


def contradictions(recording: Entry) -> list[str]:
    """Return the stop signs and errors of a recording that is read through an entry."""
    plain = {"study": "import", "title": "Import", "recordings": [recording]}
    study = parse_study(plain, "the entry")
    quality, _ = look_through(study.recordings[0], study)
    path = Path(recording["folder"], recording["file"])
    return [f"{path}: {detail}" for detail in severe(quality)]


def _of_same_columns(
    file: Contents, files: Sequence[Contents], imported: Mapping[Path, Imported]
) -> Imported | None:
    """Return an imported recording with the same columns as an ambiguous file, if any."""
    columns = file.header.columns
    alike = (f for f in files if columns and f.header.columns == columns and f.path in imported)
    return next((imported[other.path] for other in alike), None)


def _like(other: Imported, file: Contents, own: Imported | None) -> Imported:
    """Return the entry of a file with columns, units and robot of another; own: what is proven."""
    path, source = file.path, Path(other.entry["folder"], other.entry["file"])
    place = {"name": identifier(path.name), "folder": str(path.parent), "file": path.name}
    place |= {"role": own.entry["role"]} if own else {}
    shared = "columns, units and robot" if own else "columns, units, robot and role"
    assumed = f"{shared} as in {source}: too little moves to prove them here"
    return Imported(other.entry | place, [f"# assumed: {assumed}"])
