"""The map from motion to motor current: torque constants and friction, from `fit` recordings."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from ur5lib.errors import reason
from ur5lib.identification.at_rest import AtRest
from ur5lib.pipeline.current_samples import Smoother, controllers_ratio, current_record, prior_of
from ur5lib.pipeline.friction_fit import (
    ContradictionError,
    fitted_friction,
    require_no_stop_sign,
    require_single_runs,
)
from ur5lib.pipeline.postures import held_torque
from ur5lib.recordings.quality import Contradictions, Quality
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.postures import Postures
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def fit_friction(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    model, smooth = robot.fullest_model(), Smoother(params.order, params.cutoff_hz)
    found = [read_record(Contradictions, path) for path in input.contradictions]
    records, ratios = [], []
    named = zip(params.recordings, params.dates, found, strict=True)
    files = zip(named, input.signals, input.motion, input.torques, strict=True)
    for (name, day, doubts), *paths in files:
        signals, motion = Signals.read(paths[0]), Motion.read(paths[1])
        record = current_record(name, signals, motion, Torques.read(paths[2]), model)
        if record is not None:
            records.append(replace(record, day=day))
            ratios.append(controllers_ratio(signals, motion, doubts.odd_targets()))
    qualities = [read_record(Quality, path) for path in input.quality]
    contradictions = dict(zip(params.recordings, found, strict=True))
    at_rest = {Path(path).parent.name: read_record(Postures, path) for path in input.postures}
    contradictions |= {name: one.contradictions for name, one in at_rest.items()}
    held = [(held_torque(one, robot, model), one.current) for one in at_rest.values()]
    try:
        require_no_stop_sign(contradictions)
        require_single_runs(dict(zip(params.recordings, qualities, strict=True)))
        prior = replace(prior_of(robot, ratios), at_rest=AtRest.of(held))
        friction = fitted_friction(records, prior, smooth, model)
        friction = replace(friction, at_rest=[*at_rest])
    except ContradictionError as sign:
        friction = Friction(stopped=sign.remark)
    except ValueError as error:
        friction = Friction(refused=reason(error))
    write_json(friction, output.friction)
