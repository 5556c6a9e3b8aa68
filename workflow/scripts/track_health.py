"""How each joint of an arm changes over time, from its contact-free recordings."""

from typing import Any

from ur5lib.identification.samples import path_of
from ur5lib.pipeline.health import health_of
from ur5lib.records.arm_state import Checkup, Condition, JointChange
from ur5lib.records.motion import Motion
from ur5lib.tables import read_record, write_rows


def track_health(input: Any, output: Any, params: Any) -> None:
    checkups = [read_record(Checkup, path) for path in input.checkups]
    used = [(one, path) for one, path in zip(checkups, input.motion, strict=True) if one.date]
    motions = (Motion.read(path) for _, path in used)
    paths = (path_of(own.q, own.motor_qd, own.period) for own in motions)
    found = health_of([one for one, _ in used], paths)
    write_rows(Condition, found.dates, output.health)
    write_rows(JointChange, found.changes, output.changes)
