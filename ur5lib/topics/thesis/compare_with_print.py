"""Every published number with the rebuilt one, and with one computed as an erratum explains."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.opened import Opened
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.tables import read_csv
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import mean_absolute_error
from ur5lib.topics.thesis.explained_errors import explained_accelerations, loop_error
from ur5lib.topics.thesis.printed_numbers import PRINTED_COLUMNS, ExplainedRow, compared
from ur5lib.topics.thesis.reference import Explanation, read_reference
from ur5lib.topics.thesis.rows import ListedErratum


class BesidePrint(NamedTuple):
    """The published numbers with ours, and the list of errata."""

    printed: pd.DataFrame
    errata: list[ListedErratum]


class Inputs(Opened):
    """What is read of a recording."""

    signals: Signals
    kinematics: Kinematics
    imu: pd.DataFrame
    quality: Quality


def compare_with_print(
    reference: Path,
    tables: list[Path],
    recordings: Mapping[str, Inputs],
    arms: Mapping[str, Robot],
    arm_of: dict[str, str],
    gravities: dict[str, list[float] | None],
) -> BesidePrint:
    """Return the published numbers, the rebuilt ones, and those computed as errata explain.

    recordings: those that an erratum explains; arms: by name; arm_of: arm's name by recording.
    """
    published = read_reference(reference)

    def values(name: str, way: Explanation) -> Array:
        recording, robot = recordings[name], arms[arm_of[name]].mounted(gravities[name])
        if way.closed_loop:
            return loop_error(robot, recording.signals, way.closed_loop)
        assert way.acceleration is not None
        return mean_absolute_error(*explained_accelerations(recording, robot, way.acceleration))

    def explained() -> Iterator[ExplainedRow]:
        for number, erratum in enumerate(published.errata, 1):
            for way in erratum.explains:
                name = published.printed[way.printed].recording
                if name in recordings:
                    yield ExplainedRow(number, way.printed, way.row, values(name, way))

    own = {path.stem: read_csv(path) for path in tables}
    rows = compared(published, own, [*explained()])
    errata = [ListedErratum(**one.model_dump(exclude={"explains"})) for one in published.errata]
    return BesidePrint(pd.DataFrame(rows, columns=PRINTED_COLUMNS), errata)
