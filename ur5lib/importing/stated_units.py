"""The units that the user states: by name, or as the SI value of one unit of the file."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.channels import CHANNELS, MEASURED_EFFORTS
from ur5lib.errors import InputError
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.contents import FileContents
from ur5lib.recordings.delimited import number_in
from ur5lib.recordings.less_gravity import TORQUE_LESS_GRAVITY

TORQUES = ("actual_current_as_torque", "actual_torque")  # of one meaning
ANY_EFFORT = (*MEASURED_EFFORTS, TORQUE_LESS_GRAVITY)
VALUES = "the {unit} of one unit, of each joint if they differ: 0.1,0.2,…"


def values_of(unit: str) -> list[float] | None:
    """Return the SI values that a statement lists, None for a unit's name."""
    found = [number_in(part.encode()) for part in unit.split(",")]
    values = [value for value in found if value is not None and np.isfinite(value)]
    return values if unit and len(values) == len(found) else None


def in_stated_values(block: ColumnBlock, channel: str, file: FileContents) -> ColumnBlock:
    """Return a block in SI units where the user states values of the channel that it is taken for;
    else as it is.

    Raises InputError for neither one value nor one of each column.
    """
    values = values_of(file.stated.units.get(channel, ""))
    if values is None:
        return block
    width = block.rows.shape[1]
    if len(values) not in (1, width):
        raise InputError(
            f"{file.path}: --unit {channel} has {len(values)} values, {block.title} {width} "
            "columns; give one value, or one of each column"
        )
    told = ", ".join(f"{value:g}" for value in values)
    reason = f"one unit of the file is {told} {CHANNELS[channel].unit}"
    file.account.hold("assumed", block, "option", reason)
    return replace(block.scaled(np.array(values)), stated=channel)


def stated_for(block: ColumnBlock, file: FileContents) -> str:
    """Return the channel whose stated unit is that of an effort, "" for none: its own, or that of
    another measured effort, if no block of the file is named so.
    """
    meaning = block.meaning() or ""
    bare = meaning in ("", "effort")
    measured = [channel for channel in file.stated.units if channel in ANY_EFFORT]
    named = {other.meaning() for other in file.blocks if other is not block}
    own = [channel for channel in file.stated.units if _alike(channel, meaning)]
    free = [c for c in measured if not any(_alike(c, other or "") for other in named)]
    others = measured if bare else free if meaning in ANY_EFFORT else []
    return next(iter([*own, *others]), "")


def _alike(channel: str, meaning: str) -> bool:
    return channel == meaning or {channel, meaning} <= {*TORQUES}


def remedy(channel: str, units: Sequence[str] = ()) -> str:
    """Return in words the option that names the unit of a channel; units: by name, as mA."""
    unit = CHANNELS[channel].unit
    names = ", ".join([unit, *units])
    less = f"; less gravity: --unit {TORQUE_LESS_GRAVITY}=Nm" if channel in TORQUES else ""
    return f"--unit {channel}={names}, or {VALUES.format(unit=unit)}{less}"
