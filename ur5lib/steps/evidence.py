"""All that is known of a recording when it is judged."""

from pathlib import Path
from typing import NamedTuple

import pandas as pd

from ur5lib.force.residual_model import Residuals
from ur5lib.records.closed_loop import ClosedLoop
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, LiveForces, PublishedForces
from ur5lib.records.friction import Friction
from ur5lib.records.gains import GainSummary
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, Vector3
from ur5lib.thesis.published_constants import PublishedConstants
from ur5lib.timeseries.lowpass import Butterworth


class Evidence(NamedTuple):
    """All that is known of a recording and its arm.

    force: samples of its sensor on its own clock; threshold: of the evidence of contact by
    estimate; mounting: place [m] and turn [°] of the force sensor as the study states them. Of the
    thesis's methods, None where the study has no published values.
    """

    recording: str
    role: str
    quality: Quality
    force: pd.DataFrame
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    alignment: Alignment
    torques: Torques
    premises: Premises
    currents: Currents
    prediction: Prediction
    forces: Forces
    live: LiveForces
    arm: Robot
    friction: Friction
    residuals: Residuals
    threshold: dict[str, float]
    currents_lowpass: Butterworth
    contact_force_n: float
    bias_window_s: float
    min_singular_value: float
    mounting: tuple[Vector3 | None, Vector3 | None] = (None, None)
    gravity: list[float] | None = None
    closed_loop: ClosedLoop | None = None
    gains: GainSummary | None = None
    published: PublishedForces | None = None
    constants: PublishedConstants | None = None
    reference: Path | None = None

    @property
    def robot(self) -> Robot:
        """Return the arm under the recording's gravity."""
        return self.arm.mounted(self.gravity)
