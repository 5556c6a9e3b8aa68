"""Import of recordings: each file is analysed, read back through its entry, and checked."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ur5lib.channels import JOINT_CHANNELS, SUFFIXES, suffixes
from ur5lib.channels import columns as columns_of
from ur5lib.commands.check import look_through, severe
from ur5lib.errors import InputError, printable
from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import EPOCH, Contents, contents
from ur5lib.importing.efforts import NAMED
from ur5lib.importing.motion import TARGETS
from ur5lib.importing.proposal import Proposal, propose
from ur5lib.recordings.entries import OPPOSITE, SKIPPED
from ur5lib.recordings.readings import IN_ORDER
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_text

WRAPPED = 100  # characters a line of YAML
ASKED = (*NAMED, *TARGETS, "actual_TCP_pose")  # channels that are proven, assumed, or left out
PROVABLE = {c for name in ASKED for c in columns_of(name)}
RTDE = ("ft_raw_wrench", "wrench_calc_from_currents", "payload", "payload_cog", "payload_inertia")
KEPT = {c for name in (*RTDE, "target_gravity", "tcp_offset") for c in columns_of(name)}
Entry = dict[str, Any]  # of a study, as YAML has it


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
    them. Raises InputError, with all reasons, where no file can be read, is unambiguous, and agrees
    with its entry.
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
        known, columns = same if own else proposed, file.header.columns
        alike = (f.path for f in files if columns and f.header.columns == columns)
        if other := next((known[path] for path in alike if path in known), None):
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


def _like(other: Imported, file: Contents, own: Imported | None) -> Imported:
    """Return the entry of a file with columns, units and robot of another; own: what is proven."""
    path, source = file.path, Path(other.entry["folder"], other.entry["file"])
    place = {"name": identifier(path.name), "folder": str(path.parent), "file": path.name}
    place |= {"role": own.entry["role"]} if own else {}
    shared = "columns, units and robot" if own else "columns, units, robot and role"
    assumed = f"{shared} as in {source}: too little moves to prove them here"
    return Imported(other.entry | place, [f"# assumed: {assumed}"])


def entry(proposal: Proposal) -> Entry:
    """Return the entry of a file's recording."""
    path = proposal.contents.path
    head = {
        "name": identifier(path.name),
        "robot": proposal.arm,
        "format": proposal.contents.format,
        "folder": str(path.parent),
        "file": path.name,
        "role": "contact" if proposal.pushed else "fit",
    }
    if proposal.contents.format == "table-csv":
        return head | _of_table(proposal)
    return head | _of_arrays(proposal)


def identifier(name: str) -> str:
    """Return the name of a recording from a file's name up to its first dot."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name.split(".")[0]).strip("_") or "recording"


def _of_table(proposal: Proposal) -> Entry:
    """Return `columns`, `units` and `time`, or the format alone if all columns have RTDE names."""
    header = proposal.contents.header
    named = {proposal.clock: "time"}
    sensor = dict(zip(("ft_f", "ft_t"), ([block] for block in proposal.sensor), strict=False))
    for channel, blocks in (proposal.channels | sensor).items():
        names = [name for block in blocks for name in block.names]
        order = proposal.order if channel in JOINT_CHANNELS else range(len(names))
        named |= {
            names[column]: channel + suffix
            for column, suffix in zip(order, suffixes(channel, len(proposal.order)), strict=True)
        }
    units = _units(proposal)
    unchanged = all(name in (column, "time") for column, name in named.items())
    silent = {name for block in proposal.contents.silent for name in block.names}
    left_out = PROVABLE - silent - {*named}
    whole = left_out.isdisjoint(header.columns)
    if proposal.clock == "timestamp" and unchanged and whole and not (header.repeated or units):
        return {"format": "rtde-csv"}
    columns = [
        named.get(column, column if column in KEPT else SKIPPED) for column in header.columns
    ]
    if len(proposal.order) == len(IN_ORDER):
        columns = _shortened(columns)
    if sensor and proposal.opposite:
        units = {"units": units.get("units", {}) | dict.fromkeys(sensor, OPPOSITE)}
    for unit in units.get("units", {}).values():
        if isinstance(unit, list):
            unit[:] = [unit[column] for column in proposal.order]
    return {"columns": columns} | units | _time(proposal)


def _shortened(columns: Sequence[str]) -> list[str]:
    """Return columns with one name for those of a channel that are adjacent and in order."""
    short: list[str] = []
    rest = [*columns]
    while rest:
        channel = re.sub(r"_\d$", "", rest[0])
        width = len(SUFFIXES.get(channel, []))
        whole = width and rest[:width] == [channel + suffix for suffix in SUFFIXES[channel]]
        short.append(channel if whole else rest[0])
        rest = rest[width:] if whole else rest[1:]
    return short


def _of_arrays(proposal: Proposal) -> Entry:
    """Return `channels`, `joints`, `units`, `time` and the force sensor."""
    channels: Entry = {"time": proposal.clock}
    channels |= {name: _named(blocks) for name, blocks in proposal.channels.items()}
    joints = [proposal.order.index(column) + 1 for column in range(len(proposal.order))]
    sensor = {}
    if proposal.sensor:
        named = (_named([block]) for block in proposal.sensor)
        parts = dict(zip(("ft_f", "ft_t"), named, strict=False))
        sign = {"units": dict.fromkeys(parts, OPPOSITE)} if proposal.opposite else {}
        clock = {"time": proposal.sensor[0].clock}
        sensor = {"force_sensor": {"channels": clock | parts} | sign | _time(proposal)}
    order = {"joints": joints} if joints != sorted(joints) else {}
    return {"channels": channels} | order | _units(proposal) | _time(proposal) | sensor


def _named(blocks: Sequence[Block]) -> str | list[str]:
    names = [name for block in blocks for name in block.names]
    return names[0] if len(names) == 1 else names


def _units(proposal: Proposal) -> Entry:
    clock = proposal.contents.units.get(proposal.clock)
    units = proposal.units | ({"time": clock} if clock else {})
    return {"units": units} if units else {}


def _time(proposal: Proposal) -> dict[str, str]:
    first = proposal.contents.clocks[proposal.clock][0]
    return {"time": "epoch_s"} if first > EPOCH else {}
