"""How each joint of an arm changes over time, from its contact-free recordings."""

from typing import Any

from ur5lib.pipeline.current_samples import current_record, smoother
from ur5lib.pipeline.health import checkup, dated, enough, health_of
from ur5lib.pipeline.records.arm_state import Condition, JointChange
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.prediction import Prediction
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Quality
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_rows


def track_health(input: Any, output: Any, params: Any) -> None:
    model = load_robot(input.arm).fullest_model()
    qualities = [read_record(Quality, path) for path in input.quality]
    currents = [read_record(Prediction, path) for path in input.currents]
    days = [*map(dated, params.dates, qualities, currents)]
    checkups = []
    if enough(days):
        fit = read_record(Friction, input.friction).fit
        smooth = smoother(params.order, params.cutoff_hz)
        rows = zip(params.recordings, days, input.signals, input.motion, input.torques, strict=True)
        for place, (name, day, signals, motion, torques) in enumerate(rows):
            tables = Signals.read(signals), Motion.read(motion), Torques.read(torques)
            record = current_record(name, *tables, model)
            if day is not None and record is not None:
                checkups.append(checkup(record, smooth, fit, day, qualities[place]))
    found = health_of(checkups)
    write_rows(Condition, found.dates, output.health)
    write_rows(JointChange, found.changes, output.changes)
