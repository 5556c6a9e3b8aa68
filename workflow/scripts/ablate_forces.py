"""Ablation of the force estimate: its error in contact without one part."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.force_ablation import figures_in_contact, variants
from ur5lib.pipeline.force_estimates import fmap_problem
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.force_errors import Ablated
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.pipeline.records.motion import Motion
from ur5lib.tables import read_record, write_json


def ablate_forces(input: Any, output: Any, params: Any) -> None:
    sensor, forces = SensorWrenches.read(input.sensor), Forces.read(input.forces)
    summary = dict[str, Ablated]()
    if "compensated" in sensor.wrench and "Fmap" in forces.wrench:
        reference = sensor.wrench["compensated"][:, :3]
        motion, currents = Motion.read(input.motion), Currents.read(input.currents)
        prior = ContactPrior(force=params.contact_force_n)
        fmap = fmap_problem(motion, currents, read_record(Residuals, input.residuals))
        assert fmap is not None
        jacobian = Kinematics.read(input.kinematics, fmap.rows).jacobian
        estimates = {"whole": (forces.wrench["Fmap"], forces.std["Fmap"])}
        estimates |= variants(fmap, jacobian, prior, reference)
        estimates["least_squares"] = forces.wrench["least_squares"], forces.std["least_squares"]
        summary = {name: figures_in_contact(*own, reference) for name, own in estimates.items()}
    write_json(summary, output.ablation)
