"""A recording on one clock, with its motion and the torques of link models."""

from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.signals import Signals


class AlignedRecording(Opened):
    """A recording on the robot's clock, with its motion and the torques that this needs."""

    name: str
    signals: Signals
    motion: Motion
    torques: Torques
