"""Every published number beside the rebuilt one, and as the errata say that it was computed."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Quality
from ur5lib.report.explained_errors import explained_accelerations, loop_error
from ur5lib.report.printed_numbers import PRINTED_COLUMNS, ExplainedRow, compared
from ur5lib.report.reference import PublishedValues, read_reference
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_csv, read_record, read_table, write_csv
from ur5lib.timeseries.metrics import mean_absolute_error


def compare_with_print(input: Any, output: Any, params: Any) -> None:
    reference = read_reference(input.get("reference"))
    tables = {Path(path).stem: read_csv(path) for path in input.tables}
    rows = compared(reference, tables, [*explained(reference, input, params)])
    write_csv(pd.DataFrame(rows, columns=PRINTED_COLUMNS), output.printed)


def explained(reference: PublishedValues, input: Any, params: Any) -> Iterator[ExplainedRow]:
    """Yield the numbers of the errata's explanations, of the recordings of this study."""
    for number, erratum in enumerate(reference.errata, 1):
        for way in erratum.explains:
            recording = reference.printed[way.printed].recording
            if recording not in params.recordings:
                continue
            place = params.recordings.index(recording)
            robot = load_robot(input.arm[place]).mounted(params.gravities[place])
            signals = Signals.read(input.signals[place])
            if way.closed_loop:
                values = loop_error(robot, signals, way.closed_loop)
            if way.acceleration:
                imu = read_table(input.imu[place])
                start = read_record(Quality, input.quality[place]).starts["imu"]
                kinematics = Kinematics.read(input.kinematics[place])
                values = mean_absolute_error(
                    *explained_accelerations(
                        robot, signals, kinematics, imu, start, way.acceleration
                    )
                )
            yield ExplainedRow(number, way.printed, way.row, values)
