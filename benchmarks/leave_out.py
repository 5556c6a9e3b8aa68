"""False alarms and currents along paths and on days that no fit has seen.

    python -m benchmarks.leave_out [<study> [<robot>]] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. Each path of the recordings
to fit on is left out in turn, with its day if other days have enough paths: friction, residual
model and threshold come from the other recordings, by the workflow's own steps, and what was left
out is treated as a recording to validate on. Then each recording to fit on is the only one. Alarms
are counted on recordings without contact, loaded or not, those from past currents alone
(`causal`) too: all of them are false. The largest force
in an alarm is given in its standard deviations. Of each joint, the share of the current inside its
band, and by how much friction in motion differs from the predicted one. The rigid-body model stays
the study's: the controller's own torque tells it, not the currents.
`--quick` does a part of all this.
"""

import runpy
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import torch
import yaml

from benchmarks.harness.options import arm_options, built
from ur5lib.errors import InputError
from ur5lib.force.external_torque import REST_SPEED
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.samples import apart_from, path_of
from ur5lib.records.currents import Currents
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.report.page.findings import in_words
from ur5lib.steps.judge_contacts import alarms_by_odds, live_alarms, strongest
from ur5lib.study.model import Settings
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.trajectories import group_by_path

STEPS = [
    "fit_friction",
    "estimate_payload",
    "predict_currents",
    "fit_residuals",
    "estimate_forces",
    "set_threshold",
]
TABLES = ("signals", "motion", "torques")
CHECKED = ("contradictions", "quality")
PAYLOAD = {"payload": "payload.json", "regressor": "load_regressor.parquet"}
ALARMS = ["recording", "estimate", "alarms", "minutes", "in_alarm", "deviations"]
MOVES = 2.0  # s, for which a joint moves at least where its friction is judged


@dataclass(frozen=True)
class Recording:
    """One recording of a built study: as the study describes it, and its files."""

    entry: dict[str, Any]
    folder: Path
    path: int

    @property
    def day(self) -> str:
        """Its date, empty where the study gives none."""
        return str(self.entry.get("date") or "")

    @property
    def name(self) -> str:
        """As in the study."""
        return str(self.entry["name"])

    def file(self, name: str) -> str:
        """Path of a file that the study made of it."""
        return str(self.folder / name)

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
    def lowpass(self) -> dict[str, Any]:
        """Order and cut-off behind currents and torques, as steps are given them."""
        return self.settings.lowpass.currents.model_dump()


Tried = tuple[str, list[Recording], list[Recording]]  # label, to fit on, to try


def main() -> None:
    """Print alarms a minute, and how currents are predicted."""
    given = arm_options(__doc__).parse_args()
    [folder] = built([Path("results") / given.study])
    torch.set_num_threads(1)
    compare(f"{given.study}, {given.robot}", read_study(folder, given.robot), given.quick)


def compare(title: str, known: Study, quick: bool) -> None:
    """Leave out path after path, or day after day, then all recordings but one."""
    few = 1 if quick else None
    folds = without_each(known)[:few]
    folds.append(("all recordings to fit on", known.fit, unseen(known, known.fit)))
    alone = [
        (f"{own.name} alone", [own], [one for one in known.recordings if one.path != own.path])
        for own in known.fit[:few]
    ]
    print(f"{title}: {len(known.fit)} recordings to fit on")
    joints: list[dict[str, Any]] = []
    for fold, tested in built_folds("paths and days left out", known, folds):
        joints += [row for own in tested for row in predicted(fold, own)]
    with pd.option_context("display.max_rows", None, "display.width", 120):
        report_joints(pd.DataFrame(joints))
    for _ in built_folds("one recording to fit on", known, alone):
        pass


def read_study(folder: Path, robot: str, roles: Sequence[str] = ("fit", "validate")) -> Study:
    """The recordings of an arm with some roles; by default those in which nothing touches it."""
    plan = yaml.safe_load((folder / "configuration.yaml").read_text())
    entries = [
        entry for entry in plan["recordings"] if entry["robot"] == robot and entry["role"] in roles
    ]
    folders = [folder / "recordings" / entry["name"] for entry in entries]
    motions = [Motion.read(own / "motion.parquet") for own in folders]
    labels = group_by_path([path_of(own.q, own.qd, own.period) for own in motions]).tolist()
    recordings = [*map(Recording, entries, folders, labels)]
    settings = Settings.model_validate(plan["settings"])
    return Study(folder / "parameters" / robot / "arm.yaml", settings, recordings)


def without_each(study: Study) -> list[Tried]:
    """What is left out together: label, recordings to fit on, and to try what only these miss."""
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
    """Recordings that share neither path nor, where the study has dates, day with these."""
    paths, days = {own.path for own in fitted}, {own.day for own in fitted} - {""}
    return [own for own in study.recordings if own.path not in paths and own.day not in days]


class Fold:
    """The workflow's steps from friction to threshold, fitted on some recordings alone."""

    def __init__(self, study: Study, fitted: list[Recording], folder: Path) -> None:
        self.study, self.fitted, self.folder = study, fitted, folder
        self.step = {name: step_of(name) for name in STEPS}

    def own(self, recording: Recording, name: str) -> str:
        """A file that this fold makes of a recording."""
        return str(self.folder / f"{recording.name}.{name}")

    def shared(self, name: str) -> str:
        """A file that this fold makes of all."""
        return str(self.folder / name)

    def predict(self, tested: list[Recording]) -> None:
        """Fit, and predict the currents of all recordings; raises InputError if it is refused."""
        lowpass = self.study.lowpass
        self.run(
            "fit_friction",
            {name: [own.file(f"{name}.parquet") for own in self.fitted] for name in TABLES}
            | {"arm": str(self.study.arm)}
            | {n: [own.file(f"{n}.json") for own in self.fitted] for n in CHECKED}
            | {"postures": []},
            {"friction": self.shared("friction.json")},
            lowpass
            | {"recordings": [own.name for own in self.fitted]}
            | {"dates": [own.day for own in self.fitted]},
        )
        for own in [*self.fitted, *tested]:
            self.payload(own)
        for own in [*self.fitted, *tested]:
            self.currents(own, "fit" if own in self.fitted else "validate")
        self.residuals()

    def estimate(self, tested: list[Recording]) -> None:
        """Estimate the forces of all recordings, whose currents are predicted."""
        for own in [*self.fitted, *tested]:
            self.forces(own)
        self.run(
            "set_threshold",
            {
                "forces": [self.own(own, "forces.parquet") for own in self.fitted],
                "published": [own.file("published_forces.parquet") for own in self.fitted],
            },
            {"threshold": self.shared("threshold.json")},
            {"false_alarms_per_min": self.study.settings.alarms.false_per_min},
        )

    def residuals(self) -> None:
        """What the external torque of the fitted recordings is without contact."""
        self.run(
            "fit_residuals",
            {
                "friction": self.shared("friction.json"),
                "currents": [self.own(own, "currents.parquet") for own in self.fitted],
                "motion": [own.file("motion.parquet") for own in self.fitted],
            },
            {"residuals": self.shared("residuals.json")},
            {"cutoff_hz": self.study.lowpass["cutoff_hz"]},
        )

    def payload(self, own: Recording) -> None:
        """What the currents tell of a load."""
        self.run(
            "estimate_payload",
            self.inputs_of(own),
            {name: self.own(own, file) for name, file in PAYLOAD.items()},
            self.study.lowpass | {"recording": own.name, "gravity": own.entry.get("gravity")},
        )

    def currents(self, own: Recording, role: str) -> None:
        """The external torque of a recording."""
        self.run(
            "predict_currents",
            self.inputs_of(own)
            | {name: self.own(own, file) for name, file in PAYLOAD.items()}
            | {
                "load": own.file("torques.json"),
                "contradictions": own.file("contradictions.json"),
                "unloaded": [self.own(other, "payload.json") for other in self.fitted],
            },
            {
                "currents": self.own(own, "currents.parquet"),
                "summary": self.own(own, "currents.json"),
            },
            self.study.lowpass
            | {"recording": own.name, "role": role, "untouched": own.entry.get("untouched")},
        )

    def forces(self, own: Recording) -> None:
        """All estimates of a recording's forces."""
        self.run(
            "estimate_forces",
            self.inputs_of(own)
            | {
                "contradictions": own.file("contradictions.json"),
                "kinematics": own.file("kinematics.parquet"),
                "currents": self.own(own, "currents.parquet"),
                "residuals": self.shared("residuals.json"),
            },
            {"forces": self.own(own, "forces.parquet")},
            {
                "contact_force_n": self.study.settings.contact.force_n,
                "cutoff_hz": self.study.lowpass["cutoff_hz"],
            },
        )

    def inputs_of(self, own: Recording) -> dict[str, Any]:
        """What both steps on currents read."""
        tables = {name: own.file(f"{name}.parquet") for name in TABLES}
        return tables | {"friction": self.shared("friction.json"), "arm": str(self.study.arm)}

    def run(self, name: str, *files_and_params: dict[str, Any]) -> None:
        """A step with its input, output and params."""
        self.step[name](*(SimpleNamespace(**own) for own in files_and_params))

    def alarms(self, tested: list[Recording]) -> pd.DataFrame:
        """A row for each recording and estimate: alarms, minutes, of them minutes in alarm, and the
        largest force of an alarm in its standard deviations.
        """
        thresholds = read_record(dict[str, float], self.shared("threshold.json"))
        rows = []
        for own in tested:
            forces = Forces.read(self.own(own, "forces.parquet"))
            minute = forces.period / 60
            for name in forces.log_odds:
                # Where no fitted recording has this estimate, contact is what is the likelier.
                found = alarms_by_odds(forces, name, thresholds.get(name, 0.0))
                lasted = sum(last - first for first, last in found.raised) * minute
                stated = [strongest(span, forces.time, found) for span in found.raised]
                most = max((np.abs(s.force / s.force_std).max() for s in stated), default=0.0)
                rows.append(
                    [own.name, name, len(stated), len(found.evidence) * minute, lasted, most]
                )
            if (odds := forces.causal_log_odds) is not None:
                raised = live_alarms(odds, thresholds.get("causal", 0.0))
                lasted = sum(last - first for first, last in raised) * minute
                rows.append([own.name, "causal", len(raised), len(odds) * minute, lasted, np.nan])
        return pd.DataFrame(rows, columns=ALARMS)


def step_of(name: str) -> Any:
    """A step's function, from the workflow's script."""
    script = Path(__file__).parents[1] / "workflow" / "scripts" / f"{name}.py"
    return runpy.run_path(str(script))[name]


def report_alarms(label: str, found: pd.DataFrame) -> None:
    """A line for each estimate, and one for each recording with alarms."""
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
    """Predict a fold's currents; return why there are no forces, None where there are."""
    try:
        fold.predict(tested)
    except (InputError, np.linalg.LinAlgError) as error:
        return str(error)
    friction = read_record(Friction, fold.shared("friction.json"))
    residuals = read_record(Residuals, fold.shared("residuals.json"))
    return next(map(in_words, filter(None, (friction.refused, residuals.refused))), None)


def built_folds(
    title: str, study: Study, tried: list[Tried]
) -> Iterator[tuple[Fold, list[Recording]]]:
    """Folds whose files are there, and what is tried in each; prints all alarms, or why none is."""
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
    """Of each joint, the current's share inside its band, and the excess of friction in motion."""
    currents = Currents.read(fold.own(own, "currents.parquet"))
    summary = read_record(Prediction, fold.own(own, "currents.json"))
    if "fitted" not in summary.scores:
        return
    excess = friction_excess(currents, Motion.read(own.file("motion.parquet")))
    if summary.is_loaded:  # its friction in the gears is another
        excess[:] = np.nan
    about = {"day": own.day, "recording": own.name, "samples": len(currents.time)}
    for joint, inside in enumerate(summary.scores["fitted"].coverage):
        yield about | {"joint": joint + 1, "inside": inside, "excess": excess[joint]}


def friction_excess(currents: Currents, motion: Motion) -> Array:
    """Return s (6,) of τ_ext = c - s τ_friction by least squares, NaN where a joint hardly moves.

    Friction that is stronger than predicted by the share s is an external torque against it.
    """
    excess = np.full(6, np.nan)
    for joint in range(6):
        torque, friction = currents.external_torque[:, joint], currents.friction_torque[:, joint]
        rows = (np.abs(motion.motor_qd[:, joint]) > REST_SPEED) & np.isfinite(torque + friction)
        if rows.sum() * motion.period >= MOVES:
            columns = np.column_stack([-friction[rows], np.ones(rows.sum())])
            excess[joint] = np.linalg.lstsq(columns, torque[rows])[0][0]
    return excess


def report_joints(rows: pd.DataFrame) -> None:
    """Print by recording and joint, and the spread of friction over recordings and joints."""
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
