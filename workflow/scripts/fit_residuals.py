"""Residual models of the external torque without contact."""

from typing import Any

from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.residual_fit import residual_models, usual_residuals
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.tables import read_record, write_json


def fit_residuals(input: Any, output: Any, params: Any) -> None:
    friction = read_record(Friction, input.friction)
    residuals = Residuals()
    if friction.from_:
        files = zip(input.currents, input.motion, strict=True)
        recordings = [(Currents.read(currents), Motion.read(motion)) for currents, motion in files]
        residuals = residual_models(recordings, friction, params.cutoff_hz)
    elif friction.fit.joints:
        residuals = usual_residuals(friction.fit, params.cutoff_hz)
    write_json(residuals, output.residuals)
