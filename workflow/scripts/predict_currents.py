"""The current that motion without contact needs, and the torque that is left for a contact."""

from typing import Any

import numpy as np

from ur5lib.identification.currents import fit_for
from ur5lib.identification.payload import PayloadEstimate, judged_load
from ur5lib.pipeline.current_prediction import baselines, predicted_currents, scores, with_load
from ur5lib.pipeline.current_samples import current_record, smoother
from ur5lib.pipeline.force_input import passed
from ur5lib.pipeline.records.currents import Currents, LoadRegressor
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import load_robot
from ur5lib.tables import as_record, read_json, write_json


def predict_currents(input: Any, output: Any, params: Any) -> None:
    robot, friction = load_robot(input.arm), read_json(input.friction)
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    model = robot.fullest_model()
    # read anew where it is used, so that a long recording's torques are not held throughout
    record = current_record(params.recording, signals, motion, Torques.read(input.torques), model)
    currents = Currents(time=signals.time, segment=signals.segment)
    summary: dict[str, Any] = {"fitted": params.recording in friction["from"], "scores": {}}
    known, stopped = read_json(input.load), read_json(input.contradictions)["stop_signs"]
    if record is not None and friction["from"] and not stopped:
        smooth, cutoff = smoother(params.order, params.cutoff_hz), params.cutoff_hz
        fit, load, load_torque = fit_for(params.recording, friction), None, 0 * record.q
        if found := read_json(input.payload):
            payload = as_record(PayloadEstimate, found)
            others = [found for path in input.unloaded if (found := read_json(path))]
            unloaded = as_record(list[PayloadEstimate], others)
            load = judged_load(payload, unloaded, friction["paths"], known, params.role)
            if load["taken"]:
                load_torque = LoadRegressor.read(input.regressor).torque(payload.parameters)
        record, load_torque = with_load(record, load_torque, fit, smooth, cutoff)
        currents = predicted_currents(
            record, fit, load_torque, signals, Torques.read(input.torques), smooth, cutoff
        )
        known_maps = baselines(record, robot, np.array(friction["least_squares"]), signals)
        judged = scores(record, currents, known_maps, smooth)
        summary |= {"load": load, "extent": passed(motion, currents), "scores": judged}
    currents.write(output.currents)
    write_json(summary, output.summary)
