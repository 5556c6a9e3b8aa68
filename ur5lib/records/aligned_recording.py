"""A recording on one clock, with its motion and the torques of link models."""

from collections.abc import Mapping, Sequence

import pandas as pd

from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.motion import Alignment, Motion, motions_before
from ur5lib.records.opened import Opened
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals


class AlignedRecording(Opened):
    """A recording on the robot's clock, with its motion, before its currents are predicted.

    role, date (ISO 8601, or empty): as the study states them; gravity: in the arm's base frame
    [m/s²], None for that of the description; untouched: span [s] in which nothing touches the
    resting arm; chain: names of the earlier recordings, oldest first; before: the motions of these;
    force, imu: the samples of these devices on their own clocks.
    """

    role: str
    date: str = ""
    gravity: list[float] | None = None
    untouched: tuple[float, float] | None = None
    chain: Sequence[str] = ()

    quality: Quality
    force: pd.DataFrame
    imu: pd.DataFrame
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    before: Mapping[str, Motion]
    alignment: Alignment
    torques: Torques
    premises: Premises

    def earlier(self) -> list[Motion]:
        """Return the motions of the earlier recordings, oldest first, as far as each ends where the
        next begins.
        """
        return motions_before(self.motion, self.chain, self.before) if self.chain else []
