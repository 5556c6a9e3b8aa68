"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.force.wrench_estimate import used_rows
from ur5lib.pipeline import force_estimates
from ur5lib.pipeline.estimators import ESTIMATORS, Run
from ur5lib.recordings.quality import Contradictions
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    known = read_record(Friction, input.friction), read_record(Contradictions, input.contradictions)
    shared = _fitted if force_estimates.is_fitted(*known) else _static
    # opened anew: nothing is loaded but what a lab's own estimator asks for
    opened = Motion.read(input.motion), Currents.read(input.currents)
    controller = Signals.read(input.signals).wrench_calc_from_currents
    run = Run(*opened, Kinematics.read(input.kinematics), controller, **shared(input, params))
    found = {name: one.estimate(run) for name, one in ESTIMATORS.items()}
    rest = run.background, run.causal_odds
    del run  # of a long recording, either all inputs are held or all results
    Forces.of(Motion.read(input.motion), found, *rest).write(output.forces)


def _static(input: Any, params: Any) -> dict[str, Any]:
    from ur5lib.pipeline.static_forces import static_forces  # slow, and most arms are fitted

    signals, jacobian = Signals.read(input.signals), Kinematics.read(input.kinematics).jacobian
    known = signals, Motion.read(input.motion), Torques.read(input.torques), jacobian
    return {"static": static_forces(load_robot(input.arm), *known, params.order, params.cutoff_hz)}


def _fitted(input: Any, params: Any) -> dict[str, Any]:
    motion, currents = Motion.read(input.motion), Currents.read(input.currents)
    residuals = read_record(Residuals, input.residuals)
    problem = force_estimates.fmap_problem(motion, currents, residuals)
    jacobian = Kinematics.read(input.kinematics, used_rows(motion.segment, motion.period)).jacobian
    prior = ContactPrior(force=params.contact_force_n)
    causal = force_estimates.causal_odds(motion, currents, residuals, jacobian, prior)
    return {"fmap": problem and problem.solve(jacobian, prior), "causal_odds": causal}
