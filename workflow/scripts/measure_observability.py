"""The smallest push that is detected, and the speeds at which friction is predicted, of an arm."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.force_estimates import fmap_problem
from ur5lib.pipeline.observability import judged, observability, pushed
from ur5lib.records.arm_state import Observed
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.tables import read_record, write_rows


def measure_observability(input: Any, output: Any, params: Any) -> None:
    friction = read_record(Friction, input.friction)
    thresholds = read_record(dict[str, float], input.threshold)
    residuals = read_record(Residuals, input.residuals)
    prior, trials, errors = ContactPrior(force=params.contact_force_n), [], []
    files = input.motion, input.currents, input.kinematics, input.forces, input.loads
    for name, *paths in zip(params.recordings, *files, strict=True):
        currents, loaded = Currents.read(paths[1]), read_record(Prediction, paths[4]).is_loaded
        if currents.external_torque is None or loaded:
            continue
        motion = Motion.read(paths[0])
        errors.append(judged(motion, currents, friction.fit_for(name)))
        if "Fmap" in thresholds and (found := fmap_problem(motion, currents, residuals)):
            jacobian = Kinematics.read(paths[2]).jacobian
            odds = Forces.read(paths[3]).log_odds["Fmap"]
            trials.append(pushed(found, jacobian, prior, thresholds["Fmap"], odds))
    write_rows(Observed, [*observability(trials, errors)], output.observability)
