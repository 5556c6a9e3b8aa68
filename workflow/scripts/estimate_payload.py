"""The mass on the flange beyond the arm's model and known payload, from motor currents alone."""

from dataclasses import asdict
from operator import attrgetter
from typing import Any

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.identification import payload
from ur5lib.identification.currents import fit_for
from ur5lib.identification.samples import smoothed_moving
from ur5lib.pipeline.current_samples import current_record, smoother
from ur5lib.pipeline.records.currents import LoadRegressor
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_json, write_json


def estimate_payload(input: Any, output: Any, params: Any) -> None:
    robot, friction = load_robot(input.arm).mounted(params.gravity), read_json(input.friction)
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    model = robot.fullest_model()
    record = current_record(params.recording, signals, motion, Torques.read(input.torques), model)
    per_load, summary = None, dict[str, Any]()
    if record is not None and friction["from"]:
        # read anew, so that a long recording's accelerations are not held throughout
        states = attrgetter("q", "qd", "qdd")
        per_load = load_regressor(robot, model, *states(Motion.read(input.motion)))
        smooth = smoother(params.order, params.cutoff_hz)
        if smoothed_moving(record, smooth).any():  # at rest, friction hides a load
            fit = fit_for(params.recording, friction)
            summary = asdict(payload.estimate_payload(fit, record, per_load, smooth))
    regressor = LoadRegressor(time=motion.time, segment=motion.segment, load_regressor=per_load)
    regressor.write(output.regressor)
    write_json(summary, output.payload)
