"""Import of recordings: each file looked into, read back through its entry, and checked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ur5lib.commands.check import look_through, severe
from ur5lib.errors import InputError
from ur5lib.importing.contents import Contents, contents
from ur5lib.importing.entry import entries_yaml, entry, identifier, study_yaml
from ur5lib.importing.proposal import propose
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_text


@dataclass(frozen=True)
class Imported:
    """A recording's entry in a study, and what is known about it, as comments."""

    entry: dict[str, Any]
    comments: list[str]


def import_files(paths: Sequence[Path], arms: Sequence[str]) -> list[Imported]:
    """Return the entries of recordings, each read back and checked; arms: those they may be of.

    Raises InputError, with all reasons, where a file cannot be read, is ambiguous, or contradicts
    its entry.
    """
    found = [contents(path) for path in paths]
    imported, refused = {}, {}
    for one in found:
        try:
            proposal = propose(one, arms)
            imported[one.path] = Imported(entry(proposal), proposal.account.lines())
        except InputError as error:
            refused[one.path] = error
    for one in found:
        if one.path in refused and (other := _of_same_columns(one, found, imported)):
            imported[one.path] = _like(other, one)
            del refused[one.path]
    complaints = [str(error) for error in refused.values()]
    for path, its in imported.items():
        imported[path], contradicted = _checked(its)
        complaints += contradicted
    if complaints:
        raise InputError("\n".join(complaints))
    _number_names([imported[one.path].entry for one in found])
    return [imported[one.path] for one in found]


def as_entries(imported: Sequence[Imported]) -> str:
    """Return entries as YAML, to be pasted below `recordings:` of a study."""
    return entries_yaml([(one.entry, one.comments) for one in imported])


def write_study(imported: Sequence[Imported], path: Path) -> None:
    """Write a study of recordings. Raises InputError where the file exists already."""
    if path.exists():
        raise InputError(f"{path} exists; name another file, or paste the entries into it")
    name = identifier(path.stem)
    title = f"Recordings of {name}"
    entries = [(one.entry, one.comments) for one in imported]
    write_text(study_yaml(name, title, entries), path)


def _checked(one: Imported) -> tuple[Imported, list[str]]:
    """Return an entry, as `validate` where only the role `fit` is contradicted, and complaints."""
    complaints = contradictions(one.entry)
    other = one.entry | {"role": "validate"}
    if not complaints or one.entry["role"] != "fit" or contradictions(other):
        return one, complaints
    reason = complaints[0].split(": ", 1)[-1]
    comments = [line for line in one.comments if not line.startswith("# assumed: role")]
    return Imported(other, [*comments, f"# assumed: role validate, as {reason}"]), []


def contradictions(its: dict[str, Any]) -> list[str]:
    """Return what contradicts an entry when the recording is read through it."""
    study = parse_study({"study": "import", "title": "Import", "recordings": [its]}, "the entry")
    quality, _ = look_through(study.recordings[0], study)
    return [f"{Path(its['folder'], its['file'])}: {detail}" for detail in severe(quality)]


def _of_same_columns(
    one: Contents, found: Sequence[Contents], imported: Mapping[Path, Imported]
) -> Imported | None:
    """Return what was understood and has the same columns as a file that tells too little."""
    columns = one.header.columns
    alike = (o for o in found if columns and o.header.columns == columns and o.path in imported)
    return next((imported[other.path] for other in alike), None)


def _like(other: Imported, one: Contents) -> Imported:
    """Return the entry of a recording like another's."""
    own = {"name": identifier(one.path.name), "folder": str(one.path.parent), "file": one.path.name}
    source = Path(other.entry["folder"], other.entry["file"])
    assumed = f"columns, units, robot and role as in {source}: too little moves to prove them here"
    return Imported(other.entry | own, [f"# assumed: {assumed}"])


def _number_names(entries: Sequence[dict[str, Any]]) -> None:
    """Give each recording a name of its own."""
    for place, its in enumerate(entries):
        if its["name"] in {other["name"] for other in entries[:place]}:
            its["name"] = f"{its['name']}_{place + 1}"
