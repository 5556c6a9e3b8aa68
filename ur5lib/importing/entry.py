"""The entry of a study for a proposal: of a table its columns, of arrays their names."""

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.channels import JOINT_CHANNELS, RECORDED_CHANNELS, SUFFIXES, suffixes
from ur5lib.channels import columns as columns_of
from ur5lib.importing.blocks import JOINTS_OF_UR, ColumnBlock
from ur5lib.importing.clocks import MIN_EPOCH_STAMP
from ur5lib.importing.contents import PARTED_FORMAT, TABLE_FORMAT
from ur5lib.importing.efforts import UNITS_BY_CHANNEL
from ur5lib.importing.motion import TARGET_UNITS
from ur5lib.importing.proposal import Proposal, is_clockless
from ur5lib.importing.spellings import last_part
from ur5lib.recordings.entries import OPPOSITE_SIGN, SKIPPED_COLUMN
from ur5lib.recordings.ordering import continued, epochs

EPISODE_INDEX = "episode_index"  # LeRobot's
RECORDED_COLUMNS = {c for name in RECORDED_CHANNELS for c in columns_of(name)}
StudyEntry = dict[str, Any]  # of a study, as YAML has it
# Channels that are proven, assumed, or left out.
PROVABLE_CHANNELS = (*UNITS_BY_CHANNEL, *TARGET_UNITS, "actual_TCP_pose")
PROVABLE_COLUMNS = {c for name in PROVABLE_CHANNELS for c in columns_of(name)}


def entry_of(proposal: Proposal) -> StudyEntry:
    """Return the entry in a study for a file's recording."""
    path, format = proposal.contents.path, proposal.contents.format
    place = place_of_file(path)
    if format == PARTED_FORMAT:
        del place["file"]
    head = {"name": place["name"], "robot": proposal.arm, "format": format} | place
    head["role"] = "contact" if proposal.pushed else "fit"
    return head | (_of_table(proposal) if format == TABLE_FORMAT else _of_arrays(proposal))


def episodes(proposal: Proposal) -> list[StudyEntry]:
    """Return, for each episode in a file, the keys `name`, `from_s` and `to_s` of its entry; empty
    without episodes.
    """
    file = proposal.contents
    every = [b for b in file.blocks + file.silent if last_part(b.stem()) == EPISODE_INDEX]
    if not every or proposal.moving.still:
        return []
    stamps = proposal.moving.time
    time = continued(stamps, epochs(stamps))
    starts = np.flatnonzero(np.diff(every[0].rows[:, 0])) + 1
    middle = (time[starts] + time[starts - 1]) / 2 - time[0]
    bounds = [None, *(round(float(bound), 6) for bound in middle), None]
    return [
        {"name": f"{identifier(file.path.name)}_episode_{k + 1}"}
        | ({} if start is None else {"from_s": start})
        | ({} if end is None else {"to_s": end})
        for k, (start, end) in enumerate(pairwise(bounds))
        if len(starts)
    ]


def identifier(name: str) -> str:
    """Return a recording's name by a file's name up to its first dot, without characters that names
    may not have.
    """
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name.split(".")[0]).strip("_")[:200] or "recording"


def place_of_file(path: Path) -> StudyEntry:
    """Return the keys `name`, `folder` and `file` of an entry."""
    return {"name": identifier(path.name), "folder": str(path.parent), "file": path.name}


def _of_table(proposal: Proposal) -> StudyEntry:
    """Return the keys `columns`, `units` and `time` of a table's entry, or its format alone if all
    columns have RTDE names.
    """
    header, joints = proposal.contents.header, len(proposal.order)
    named = {} if is_clockless(proposal) else {proposal.clock: "time"}
    sensor = proposal.force_channels
    for channel, blocks in (proposal.channels | sensor).items():
        names = [name for block in blocks for name in block.names]
        order = proposal.order if channel in JOINT_CHANNELS else range(len(names))
        named |= {
            names[column]: channel + suffix
            for column, suffix in zip(order, suffixes(channel, joints), strict=True)
        }
    units = _units(proposal)
    unchanged = all(name in (column, "time") for column, name in named.items())
    silent = {name for block in proposal.contents.silent for name in block.names}
    left_out = {name for names in proposal.contents.account.excluded for name in names} - silent
    read = (left_out | (PROVABLE_COLUMNS - {*named} - silent)) & {*RECORDED_COLUMNS}
    whole = read.isdisjoint(header.columns)
    plain = unchanged and whole and not (header.repeated or units or header.entry)
    if proposal.clock == "timestamp" and plain:
        return {"format": "rtde-csv"}
    named |= {name: name for block in proposal.read_as_named for name in block.names}
    columns = [named.get(column, SKIPPED_COLUMN) for column in header.columns]
    columns = _shortened(columns) if joints == JOINTS_OF_UR else columns
    if sensor and proposal.opposite:
        units = {"units": units.get("units", {}) | dict.fromkeys(sensor, OPPOSITE_SIGN)}
    for unit in units.get("units", {}).values():
        if isinstance(unit, list):
            unit[:] = [unit[column] for column in proposal.order]
    return {"columns": columns} | units | _time(proposal)


def _shortened(columns: Sequence[str]) -> list[str]:
    """Return columns with the channel's name for all its columns where these are adjacent and in
    order.
    """
    short: list[str] = []
    rest = [*columns]
    while rest:
        channel = re.sub(r"_\d$", "", rest[0])
        width = len(SUFFIXES.get(channel, []))
        whole = width and rest[:width] == [channel + suffix for suffix in SUFFIXES[channel]]
        short.append(channel if whole else rest[0])
        rest = rest[width:] if whole else rest[1:]
    return short


def _of_arrays(proposal: Proposal) -> StudyEntry:
    """Return the keys `channels`, `joints`, `units`, `time` and `force_sensor` of an entry of
    arrays.
    """
    channels: StudyEntry = {} if is_clockless(proposal) else {"time": proposal.clock}
    channels |= {name: _named(blocks) for name, blocks in proposal.channels.items()}
    joints = [proposal.order.index(column) + 1 for column in range(len(proposal.order))]
    sensor = {}
    if proposal.sensor:
        parts = {name: _named(blocks) for name, blocks in proposal.force_channels.items()}
        sign = {"units": dict.fromkeys(parts, OPPOSITE_SIGN)} if proposal.opposite else {}
        clock = {} if is_clockless(proposal) else {"time": proposal.sensor[0].clock}
        sensor = {"force_sensor": {"channels": clock | parts} | sign | _time(proposal)}
    order = {"joints": joints} if joints != sorted(joints) else {}
    return {"channels": channels} | order | _units(proposal) | _time(proposal) | sensor


def _named(blocks: Sequence[ColumnBlock]) -> str | list[str]:
    """Return the names of the blocks' columns; one alone not as a list."""
    names = [name for block in blocks for name in block.names]
    return names[0] if len(names) == 1 else names


def _units(proposal: Proposal) -> StudyEntry:
    clock = proposal.contents.clocks.units.get(proposal.clock)
    units = proposal.units | ({"time": clock} if clock else {})
    return {"units": units} if units else {}


def _time(proposal: Proposal) -> StudyEntry:
    """Return the key `time` of an entry if stamps are since 1970, or `still` or `rate` without a
    clock.
    """
    if proposal.moving.still:
        return {"still": True}
    if is_clockless(proposal):
        return {"rate": proposal.moving.rate}
    first_stamp = np.nanmin(proposal.contents.clocks.stamps[proposal.clock])
    return {"time": "epoch_s"} if first_stamp > MIN_EPOCH_STAMP else {}
