"""The map from motion to motor current: torque constants and friction, from `fit` recordings."""

from dataclasses import replace
from typing import Any

from ur5lib.errors import reason
from ur5lib.pipeline.current_prior import controllers_ratio, prior_of
from ur5lib.pipeline.current_samples import current_record, smoother
from ur5lib.pipeline.friction_fit import ContradictionError, friction_summary, require_no_stop_sign
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_json, write_json


def fit_friction(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    model, smooth = robot.fullest_model(), smoother(params.order, params.cutoff_hz)
    records, ratios = [], []
    named = zip(params.recordings, params.dates, strict=True)
    files = zip(named, input.signals, input.motion, input.torques, strict=True)
    for (name, day), *paths in files:
        signals, motion = Signals.read(paths[0]), Motion.read(paths[1])
        record = current_record(name, signals, motion, Torques.read(paths[2]), model)
        if record is not None:
            records.append(replace(record, day=day))
            ratios.append(controllers_ratio(signals, motion))
    summary: dict[str, Any] = {"from": []}
    found = zip(params.recordings, map(read_json, input.contradictions), strict=True)
    try:
        require_no_stop_sign(dict(found))
        prior = prior_of(robot, ratios)
        summary = friction_summary(records, prior, smooth, params.terms) | {"model": model}
    except ContradictionError as sign:
        summary["stopped"] = sign.remark
    except ValueError as error:
        summary["refused"] = reason(error)
    write_json(summary, output.friction)
