"""Stop signs: what in a recording contradicts the study; and doubts about payload, tool, length."""

from typing import Any

from ur5lib.checks.channels import too_short
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import CHECKED_COLUMNS, stop_signs
from ur5lib.checks.torques import given_load
from ur5lib.pipeline.carried import carried, disagreements
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Contradictions
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import read_footer, read_table, write_json


def find_contradictions(input: Any, output: Any, params: Any) -> None:
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    signals, arm = Signals.read(input.signals), load_robot(input.arm).mounted(params.gravity)
    load, doubts = carried(declared, signals), disagreements(declared, params.tcp or None, signals)
    doubts += too_short(signals.segment, signals.period, params.cutoff_hz)
    del signals
    known = CHECKED_COLUMNS.intersection(read_footer(input.signals).schema.names)
    table = read_table(input.signals, [*known])
    checked = Checked(table, arm, load.configured, load.payload, params.role == "fit")
    doubts += checked.odd_targets.values()
    stops = stop_signs(checked)
    if not stops:  # from which others would follow
        doubts += given_load(checked)
    write_json(Contradictions(stops, doubts), output.contradictions)
