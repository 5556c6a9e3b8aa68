"""The report's section on the recordings, their defects and their clocks."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from ur5lib.report.document import Block, Cell, Table
from ur5lib.report.result_tables import group_findings


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
        *([_clock_table(clocks)] if len(clocks) else []),
    ]


def _recording_table(roles: Mapping[str, str], qualities: Mapping[str, Any]) -> Table:
    rows = []
    for name, role in roles.items():
        quality = qualities[name]
        rows.append(
            [
                Cell(name),
                Cell(role),
                Cell(f"{quality['duration_s']:.1f}"),
                Cell(str(quality["rows"])),
                Cell(str(quality["frames"])),
                Cell(f"{1000 * quality['longest_step_s']:.1f}"),
                Cell(f"{1000 * quality['jitter_s']['99 %']:.2f}"),
                Cell(", ".join(quality["devices"])),
            ]
        )
    header = ["recording", "role", "duration [s]", "rows read", "frames", "longest step [ms]"]
    caption = (
        "The recordings: rows read, frames on the uniform grid, the longest step between stamps, "
        "how far 99 % of the steps lie from the grid's, the devices whose data are used. Roles: "
        "fit, contact-free, for fitting; validate, contact-free, not fitted on; contact, something "
        "touches the arm."
    )
    return Table(caption, [*header, "jitter [ms]", "devices used"], rows)


def _finding_table(quality: pd.DataFrame) -> Table:
    header = ["recording", "device", "finding", "severity", "count", "what it means"]
    rows = [[Cell(str(value)) for value in row] for row in group_findings(quality).to_numpy()]
    return Table("What is wrong with the files, and what was done about it.", header, rows)


def _clock_table(clocks: pd.DataFrame) -> Table:
    rows = [
        [
            Cell(clock.recording),
            Cell(clock.device),
            Cell(f"{clock.offset_s:.3f} ± {clock.offset_std_s:.3f}".replace("-", "−")),
            Cell(_drift(clock.drift_ppm, clock.drift_std_ppm)),
            Cell(clock.method),
        ]
        for clock in clocks.itertuples()
    ]
    header = ["recording", "device", "offset [s]", "drift [ppm]", "method"]
    return Table("The devices' clocks against the robot's (offset ± standard error).", header, rows)


def _drift(drift: float, std: float) -> str:
    return "not estimated" if pd.isna(drift) else f"{drift:.0f} ± {std:.0f}".replace("-", "−")
