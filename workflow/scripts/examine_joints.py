"""The condition of each joint by one contact-free recording."""

from typing import Any

from ur5lib.pipeline.checkup import checkup, dated
from ur5lib.pipeline.current_samples import Smoother, current_record
from ur5lib.recordings.quality import Quality
from ur5lib.records.arm_state import Checkup
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def examine_joints(input: Any, output: Any, params: Any) -> None:
    quality, found = read_record(Quality, input.quality), Checkup()
    day = dated(params.date, quality, read_record(Prediction, input.currents))
    if day is not None:
        model = load_robot(input.arm).fullest_model()
        tables = Signals.read(input.signals), Motion.read(input.motion)
        record = current_record(params.recording, *tables, Torques.read(input.torques), model)
        if record is not None:
            fit = read_record(Friction, input.friction).fit
            found = checkup(record, Smoother(params.order, params.cutoff_hz), fit, day, quality)
    write_json(found, output.checkup)
