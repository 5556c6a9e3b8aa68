"""Postures at rest, of a recording without time, and the recording's rows of the tables."""

from dataclasses import replace
from typing import Any

from ur5lib.pipeline.postures import checked_postures
from ur5lib.recordings.entries import ENTRY
from ur5lib.report.tables.making import declarations, make_table, records
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import checksum, csv_text, write_json


def tabulate_postures(input: Any, output: Any, params: Any) -> None:
    recording, arm = ENTRY.validate_json(params.recording), load_robot(input.arm)
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    arm = arm.mounted(params.gravity)
    postures, quality = checked_postures(recording, arm, declared, params.tcp or None)
    quality = replace(quality, read={path: checksum(path) for path in input.raw})
    known = {"quality": quality, "contradictions": postures.contradictions}
    kinds = {kind: {params.name: known[kind]} if kind in known else {} for kind in records()}
    write_json(postures, output.postures)
    tables = {name: csv_text(make_table(name, kinds)) for name in declarations()}
    write_json(tables, output.rows)
