"""Recordings of the real arms, taken through the workflow's steps up to the contact force.

Studies are the workflow's own. Of one that another test has built, what its steps wrote is taken up
to the fit; else arms are as they are described, and what takes seconds, the smoother and fits of
currents, is kept in a folder for all tests of a session.
"""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import pandas as pd
import yaml

from tests.conftest import PROJECT
from tests.entries import read_and_check
from ur5lib.commands.check import look_through, settled
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.sensor import SensorOffset
from ur5lib.force.sensor_reading import OwnClock, moved_tool, sensor_reading
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.identification.current_samples import (
    ZeroPhaseLowpass,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import CurrentSamples, Smooth
from ur5lib.recordings.intake import Intake
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.carried import carried
from ur5lib.records.clocks import ClockRelation
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.resampling import by_stamps, resample
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import measured, motion_record
from ur5lib.steps.compute_torques import joint_torques
from ur5lib.steps.fit_friction import fitted_friction
from ur5lib.steps.fit_residuals import residual_models
from ur5lib.steps.judge_sensor import sensor_wrenches
from ur5lib.steps.predict_currents import predicted_currents
from ur5lib.study.model import Recording, Settings, Study
from ur5lib.study.reading import parse_study
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth

PRIOR = ContactPrior(15.0)


@dataclass(frozen=True)
class RealRecording:
    """A recording as far as it has to do with no other: signals, motion, torques.

    arm_file: the arm's description; motion_file: where its smoothed motion is kept; built: its
    results, where the workflow built them; sensor_clock: of its force sensor, if any.
    """

    entry: Recording
    settings: Settings
    arm_file: Path
    motion_file: Path
    built: Path | None = None
    sensor_clock: ClockRelation | None = None

    @property
    def name(self) -> str:
        return self.entry.name

    @cached_property
    def robot(self) -> Robot:
        return load_robot(self.arm_file).mounted(self.entry.gravity)

    @cached_property
    def intake(self) -> Intake:
        max_gap = self.settings.frames.max_gap_s
        return read_and_check(self.entry, self.robot, max_gap)

    @cached_property
    def signals(self) -> Signals:
        """With the force sensor, where its clock is known."""
        if self.built is not None:
            return Signals.read(self.built / "signals.parquet")
        table = self.intake.robot
        if self.sensor_clock is not None:
            time = table["time"].to_numpy()
            sensor = resample(self.intake.sensors["force"], self.sensor_clock, time)
            table = pd.concat([table, sensor], axis="columns")
        return Signals.from_table(table)

    @cached_property
    def motion(self) -> Motion:
        if not self.motion_file.exists():
            signals = self.signals
            motion = smooth_encoders(signals.time, signals.segment, *measured(signals))
            motion_record(signals, motion).write(self.motion_file)
        return Motion.read(self.motion_file)

    @cached_property
    def torques(self) -> Torques:
        if self.built is not None:
            return Torques.read(self.built / "torques.parquet")
        load = carried(self.entry.known_payload(), self.signals)
        return joint_torques(self.robot, load, self.signals, self.motion)

    @cached_property
    def kinematics(self) -> Kinematics:
        if self.built is not None:
            return Kinematics.read(self.built / "kinematics.parquet")
        frames = flange_kinematics(self.robot, self.signals.actual_q)
        return Kinematics.of(self.signals.time, *frames)

    @cached_property
    def record(self) -> CurrentSamples:
        """What its currents are fitted on."""
        own = {"signals": self.signals, "motion": self.motion, "torques": self.torques}
        record = current_record(AlignedRecording(name=self.name, **own), self.robot)
        assert record is not None
        return record

    @cached_property
    def sensor(self) -> tuple[Array, SensorOffset]:
        """Contact wrench (N, 6) by the force sensor, and what was taken off its reading."""
        signals = self.signals
        assert self.sensor_clock is not None
        start = self.intake.quality.starts["force"]
        moved = moved_tool(self.robot, self.kinematics, self.motion)
        clock_std = self.sensor_clock.std_after(signals.time[-1] - signals.time[0])
        window = self.settings.sensor.bias_window_s
        device = self.intake.sensors["force"]
        placed, step = by_stamps(device, start, signals.time, "force"), device["time"].diff().mean()
        own = OwnClock(placed, clock_std, float(step))
        reading = sensor_reading(self.robot, signals, moved, window, own=own)
        wrenches = sensor_wrenches(self.robot, signals, reading, self.kinematics.rotation)
        return wrenches.wrench["compensated"], reading.offset


def workflow_study(name: str, data: Path) -> Study:
    """A study of the workflow, whose recordings lie in a folder of their own."""
    path = PROJECT / "workflow" / "studies" / f"{name}.yaml"
    raw = yaml.safe_load(path.read_text())
    raw.pop("reference", None)
    for recording in raw["recordings"]:
        recording["folder"] = recording["folder"].replace(f"raw/{name}", str(data))
    return parse_study(raw, str(path))


class RealStudy:
    """A study with what its recordings give."""

    def __init__(self, study: Study, kept: Path) -> None:
        """kept: where smoothed motion and fits are put."""
        self.study, self.kept = study, kept
        self.entries = {recording.name: recording for recording in self.study.recordings}
        self.recording = cache(self._recording)

    @cached_property
    def built(self) -> Path | None:
        """The results of the study, where the workflow built it for another test."""
        folder = self.kept.parent / self.study.study / "results" / self.study.study
        return folder if folder.exists() else None

    def names(self, *roles: str) -> list[str]:
        """Of the recordings with these roles."""
        return [name for name, entry in self.entries.items() if entry.role in roles]

    def recordings(self, names: Sequence[str]) -> list[RealRecording]:
        return [self.recording(name) for name in names]

    def _recording(self, name: str) -> RealRecording:
        entry, settings = self.entries[name], self.study.settings
        if self.built is not None:
            arm = self.built / "parameters" / entry.robot / "arm.yaml"
            its = self.built / "recordings" / name
            clock = read_record(Alignment, its / "alignment.json").clocks.get("force")
            return RealRecording(entry, settings, arm, its / "motion.parquet", its, clock)
        arm, motion = robot_path(entry.robot), self.kept / self.study.study / f"{name}.parquet"
        return RealRecording(entry, settings, arm, motion, None, self.sensor_clocks.get(name))

    @cached_property
    def sensor_clocks(self) -> dict[str, ClockRelation]:
        """How each force sensor's clock runs: by stamps and by its host."""
        if not self.study.hosts:
            return {}
        looked = {name: look_through(entry, self.study) for name, entry in self.entries.items()}
        parts = ({name: own[k] for name, own in looked.items()} for k in (0, 1))
        found = settled(self.study, *parts)
        return {name: own["force"] for name, own in found.items() if "force" in own}

    @property
    def currents_lowpass(self) -> Butterworth:
        design = self.study.settings.lowpass.currents
        return Butterworth(design.order, design.cutoff_hz)

    @property
    def smooth(self) -> Smooth:
        return ZeroPhaseLowpass(*self.currents_lowpass)

    @property
    def motion_lowpass(self) -> Butterworth:
        design = self.study.settings.lowpass.motion
        return Butterworth(design.order, design.cutoff_hz)

    def prior(self, names: Sequence[str]) -> Prior:
        """Of torque constants, by what the controller shows in some recordings."""
        ones = self.recordings(names)
        ratios = [controllers_ratio(one.signals, one.motion) for one in ones]
        return prior_of(ones[0].robot, ratios)

    def fitted(self, names: Sequence[str], shown: Sequence[str] = ()) -> "Fitted":
        """What is fitted to some recordings alone, none of which has a contact.

        shown: those that show the controller's torque constants, by default the same.
        """
        ones = self.recordings(names)
        key = zlib.crc32(repr((names, shown)).encode())
        file = self.kept / self.study.study / f"friction_{key}.json"
        if self.built is not None and not shown and names == self.names("fit"):
            file = self.built / "parameters" / ones[0].entry.robot / "friction.json"
        elif not file.exists():
            records = [one.record for one in ones]
            prior = self.prior(shown or names)
            write_json(fitted_friction(records, prior, self.smooth), file)
        return Fitted(ones, read_record(Friction, file), self.currents_lowpass)


@dataclass(frozen=True)
class Fitted:
    """Torque constants and friction of some recordings, and what they leave without contact.

    Who is judged by a fit is of no path that the fit has seen.
    """

    recordings: list[RealRecording]
    friction: Friction
    lowpass: Butterworth

    @cached_property
    def whole(self) -> CurrentFit:
        """The fit of all of them."""
        return self.friction.fit

    @cached_property
    def residuals(self) -> Residuals:
        """Residual models of the external torques."""
        known = [(self.currents(one), one.motion) for one in self.recordings]
        return residual_models(known, self.friction, self.lowpass.cutoff)

    def currents(self, one: RealRecording) -> Currents:
        """Prediction and external torques; no load is looked for."""
        fit, no_load = self.friction.fit_for(one.name), 0 * one.record.q
        return predicted_currents(
            one.record, fit, no_load, one.torques, ZeroPhaseLowpass(*self.lowpass)
        )

    def problem(self, one: RealRecording) -> Problem:
        """Of Fmap."""
        found = fmap_problem(one.motion, self.currents(one), self.residuals)
        assert found is not None
        return found

    def torque(self, one: RealRecording) -> Array:
        """External torque (N, 6) [Nm]."""
        return self.problem(one).input.torque

    def estimate(
        self, one: RealRecording, extra: Array | float = 0.0, prior: ContactPrior = PRIOR
    ) -> WrenchEstimate:
        """Fmap; extra: (N, 6) [Nm], put onto the external torque."""
        known = self.problem(one)
        given = replace(known.input, torque=known.input.torque + extra)
        pushed = known._replace(input=given)
        return pushed.solve(one.kinematics.jacobian[pushed.rows], prior)
