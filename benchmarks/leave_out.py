"""False alarms and currents along paths and on days that no fit has seen.

    python -m benchmarks.leave_out [<study> [<robot>]] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. Each path of the recordings
to fit on is left out in turn, with its day if other days have enough paths: friction, residual
model and threshold come from the other recordings, by the workflow's own steps, and what was left
out is treated as a recording to validate on, and pushed. Then each recording to fit on is the only
one. Alarms are counted on recordings without contact, loaded or not: all of them are false. The
largest force in an alarm is given in its standard deviations. Of each joint, the share of the
current inside its band, by what the joint does, too, with the factor of the band that would hold
95 %, and by how much friction in motion differs from the predicted one. The
rigid-body model stays the study's: the controller's own torque tells it, not the currents.
`--quick` does a part of all this.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
import yaml

from benchmarks.harness.options import arm_options, built
from ur5lib.errors import InputError
from ur5lib.force.alarms import alarms_of, peak_of
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.estimators import LEADING, all_stated
from ur5lib.force.external_torque import REST_SPEED
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.smallest_pushes import FELT_SIZE, by_motion, detectable
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import Trials
from ur5lib.identification.current_samples import FitSettings, ZeroPhaseLowpass, current_record
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.payload import PayloadEstimate
from ur5lib.identification.samples import (
    INDEPENDENT_STEP,
    MotionState,
    apart_from,
    motion_states,
    path_of,
)
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.table import Table
from ur5lib.robots.description import load_robot
from ur5lib.steps.estimate_forces import estimate_forces
from ur5lib.steps.estimate_load import estimate_load
from ur5lib.steps.fit_friction import fit_friction
from ur5lib.steps.fit_residuals import fit_residuals
from ur5lib.steps.measure_pushes import trials_on, untouched
from ur5lib.steps.predict_currents import predict_currents
from ur5lib.steps.set_threshold import set_threshold
from ur5lib.study.model import Settings
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.timeseries.trajectories import group_by_path

TABLES: dict[str, type[Table]] = {
    "signals": Signals,
    "motion": Motion,
    "torques": Torques,
    "kinematics": Kinematics,
}
ALARMS = ["recording", "estimate", "alarms", "minutes", "in_alarm", "deviations", "date"]
MOVES = 2.0  # s; friction is judged if a joint moves for at least this time


@dataclass(frozen=True)
class Recording:
    """One recording of a built study: as the study describes it, and its files."""

    entry: dict[str, Any]
    folder: Path
    path: int

    @property
    def day(self) -> str:
        """The recording's date, "" if the study gives none."""
        return str(self.entry.get("date") or "")

    @property
    def name(self) -> str:
        """The recording's name in the study."""
        return str(self.entry["name"])

    def file(self, name: str) -> str:
        """Path of the study's file of the recording."""
        return str(self.folder / name)

    def premises(self) -> Premises:
        """Return the premises of its torques."""
        return read_record(Premises, self.file("premises.json"))

    def opened(self, **known: Any) -> Any:
        """Return the study's results of the recording; known: fields to use instead."""
        loads: dict[str, Callable[[], Any]] = {
            name: partial(kind.read, self.file(f"{name}.parquet")) for name, kind in TABLES.items()
        }
        loads["premises"] = self.premises
        loads["quality"] = partial(read_record, Quality, self.file("quality.json"))
        stated = {"name": self.name, "date": self.day, "gravity": self.entry.get("gravity")}
        stated |= {"chain": (), "before": {}}
        return Opened(loads, **stated | known)

    def sensed(self) -> Array:
        """Return the sensor's wrench (N, 6), bias and tool removed; empty without a sensor."""
        found = SensorWrenches.read(self.file("sensor.parquet")).wrench
        return found.get("compensated", np.empty((0, 6)))


@dataclass(frozen=True)
class Study:
    """Recordings of one arm without contact, and the settings of all steps."""

    arm: Path
    settings: Settings
    recordings: list[Recording]

    @property
    def fit(self) -> list[Recording]:
        """Return the recordings to fit."""
        return [own for own in self.recordings if own.entry["role"] == "fit"]

    @property
    def lowpass(self) -> Butterworth:
        """Order and cut-off of the low-pass on currents and torques."""
        settings = self.settings.lowpass.currents
        return Butterworth(settings.order, settings.cutoff_hz)


Tried = tuple[str, list[Recording], list[Recording]]  # label, to fit on, to try


def main() -> None:
    """Print alarms a minute, and the errors of predicted currents."""
    given = arm_options(__doc__).parse_args()
    [folder] = built([Path("results") / given.study])
    torch.set_num_threads(1)
    compare(f"{given.study}, {given.robot}", read_study(folder, given.robot), given.quick)


def compare(title: str, known: Study, quick: bool) -> None:
    """Leave out path after path, or day after day, then all recordings except one."""
    few = 1 if quick else None
    folds = without_each(known)[:few]
    folds.append(("all recordings to fit on", known.fit, unseen(known, known.fit)))
    alone = [
        (f"{own.name} alone", [own], [one for one in known.recordings if one.path != own.path])
        for own in known.fit[:few]
    ]
    print(f"{title}: {len(known.fit)} recordings to fit on")
    joints: list[dict[str, Any]] = []
    states: list[pd.DataFrame] = []
    trials: list[Trials] = []
    for fold, tested in built_folds("paths and days left out", known, folds):
        joints += [row for own in tested for row in predicted(fold, own)]
        states += [held_by_state(fold, own) for own in tested]
        trials += [found for own in tested if (found := pushed_on(fold, own)) is not None]
    if any(len(own.force) for own in trials):
        report_pushes(Trials.joined(trials))
    with pd.option_context("display.max_rows", None, "display.width", 120):
        report_joints(pd.DataFrame(joints))
    report_states(pd.concat(states))
    for _ in built_folds("one recording to fit on", known, alone):
        pass


def read_study(folder: Path, robot: str, roles: Sequence[str] = ("fit", "validate")) -> Study:
    """The recordings of an arm with some roles, by default those without contact."""
    plan = yaml.safe_load((folder / "configuration.yaml").read_text())
    entries = [
        entry for entry in plan["recordings"] if entry["robot"] == robot and entry["role"] in roles
    ]
    if not entries:
        arms = sorted({entry["robot"] for entry in plan["recordings"]})
        raise SystemExit(f"{folder}: no {robot} was recorded; name an arm: {', '.join(arms)}")
    folders = [folder / "recordings" / entry["name"] for entry in entries]
    motions = [Motion.read(own / "motion.parquet") for own in folders]
    labels = group_by_path([path_of(own.q, own.qd, own.period) for own in motions]).tolist()
    recordings = [*map(Recording, entries, folders, labels)]
    settings = Settings.model_validate(plan["settings"])
    return Study(folder / "parameters" / robot / "arm.yaml", settings, recordings)


def without_each(study: Study) -> list[Tried]:
    """Yield for each left-out part its label, the fitted recordings and the tried ones."""
    path = np.array([own.path for own in study.fit])
    _, day = np.unique([own.day for own in study.fit], return_inverse=True)
    kept = {tuple(apart_from(path == one, path, day)): one for one in np.unique(path)}
    found, always = [], {own.name for own in unseen(study, study.fit)}
    for seen in kept:
        fitted = [own for own, used in zip(study.fit, seen, strict=True) if used]
        left = " ".join(own.name for own in study.fit if own not in fitted)
        tested = [own for own in unseen(study, fitted) if own.name not in always]
        found.append((f"without {left}", fitted, tested))
    return found


def unseen(study: Study, fitted: list[Recording]) -> list[Recording]:
    """Recordings that share neither path nor (if dated) day with the fitted ones."""
    paths, days = {own.path for own in fitted}, {own.day for own in fitted} - {""}
    return [own for own in study.recordings if own.path not in paths and own.day not in days]


class Fold:
    """The workflow's steps from friction to threshold, fitted only to some recordings."""

    def __init__(self, study: Study, fitted: list[Recording], folder: Path) -> None:
        self.study, self.fitted, self.folder = study, fitted, folder
        self.arm = load_robot(study.arm)

    def own(self, recording: Recording, name: str) -> str:
        """Path of this fold's file of a recording."""
        return str(self.folder / f"{recording.name}.{name}")

    def shared(self, name: str) -> str:
        """Path of this fold's file of all recordings."""
        return str(self.folder / name)

    @property
    def friction(self) -> Friction:
        """The friction fitted to the fold's recordings."""
        return read_record(Friction, self.shared("friction.json"))

    def predict(self, tested: list[Recording]) -> None:
        """Fit, and predict the currents of all recordings; raises InputError if it is refused."""
        friction = fit_friction(
            arm=self.arm,
            recordings={own.name: own.opened() for own in self.fitted},
            postures={},
            dates={own.name: own.day for own in self.fitted},
            fit_settings=FitSettings(self.study.lowpass),
        )
        write_json(friction, self.shared("friction.json"))
        for own in [*self.fitted, *tested]:
            self.payload(own)
        for own in [*self.fitted, *tested]:
            self.currents(own, "fit" if own in self.fitted else "validate")
        self.residuals()

    def of_fitted(self, kind: type[Table], file: str) -> dict[str, Any]:
        """The study's table of each fitted recording."""
        return {own.name: kind.read(own.file(file)) for own in self.fitted}

    def estimate(self, tested: list[Recording]) -> None:
        """Estimate the forces of all recordings from their predicted currents."""
        for own in [*self.fitted, *tested]:
            self.forces(own)
        published = [own.folder / "published_forces.parquet" for own in self.fitted]
        threshold = set_threshold(
            forces={own.name: Forces.read(self.own(own, "forces.parquet")) for own in self.fitted},
            signals=self.of_fitted(Signals, "signals.parquet"),
            residuals=read_record(Residuals, self.shared("residuals.json")),
            arm=self.arm,
            false_alarms_per_min=self.study.settings.alarms.false_per_min,
            further=self.of_fitted(FurtherForces, "published_forces.parquet")
            if all(path.exists() for path in published)
            else None,
        )
        write_json(threshold, self.shared("threshold.json"))

    def residuals(self) -> None:
        """Fit the model of the residual torque to the fitted recordings."""
        residuals = fit_residuals(
            friction=self.friction,
            currents={
                own.name: Currents.read(self.own(own, "currents.parquet")) for own in self.fitted
            },
            motion=self.of_fitted(Motion, "motion.parquet"),
            kinematics=self.of_fitted(Kinematics, "kinematics.parquet"),
            arm=self.arm,
            contact_force_n=self.study.settings.contact.force_n,
            cutoff_hz=self.study.lowpass.cutoff,
        )
        write_json(residuals, self.shared("residuals.json"))

    def payload(self, own: Recording) -> None:
        """Estimate the load of a recording from its currents."""
        write_json(estimate_load(own.opened(), **self.known()), self.own(own, "payload.json"))

    def load_of(self, own: Recording) -> PayloadEstimate:
        """Return the estimated load of a recording."""
        return read_record(PayloadEstimate, self.own(own, "payload.json"))

    def currents(self, own: Recording, role: str) -> None:
        """Compute the external torque of a recording."""
        untouched = own.entry.get("untouched")
        stated = {"role": role, "untouched": None if untouched is None else tuple(untouched)}
        predicted = predict_currents(
            own.opened(**stated),
            payload=self.load_of(own),
            unloaded={other.name: self.load_of(other) for other in self.fitted},
            **self.known(),
        )
        predicted.currents.write(self.own(own, "currents.parquet"))
        write_json(predicted.prediction, self.own(own, "currents.json"))

    def forces(self, own: Recording) -> None:
        """Compute all estimates of a recording's forces."""
        forces = estimate_forces(
            own.opened(currents=Currents.read(self.own(own, "currents.parquet"))),
            residuals=read_record(Residuals, self.shared("residuals.json")),
            **self.known(),
            contact_force_n=self.study.settings.contact.force_n,
        )
        forces.write(self.own(own, "forces.parquet"))

    def known(self) -> dict[str, Any]:
        """The common arguments of all steps on currents."""
        return {"friction": self.friction, "arm": self.arm, "lowpass": self.study.lowpass}

    def alarms(self, tested: list[Recording]) -> pd.DataFrame:
        """A row for each recording and estimate: alarms, minutes, minutes in alarm, and the largest
        force of an alarm in its standard deviations.
        """
        thresholds = read_record(dict[str, float], self.shared("threshold.json"))
        rows = []
        for own in tested:
            forces = Forces.read(self.own(own, "forces.parquet"))
            minute = forces.period / 60
            estimates = all_stated(forces, {})
            for name in forces.log_odds:
                # Without this estimate in fitted recordings, the threshold is log-odds 0.
                found = alarms_of(estimates[name], thresholds.get(name, 0.0))
                lasted = sum(last - first for first, last in found.raised) * minute
                peaks = [peak_of(span, found) for span in found.raised]
                force, std = found.wrench[peaks, :3], found.std[peaks, :3]
                most = np.abs(force / std).max(initial=0.0)
                rows.append(
                    [
                        own.name,
                        name,
                        len(peaks),
                        len(found.evidence) * minute,
                        lasted,
                        most,
                        own.day,
                    ]
                )
        return pd.DataFrame(rows, columns=ALARMS)


def pushed_on(fold: Fold, own: Recording) -> Trials | None:
    """Trial pushes on a recording without contact or load, found at the fold's threshold."""
    forces = Forces.read(fold.own(own, "forces.parquet"))
    odds = forces.log_odds.get(LEADING)
    residuals = read_record(Residuals, fold.shared("residuals.json"))
    motion, currents = Motion.read(own.file("motion.parquet")), fold.own(own, "currents.parquet")
    problem = fmap_problem(motion, Currents.read(currents), residuals)
    loaded = read_record(Prediction, fold.own(own, "currents.json")).is_loaded
    if problem is None or odds is None or loaded:
        return None
    settings = fold.study.settings
    place, force = own.premises().place, settings.contact.force_n
    threshold = read_record(dict[str, float], fold.shared("threshold.json")).get(LEADING, 0.0)
    kinematics = Kinematics.read(own.file("kinematics.parquet"))
    prior = ContactPrior.of(fold.arm, force, place)
    run = untouched(problem, kinematics, place, alarms(odds, threshold))
    return trials_on(problem, run, prior, threshold, settings.pushes.per_arm // 9)


def report_pushes(trials: Trials) -> None:
    """Print the pushes found with 95 %, over all axes, without those that joints do not feel."""
    most = float(trials.force.max())
    for motion, own in by_motion(trials):
        limit, felt = detectable(own, most), int(own.felt(FELT_SIZE * most).sum())
        if limit.value is not None:
            error = "" if limit.std_error is None else f" ± {limit.std_error:.1f}"
            print(
                f"push of 1 s {motion}, found with 95 %: {limit.bound}{limit.value:.1f}{error} N "
                f"({felt} trials, and {len(own.force) - felt} where joints hardly feel any)",
                flush=True,
            )


def report_alarms(label: str, found: pd.DataFrame) -> None:
    """Print a line for each estimate, and one for each recording with alarms."""
    print(label)
    for name, part in found.groupby("estimate"):
        count, minutes, lasted = part[["alarms", "minutes", "in_alarm"]].sum()
        print(
            f"{name:>12}: {count / minutes:5.2f} alarms a minute ({count:.0f} in {minutes:.1f} "
            f"min), in alarm {lasted / minutes:.0%} of the time",
            flush=True,
        )
        for own in part[part["alarms"] > 0].itertuples():
            line = f"{'':>14}{own.alarms} on {own.recording}, {60 * own.in_alarm:.1f} s"
            stated = f", force up to {own.deviations:.1f} deviations"
            print(line + (stated if np.isfinite(own.deviations) else ""))


def refusal(fold: Fold, tested: list[Recording]) -> str | None:
    """Predict a fold's currents; return the reason if there are no forces, else None."""
    try:
        fold.predict(tested)
    except (InputError, np.linalg.LinAlgError) as error:
        return str(error)
    friction = read_record(Friction, fold.shared("friction.json"))
    residuals = read_record(Residuals, fold.shared("residuals.json"))
    refusals = (friction.refused, residuals.refused)
    return next((one.sentence() for one in refusals if one is not None), None)


def built_folds(
    title: str, study: Study, tried: list[Tried]
) -> Iterator[tuple[Fold, list[Recording]]]:
    """Yield built folds with their tried recordings; print all alarms, or why there are none."""
    found = []
    for label, fitted, tested in tried:
        with tempfile.TemporaryDirectory() as folder:
            fold = Fold(study, fitted, Path(folder))
            if why := refusal(fold, tested):
                print(f"{label}\n{'':>14}no forces: {why}", flush=True)
                continue
            fold.estimate(tested)
            found.append(fold.alarms(tested))
            report_alarms(label, found[-1])
            yield fold, tested
    if found:
        report_alarms(f"{title}, all together", pd.concat(found))


def predicted(fold: Fold, own: Recording) -> Iterator[dict[str, Any]]:
    """Yield for each joint the current's share inside its band, and the excess of friction."""
    currents = Currents.read(fold.own(own, "currents.parquet"))
    summary = read_record(Prediction, fold.own(own, "currents.json"))
    if "fitted" not in summary.scores:
        return
    excess = friction_excess(currents, Motion.read(own.file("motion.parquet")))
    if summary.is_loaded:  # its friction in the gears differs
        excess[:] = np.nan
    about = {"day": own.day, "recording": own.name, "samples": len(currents.time)}
    for joint, inside in enumerate(summary.scores["fitted"].coverage):
        yield about | {"joint": joint + 1, "inside": inside, "excess": excess[joint]}


def held_by_state(fold: Fold, own: Recording) -> pd.DataFrame:
    """Each sample's current error / half-width of its band, with joint, state and day."""
    currents = Currents.read(fold.own(own, "currents.parquet"))
    if currents.external_torque is None:
        return pd.DataFrame()
    record = current_record(own.opened(), fold.arm)
    assert record is not None
    state = motion_states(record, ZeroPhaseLowpass(*fold.study.lowpass))
    error = currents.external_torque / torque_constants(fold.friction.fit_for(own.name))
    columns = {"of_band": np.abs(error) / currents.band, "state": state}
    every = max(1, round(INDEPENDENT_STEP / record.period))
    rows = pd.DataFrame({name: values[::every].ravel() for name, values in columns.items()})
    joint = np.tile(np.arange(1, state.shape[1] + 1), len(rows) // state.shape[1])
    known = rows.assign(joint=joint, day=own.day or own.name).dropna()
    return known.replace({"state": {one.value: one.name.lower() for one in MotionState}})


def report_states(rows: pd.DataFrame) -> None:
    """Print by state the share inside the band, the share on the worst day, and by joint the
    multiple of the band that contains 95 %.
    """
    for state, own in rows.groupby("state"):
        inside = own["of_band"] <= 1.0
        of_days = inside.groupby(own["day"]).mean()
        factors = own["of_band"].groupby(own["joint"]).quantile(0.95).round(2).tolist()
        print(
            f"{state}: {inside.mean():.3f} inside, least {of_days.min():.3f} on "
            f"{of_days.idxmin()}, 95 % within {factors} of the band",
            flush=True,
        )


def friction_excess(currents: Currents, motion: Motion) -> Array:
    """Return s (6,) of τ_ext = c - s τ_friction by least squares, NaN if a joint moves too little.

    Friction of (1 + s) times its prediction appears as such an external torque.
    """
    excess = np.full(6, np.nan)
    assert currents.external_torque is not None
    assert currents.friction_torque is not None
    for joint in range(6):
        torque, friction = currents.external_torque[:, joint], currents.friction_torque[:, joint]
        rows = (np.abs(motion.motor_qd[:, joint]) > REST_SPEED) & np.isfinite(torque + friction)
        if rows.sum() * motion.period >= MOVES:
            columns = np.column_stack([-friction[rows], np.ones(rows.sum())])
            excess[joint] = np.linalg.lstsq(columns, torque[rows])[0][0]
    return excess


def report_joints(rows: pd.DataFrame) -> None:
    """Print a line for each recording and joint, and the spread of friction over them."""
    for name, digits in (("inside", 2), ("excess", 3)):
        table = rows.pivot_table(name, ["day", "recording"], "joint", dropna=False)
        print(f"\n{name}\n{table.dropna(how='all').round(digits)}")
    samples = rows["samples"].where(rows["inside"].notna())
    weighted = (rows["inside"] * samples).groupby(rows["joint"]).sum()
    print(
        "inside, all recordings",
        (weighted / samples.groupby(rows["joint"]).sum()).round(3).tolist(),
        f"least {rows['inside'].min():.2f}",
    )
    square = rows["excess"] ** 2
    of_days = np.sqrt(square.groupby(rows["day"]).mean())
    print(
        f"friction differs by {np.sqrt(square.mean()):.1%} (root mean square), on the most "
        f"different day by {of_days.max():.1%}, at most by {rows['excess'].abs().max():.1%}",
        flush=True,
    )


if __name__ == "__main__":
    main()
