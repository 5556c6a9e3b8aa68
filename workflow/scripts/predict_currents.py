"""The current that motion without contact needs, and the torque that is left for a contact."""

from dataclasses import replace
from typing import Any

from ur5lib.identification.payload import PayloadEstimate, judged_load
from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.current_prediction import baselines, predicted_currents, scores, with_load
from ur5lib.pipeline.current_samples import Smoother, current_record
from ur5lib.pipeline.tare import tared
from ur5lib.recordings.quality import Contradictions
from ur5lib.records.currents import Currents, LoadRegressor
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def predict_currents(input: Any, output: Any, params: Any) -> None:
    robot, friction = load_robot(input.arm), read_record(Friction, input.friction)
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    model = robot.fullest_model()
    # read anew where it is used, so that a long recording's torques are not held throughout
    record = current_record(params.recording, signals, motion, Torques.read(input.torques), model)
    currents = Currents(time=signals.time, segment=signals.segment)
    summary = Prediction(params.recording in friction.from_)
    stopped = read_record(Contradictions, input.contradictions).stop_signs
    if record is not None and friction.fit.joints and not stopped:
        smooth = Smoother(params.order, params.cutoff_hz)
        fit, load, load_torque = friction.fit_for(params.recording), None, 0 * record.q
        if (payload := read_record(PayloadEstimate, input.payload)).is_known:
            known = read_record(Carried, input.load)
            unloaded = [read_record(PayloadEstimate, path) for path in input.unloaded]
            may_be_taken = known.source != "study" and params.role != "fit"
            load = judged_load(payload, unloaded, friction.paths, known.mass, may_be_taken)
            if load.taken:
                load_torque = LoadRegressor.read(input.regressor).torque(payload.parameters)
        record, load_torque = with_load(record, load_torque, fit, smooth)
        currents = predicted_currents(record, fit, load_torque, Torques.read(input.torques), smooth)
        if params.untouched is not None:
            currents = tared(currents, motion, params.untouched, params.recording)
        known_maps = baselines(record, robot, friction.least_squares, signals)
        judged = scores(record, currents, known_maps, smooth)
        summary = replace(summary, load=load, scores=judged)
    currents.write(output.currents)
    write_json(summary, output.summary)
