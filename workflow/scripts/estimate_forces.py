"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.force.wrench_estimate import used_rows
from ur5lib.pipeline.estimators import ESTIMATORS, Run
from ur5lib.pipeline.force_estimates import (
    causal_odds,
    direct_problems,
    is_fitted,
    may_be_template,
    repeat_problem,
)
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.dynamics import Kinematics, Torques
from ur5lib.pipeline.records.forces import Forces
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.prediction import Prediction
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Contradictions
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    known = read_record(Friction, input.friction), read_record(Contradictions, input.contradictions)
    run = _fitted(input, params) if is_fitted(*known) else _static(input, params)
    found = {one.name: one.estimate(run) for one in ESTIMATORS}
    rest = run.background, run.causal_odds
    del run  # of a long recording, either all inputs are held or all results
    Forces.of(Motion.read(input.motion), found, *rest).write(output.forces)


def _static(input: Any, params: Any) -> Run:
    from ur5lib.pipeline.static_forces import static_forces  # slow, and most arms are fitted

    signals, jacobian = Signals.read(input.signals), Kinematics.read(input.kinematics).jacobian
    known = signals, Motion.read(input.motion), Torques.read(input.torques), jacobian
    found = static_forces(load_robot(input.arm), *known, params.order, params.cutoff_hz)
    return Run(static=found, controller=signals.wrench_calc_from_currents)


def _fitted(input: Any, params: Any) -> Run:
    motion, currents = Motion.read(input.motion), Currents.read(input.currents)
    residuals = read_record(Residuals, input.residuals)
    found = direct_problems(motion, currents, residuals)
    jacobian = Kinematics.read(input.kinematics, used_rows(motion.segment, motion.period)).jacobian
    if "Fmap" in found:
        known = found["Fmap"].input, read_record(Prediction, input.load)
        alike = [may_be_template(*known, read_record(Prediction, p)) for p in input.free_loads]
        files = zip(alike, input.free_currents, input.free_motion, strict=True)
        runs = ((Currents.read(free), Motion.read(moved)) for own, free, moved in files if own)
        found |= repeat_problem(found["Fmap"], runs, params.cutoff_hz)
    prior = ContactPrior(force=params.contact_force_n)
    causal = causal_odds(motion, currents, residuals, jacobian, prior)
    solved = {name: own.solve(jacobian, prior) for name, own in found.items()}
    return Run(solved, causal, controller=Signals.read(input.signals).wrench_calc_from_currents)
