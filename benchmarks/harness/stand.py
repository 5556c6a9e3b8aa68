"""Recordings of the virtual test stand, read like real ones, and fits to them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.residual_model import Residuals
from ur5lib.identification.controllers_torques import rotor_samples
from ur5lib.identification.current_samples import (
    ZeroPhaseLowpass,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.identification.rotor_inertia import fitted_rotors
from ur5lib.identification.samples import CurrentSamples
from ur5lib.recordings.entries import RtdeFiles, ThesisFiles
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.carried import carried
from ur5lib.records.clocks import OwnClock
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.friction import Friction
from ur5lib.records.models import Rotors
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.imu_calibration import ImuRecord
from ur5lib.signals.imu_samples import imu_samples
from ur5lib.signals.own_clocks import own_clocks
from ur5lib.signals.resampling import resample
from ur5lib.smoothing.encoders import SmoothedJoints, smooth_encoders
from ur5lib.smoothing.smoothed_motion import measured, motion_record
from ur5lib.stand.plan import POSTURE, SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.stand.truth import TrueParameters, Truth
from ur5lib.steps.compute_torques import joint_torques
from ur5lib.steps.fit_friction import fitted_friction
from ur5lib.steps.fit_residuals import residual_models
from ur5lib.steps.identify_model import commanded
from ur5lib.steps.predict_currents import predicted_currents
from ur5lib.study.model import Settings
from ur5lib.tables import read_record
from ur5lib.timeseries.lowpass import Butterworth

SETTINGS = Settings()
CURRENTS, ACCELERATIONS, MOTIONS = (
    Butterworth(own.order, own.cutoff_hz)
    for own in (SETTINGS.lowpass.currents, SETTINGS.lowpass.accelerations, SETTINGS.lowpass.motion)
)
SECONDS = 20.0
MOTION = {"kind": "fourier", "period_s": 20, "harmonics": 10}  # as the default study's fast ones
PUSHES = [
    {"kind": "push", "start_s": start, "seconds": 2, "force": force}
    for start, force in ((3, [40, 0, 0]), (7, [0, -40, 0]), (11, [0, 0, 40]), (15, [20, 20, 20]))
]


@dataclass(frozen=True)
class Taken:
    """A simulated recording as it was read, and the truth's two files."""

    robot: Robot
    intake: Intake
    summary: TrueParameters
    truth: Truth

    @cached_property
    def signals(self) -> Signals:
        """Return all signals on the robot's clock, an IMU placed by its own."""
        if "imu" not in self.intake.sensors:
            return Signals.from_table(self.intake.robot)
        time = self.intake.robot["time"].to_numpy()
        imu = resample(self.intake.sensors["imu"], self.clock, time)
        return Signals.from_table(pd.concat([self.intake.robot, imu], axis="columns"))

    @cached_property
    def kinematics(self) -> Kinematics:
        """Return pose and Jacobian at the measured positions."""
        robot = Signals.from_table(self.intake.robot)
        return Kinematics.of(robot.time, *flange_kinematics(self.robot, robot.actual_q))

    @cached_property
    def clock(self) -> OwnClock:
        """Return the clock of the IMU."""
        robot, starts = Signals.from_table(self.intake.robot), self.intake.quality.starts
        frames = self.kinematics.rotation, self.kinematics.jacobian
        return own_clocks(starts, self.intake.sensors, robot, *frames)["imu"]

    @cached_property
    def smoothed(self) -> SmoothedJoints:
        """Return the smoothed encoder data."""
        return smooth_encoders(self.signals.time, self.signals.segment, *measured(self.signals))

    @cached_property
    def motion(self) -> Motion:
        """Return the motion by the ZeroPhaseLowpass."""
        return motion_record(self.signals, self.smoothed)

    @cached_property
    def torques(self) -> Torques:
        """Return the torques of all link models."""
        return joint_torques(self.robot, carried(None, self.signals), self.signals, self.motion)

    @cached_property
    def record(self) -> CurrentSamples:
        """The smoothed motion, its torque by the true model, and the measured current."""
        name = f"seed {self.summary.plan.seed}"
        own = {"signals": self.signals, "motion": self.motion, "torques": self.torques}
        record = current_record(AlignedRecording(name=name, **own), self.robot)
        assert record is not None
        return record

    @cached_property
    def imu(self) -> ImuRecord:
        """Return the data of IMU and joints that determine its mounting."""
        return imu_samples(self.robot, self.signals, self.kinematics, ACCELERATIONS)


def taken(plan: dict[str, Any], folder: Path) -> Taken:
    """A recording of a UR5 with an IMU, simulated in a folder, and read as a real one is."""
    entry = ThesisFiles(format="thesis-csv", folder=str(folder))
    return simulated(load_robot(robot_path("ur5")), plan | {"imu": {}}, entry)


def simulated(robot: Robot, plan: dict[str, Any], entry: ThesisFiles | RtdeFiles) -> Taken:
    """A recording simulated as an entry's files, and read as a real one is."""
    folder = Path(entry.folder)
    wanted, truth = SimulatedRecording.model_validate(plan), folder / "truth"
    simulate(robot, wanted, entry.format, folder, truth)
    intake = read_and_repair(entry, robot, SETTINGS.frames.max_gap_s)
    true = read_record(TrueParameters, f"{truth}.json"), Truth.read(f"{truth}.parquet")
    return Taken(robot, intake, *true)


def plans(seed: int, seconds: float = SECONDS) -> list[dict[str, Any]]:
    """Three recordings to fit, and one that is pushed, each about another posture."""
    drawn = []
    for draw in range(100 * seed, 100 * seed + 4):
        posture = POSTURE + np.random.default_rng(draw).uniform(-0.4, 0.4, 6)
        trajectory = MOTION | {"draw": draw, "posture": posture.tolist()}
        drawn.append({"trajectory": trajectory, "seed": draw, "seconds": seconds})
    return [*drawn[:3], drawn[3] | {"contacts": PUSHES}]


def rotors(recordings: list[Taken]) -> Rotors:
    """Rotor inertias from the residual of rigid links in the controller's torque at the targets."""
    runs = {own.record.name: commanded(own.robot, own.signals, own.motion) for own in recordings}
    return fitted_rotors({name: rotor_samples(run, MOTIONS) for name, run in runs.items()})


def fitted_map(recordings: list[Taken], others: list[Taken] | None = None) -> Friction:
    """The map from motion to current; others: recordings that show the controller's constants."""
    known = [*recordings, *(others or [])]
    ratios = [controllers_ratio(own.signals, own.motion) for own in known]
    prior = prior_of(known[0].robot, ratios)
    records = [own.record for own in recordings]
    return fitted_friction(records, prior, ZeroPhaseLowpass(*CURRENTS))


def currents(friction: Friction, own: Taken) -> Currents:
    """External torques, by the fit without the recording's path."""
    fit, no_load = friction.fit_for(own.record.name), 0 * own.record.q
    return predicted_currents(own.record, fit, no_load, own.torques, ZeroPhaseLowpass(*CURRENTS))


def residuals_of(friction: Friction, free: list[Taken]) -> Residuals:
    """The residual torque without contact."""
    known = [(currents(friction, own), own.motion) for own in free]
    return residual_models(known, friction, CURRENTS.cutoff)
