"""An arm with what was fitted to it."""

from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.opened import Opened
from ur5lib.robots.description import Robot


class ArmFits(Opened):
    """An arm and its fits.

    described, identified: the arm without and with its identified models.
    """

    described: Robot
    identified: Robot
    rotors: Rotors
    identification: Identification
    friction: Friction
