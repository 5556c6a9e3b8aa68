"""The mass on the flange beyond the arm's model and known payload, from motor currents alone."""

from operator import attrgetter
from typing import Any

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.identification import payload
from ur5lib.identification.samples import smoothed_moving
from ur5lib.pipeline.current_samples import Smoother, current_record
from ur5lib.records.currents import LoadRegressor
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def estimate_payload(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm).mounted(params.gravity)
    friction = read_record(Friction, input.friction)
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    model = robot.fullest_model()
    record = current_record(params.recording, signals, motion, Torques.read(input.torques), model)
    per_load, found = None, payload.PayloadEstimate()
    if record is not None and friction.from_:
        # read anew, so that a long recording's accelerations are not held throughout
        states = attrgetter("q", "qd", "qdd")
        per_load = load_regressor(robot, model, *states(Motion.read(input.motion)))
        smooth = Smoother(params.order, params.cutoff_hz)
        if smoothed_moving(record, smooth).any():  # at rest, friction hides a load
            fit = friction.fit_for(params.recording)
            found = payload.estimate_payload(fit, record, per_load, smooth)
    regressor = LoadRegressor(time=motion.time, segment=motion.segment, load_regressor=per_load)
    regressor.write(output.regressor)
    write_json(found, output.payload)
