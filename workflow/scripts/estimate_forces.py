"""Contact wrench from the external torque, with its band and the odds that there is a contact."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.wrench_estimate import WrenchEstimate, used_rows
from ur5lib.pipeline.force_estimates import (
    direct_problems,
    force_record,
    repeat_problem,
    repeated_runs,
)
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import Motion
from ur5lib.tables import read_json


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    # read anew, so that of a long recording either all inputs are held or all results
    force_record(Motion.read(input.motion), _estimates(input, params)).write(output.forces)


def _estimates(input: Any, params: Any) -> dict[str, WrenchEstimate]:
    motion, currents = Motion.read(input.motion), Currents.read(input.currents)
    found = direct_problems(motion, currents, read_json(input.residuals))
    rows = used_rows(motion.segment, motion.period)
    jacobian = Kinematics.read(input.kinematics, rows).jacobian
    if "Fmap" in found:
        index, load = read_json(input.free_runs), read_json(input.load).get("load")
        files = repeated_runs(found["Fmap"].input, params.recording, load, index)
        alike = ((Currents.read(currents), Motion.read(motion)) for currents, motion in files)
        if repeat := repeat_problem(found["Fmap"], alike, params.cutoff_hz):
            found["repeat"] = repeat
    prior = ContactPrior(force=params.contact_force_n)
    return {name: problem.solve(jacobian, prior) for name, problem in found.items()}
