"""Angles of a file's joints that wrap, made continuous before its motion is looked for."""

from dataclasses import replace

import numpy as np

from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.contents import FileContents
from ur5lib.recordings.wraps import TURN, unwrapped
from ur5lib.timeseries.arrays import Array

TURNS = {"360°": 360.0, "2π": TURN}  # whole turns in the units of angles
ANGLES = ("actual_q", "target_q")


def with_continuous_angles(file: FileContents) -> FileContents:
    """Return a file with angles that wrapped made continuous; the account states which."""
    named = {block.meaning() for block in file.blocks}
    angles = ANGLES if "actual_q" in named else (*ANGLES, None)  # where no name identifies them
    blocks = [
        _continuous(block, file) if block.meaning() in angles else block for block in file.blocks
    ]
    return replace(file, blocks=blocks)


def _continuous(block: ColumnBlock, file: FileContents) -> ColumnBlock:
    time = file.clocks.stamps[block.clock]
    for name, turn in TURNS.items():
        columns = [unwrapped(column, time, turn) for column in block.rows.T]
        if wraps := [str(k + 1) for k, (_, count) in enumerate(columns) if count]:
            wrapped = f"it wraps by {name} in columns {', '.join(wraps)}: made continuous"
            file.account.hold("assumed", block, "numbers", wrapped)
            rows: Array = np.stack([angle for angle, _ in columns], axis=1)
            return replace(block, rows=rows)
    return block
