"""The report's section on the recordings, their defects and their clocks."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from ur5lib.report.document import Block, Cell, Table

ROLES = {
    "fit": "contact-free, for fitting",
    "validate": "contact-free, not fitted on",
    "contact": "something touches the arm",
}


def recording_blocks(
    roles: Mapping[str, str],
    qualities: Mapping[str, Any],
    quality: pd.DataFrame,
    clocks: pd.DataFrame,
) -> list[Block]:
    """roles, qualities (quality.json) by recording; quality, clocks: the tables of these names."""
    return [
        _recording_table(roles, qualities),
        _finding_table(quality),
        _clock_table(clocks),
    ]


def _recording_table(roles: Mapping[str, str], qualities: Mapping[str, Any]) -> Table:
    rows = [
        [
            Cell(name),
            Cell(ROLES[role]),
            Cell(f"{qualities[name]['duration_s']:.1f}"),
            Cell(str(qualities[name]["frames"])),
            Cell(", ".join(qualities[name]["devices"])),
        ]
        for name, role in roles.items()
    ]
    header = ["recording", "role", "duration [s]", "frames", "devices used"]
    return Table("The recordings, and the devices whose data are used.", header, rows)


def _finding_table(quality: pd.DataFrame) -> Table:
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    rows = [
        [*map(Cell, kind), Cell(str(group["count"].sum())), Cell(_said_once(list(group["detail"])))]
        for kind, group in kinds
    ]
    header = ["recording", "device", "finding", "severity", "count", "what it means"]
    return Table("What is wrong with the files, and what was done about it.", header, rows)


def _said_once(details: list[str]) -> str:
    """Details that differ only in the place before their colon, as one."""
    places, rests = zip(*(detail.rpartition(": ")[::2] for detail in details), strict=True)
    return f"{'; '.join(places)}: {rests[0]}" if len(details) > 1 else details[0]


def _clock_table(clocks: pd.DataFrame) -> Table:
    rows = [
        [
            Cell(clock.recording),
            Cell(clock.device),
            Cell(f"{clock.offset_s:.3f} ± {clock.offset_std_s:.3f}".replace("-", "−")),
            Cell("not estimated" if pd.isna(clock.drift_ppm) else f"{clock.drift_ppm:.0f}"),
            Cell(clock.method),
        ]
        for clock in clocks.itertuples()
    ]
    header = ["recording", "device", "offset [s]", "drift [ppm]", "method"]
    return Table("The devices' clocks against the robot's (offset ± standard error).", header, rows)
