"""Residual models of the external torque without contact."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.force.wrench_estimate import used_rows
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.residual_fit import residual_models, usual_residuals, with_trials
from ur5lib.tables import read_record, write_json


def fit_residuals(input: Any, output: Any, params: Any) -> None:
    friction = read_record(Friction, input.friction)
    residuals = Residuals()
    if friction.from_:
        files = zip(input.currents, input.motion, strict=True)
        recordings = [(Currents.read(currents), Motion.read(motion)) for currents, motion in files]
        residuals = residual_models(recordings, friction, params.cutoff_hz)
        with_jacobians = [
            (*own, Kinematics.read(path, used_rows(own[1].segment, own[1].period)).jacobian)
            for own, path in zip(recordings, input.kinematics, strict=True)
        ]
        prior = ContactPrior(force=params.contact_force_n)
        residuals = with_trials(residuals, with_jacobians, prior)
    elif friction.fit.joints:
        residuals = usual_residuals(friction.fit, params.cutoff_hz)
    write_json(residuals, output.residuals)
