"""The study's tables of results, from what every recording came to."""

from typing import Any

import pandas as pd

from ur5lib.report.reference import read_reference
from ur5lib.report.result_tables import clock_table, force_errors, quality_table, torque_errors
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_csv

TORQUE_COLUMNS = ["recording", "motion", "model", "joint", "mae", "printed", "zero_mae"]
FORCE_COLUMNS = ["recording", "kind", "estimate", "component", "mae", "max", "zero_mae"]
FORCE_COLUMNS += ["zero_max", "correlation", "coverage95", "printed_mae", "printed_max"]


def make_tables(input: Any, output: Any, params: Any) -> None:
    printed = read_reference(input.get("reference")).printed
    recordings = params.recordings
    qualities = dict(zip(recordings, map(read_json, input.quality), strict=True))
    clocks = dict(zip(recordings, map(read_json, input.clocks), strict=True))
    summaries = dict(zip(recordings, map(read_json, input.forces), strict=True))

    torque_rows = [
        row
        for recording, torques, signals in zip(
            recordings, input.torques, input.signals, strict=True
        )
        for row in torque_errors(
            recording, read_table(torques), read_table(signals), printed.torque_mae
        )
    ]
    force_rows = [
        row
        for recording, summary in summaries.items()
        for row in force_errors(recording, summary, printed.force_mae, printed.force_max)
    ]
    write_csv(quality_table(qualities, clocks), output.quality)
    write_csv(clock_table(clocks), output.clocks)
    write_csv(pd.DataFrame(torque_rows, columns=TORQUE_COLUMNS), output.torque_mae)
    write_csv(pd.DataFrame(force_rows, columns=FORCE_COLUMNS), output.force_mae)


if __name__ == "__main__":
    run_step(make_tables, snakemake)  # type: ignore[name-defined]  # noqa: F821
