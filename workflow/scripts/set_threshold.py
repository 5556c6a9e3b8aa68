"""From which odds on a contact is called one: few alarms where nothing touches the arm."""

from typing import Any

from ur5lib.force.detection import alarm_threshold
from ur5lib.steps import run_step
from ur5lib.tables import period, read_table, write_json

ODDS = "log_odds_"


def set_threshold(input: Any, output: Any, params: Any) -> None:
    tables = [read_table(path) for path in input.forces]
    estimates = sorted({name for table in tables for name in table.filter(regex=f"^{ODDS}")})
    thresholds = {}
    for name in estimates:
        known = [table for table in tables if name in table]
        odds = [table[name].to_numpy() for table in known]
        thresholds[name.removeprefix(ODDS)] = alarm_threshold(
            odds, [period(table) for table in known], params.false_alarms_per_min
        )
    write_json(thresholds, output.threshold)


if __name__ == "__main__":
    run_step(set_threshold, snakemake)  # type: ignore[name-defined]  # noqa: F821
