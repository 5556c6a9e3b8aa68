"""On which links the contacts of a recording may be: whether its forces are those of the flange."""

from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.force_estimates import fmap_problem
from ur5lib.pipeline.records.contacts import Detected, TouchedLinks
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.touched_links import located
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def locate_contacts(input: Any, output: Any, params: Any) -> None:
    motion, currents = Motion.read(input.motion), Currents.read(input.currents)
    detected = read_record(dict[str, Detected], input.detection)
    problem = fmap_problem(motion, currents, read_record(Residuals, input.residuals))
    found = list[TouchedLinks]()
    if problem is not None and "Fmap" in detected and (raised := detected["Fmap"].raised):
        known = load_robot(input.arm), problem.input, motion.time, problem.model
        found = [*located(*known, ContactPrior(), raised)]
    write_json({"Fmap": found}, output.links)
