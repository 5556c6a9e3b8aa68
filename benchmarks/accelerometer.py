"""What an accelerometer on the flange is worth for the force: with it and without, side by side.

    python -m benchmarks.accelerometer [<seeds>] [--quick]

The same chain runs on two motions, that of the encoders and that of encoders and IMU, each with
friction and residual model of its own; a third row takes over the friction of the encoders. On the
virtual test stand, a fourth has the true motion: no accelerometer can be worth more. Each seed is
an arm of `stand_seeds`: three recordings to fit on, and one that is pushed. Then the contact-free
recordings of results/thesis that have an IMU, where any torque and force is an error. Rotor
inertias are fitted at the targets and so are the same for all motions. Adds to
results/accelerometer.csv the seeds that it lacks, so that a run may be interrupted, and prints the
differences with their 95 % intervals.
"""

import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
import yaml
from scipy import stats

from benchmarks.harness.options import asked
from benchmarks.stand_seeds import SECONDS, SEEDS, SETTINGS, Taken, plans, taken
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import in_contact, is_free
from ur5lib.force.external_torque import SETTLING, finite_rows, joint_states
from ur5lib.identification.samples import Record, path_of
from ur5lib.pipeline.carried import Carried, carried
from ur5lib.pipeline.current_prediction import predicted_currents
from ur5lib.pipeline.current_samples import Smoother, controllers_ratio, current_record, prior_of
from ur5lib.pipeline.force_estimates import fmap_problem
from ur5lib.pipeline.friction_fit import fitted_friction
from ur5lib.pipeline.fused_motion import fused_record, imu_model
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.dynamics import Kinematics, Torques
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import FusedMotion, Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.residual_fit import residual_models
from ur5lib.pipeline.smoothed_motion import measured
from ur5lib.pipeline.torques import joint_torques
from ur5lib.robots.description import Payload, Robot, load_robot
from ur5lib.signals.imu_calibration import ImuCalibration, calibrate
from ur5lib.smoothing.imu_fusion import smooth_with_imu
from ur5lib.tables import read_csv, write_csv
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.trajectories import group_by_path

RESULTS = Path("results")
TABLE, THESIS = RESULTS / "accelerometer.csv", RESULTS / "thesis"
ENCODERS, FUSED, TRUE = "encoders", "encoders and IMU", "true motion"
BORROWED = f"{FUSED}, friction of the encoders"
LOWPASS = SETTINGS.lowpass.currents
SMOOTH = Smoother(LOWPASS.order, LOWPASS.cutoff_hz)
PRIOR = ContactPrior(force=SETTINGS.contact.force_n)
FIGURES = {  # column: what is printed
    "contact_n": "error of F^map in contact [N]",
    "false_n": "force by J^-T of what nothing caused [N]",
    "external_nm": "external torque without contact [Nm]",
    "motion_nm": "of it, from the error of the motion [Nm]",
}
IN_MOTION = {
    "moving_nm": "the external torque where no joint stands [Nm]",
    "moving_false_n": "the force by J^-T there [N]",
}


@dataclass(frozen=True)
class Run:
    """A recording, its motion by each estimate, and what it carries.

    robot: under the recording's gravity; model: of the links; jacobian: (N, 6, 6); fitted: whether
    friction is fitted to it; wrench: (N, 6) [N, Nm], the true one, zeros without contact.
    """

    name: str
    robot: Robot
    model: str
    load: Carried
    signals: Signals
    jacobian: Array
    motions: Mapping[str, Motion]
    fitted: bool
    wrench: Array

    def motion(self, name: str) -> Motion:
        """Return the motion by an estimate, that of the encoders where there is no other."""
        return self.motions.get(name, self.motions[ENCODERS])

    def torques(self, name: str) -> Torques:
        """Return the torques of all link models at a motion."""
        return joint_torques(self.robot, self.load, self.signals, self.motion(name))


@dataclass(frozen=True)
class Fitted:
    """A motion's name, the records (motion, torque, current) of some runs at it, and the fit to
    those to fit on.
    """

    motion: str
    records: list[Record]
    torques: list[Torques]
    friction: Friction

    def currents(self, runs: Sequence[Run]) -> list[Currents]:
        """Return the external torques of the runs, by fits without their paths."""
        return [
            predicted_currents(
                record, self.friction.fit_for(run.name), 0 * record.q, torques, SMOOTH
            )
            for run, record, torques in zip(runs, self.records, self.torques, strict=True)
        ]


def main() -> None:
    """Print what an IMU changes on the stand and on the thesis's recordings."""
    seeds, quick = asked(__doc__, SEEDS)
    torch.set_num_threads(1)
    if quick:
        show_stand(pd.DataFrame(seed_rows(0, 5.0)))
    else:
        show_stand(stand_table(seeds))
    if (THESIS / "configuration.yaml").exists():
        show_thesis(pd.DataFrame(thesis_rows(THESIS)))
    else:
        print(f"{THESIS} is not built: its recordings are left out")


def stand_table(seeds: int) -> pd.DataFrame:
    """Return the figures of the seeds, computing and writing those that are missing."""
    table = read_csv(TABLE) if TABLE.exists() else pd.DataFrame({"seed": []})
    for seed in sorted({*range(seeds)} - {*table["seed"]}):
        table = pd.concat([table, pd.DataFrame(seed_rows(seed, SECONDS))])
        write_csv(table, TABLE)
        print(f"seed {seed} of {seeds}", file=sys.stderr, flush=True)
    return table[table["seed"] < seeds]


def seed_rows(seed: int, seconds: float) -> Iterator[dict[str, Any]]:
    """Yield the figures of a seed's pushed recording, by motion."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = enumerate(plans(seed, seconds))
        own = [taken(plan, Path(folder, str(k))) for k, plan in drawn]
        calibration = calibrate([one.imu for one in own[:3]])
        runs = [simulated(one, calibration, fitted=k < 3) for k, one in enumerate(own)]
    for name, fitted in fits(runs, [ENCODERS, FUSED, TRUE]):
        *_, row = judged(runs, fitted)
        yield {"seed": seed, "motion": name} | row


def simulated(own: Taken, calibration: ImuCalibration, fitted: bool) -> Run:
    """Return a simulated recording with its motion by encoders, by encoders and IMU, and in truth.

    A rigid arm's links move as its motors do.
    """
    signals, truth = own.signals, own.truth.at(own.signals.time)
    model = imu_model(own.robot, own.kinematics, calibration, own.motion.qd)
    samples = signals.time, signals.segment, *measured(signals)
    fused = smooth_with_imu(*samples, signals.imu, model, own.smoothed.known())
    exact = {name: np.nan_to_num(getattr(truth, name)) for name in ("q", "qd", "qdd")}
    certain = {f"{name}_std": np.zeros_like(values) for name, values in exact.items()}
    perfect = Motion(
        time=signals.time,
        segment=signals.segment,
        motor_qd=exact["qd"],
        **exact,
        **certain,
    )
    return Run(
        own.record.name,
        own.robot,
        own.summary.model,
        carried(None, signals),
        signals,
        own.kinematics.jacobian,
        {ENCODERS: own.motion, FUSED: fused_record(signals, fused), TRUE: perfect},
        fitted,
        np.nan_to_num(truth.wrench),
    )


def fits(runs: Sequence[Run], motions: Sequence[str]) -> Iterator[tuple[str, Fitted]]:
    """Yield the friction fitted with each motion; with the IMU's, also that of the encoders."""
    known = {name: fit(runs, name) for name in motions}
    yield from known.items()
    own = known[FUSED]
    yield BORROWED, Fitted(FUSED, own.records, own.torques, known[ENCODERS].friction)


def fit(runs: Sequence[Run], name: str) -> Fitted:
    """Fit friction and torque constants at a motion."""
    torques = [run.torques(name) for run in runs]
    records = [
        record
        for run, own in zip(runs, torques, strict=True)
        if (record := current_record(run.name, run.signals, run.motion(name), own, run.model))
    ]
    seen = [run for run in runs if run.fitted]
    ratios = [controllers_ratio(run.signals, run.motion(name)) for run in seen]
    prior = prior_of(runs[0].robot, ratios)
    used = [record for record, run in zip(records, runs, strict=True) if run.fitted]
    friction = fitted_friction(used, prior, SMOOTH)
    return Fitted(name, records, torques, friction)


def judged(runs: Sequence[Run], fitted: Fitted) -> Iterator[dict[str, Any]]:
    """Yield the errors of each run: RMS of the six torques and of the force vector."""
    currents = fitted.currents(runs)
    motions = [run.motion(fitted.motion) for run in runs]
    friction = fitted.friction
    residuals = residual_models(
        [
            own
            for own, run in zip(zip(currents, motions, strict=True), runs, strict=True)
            if run.fitted
        ],
        friction,
        LOWPASS.cutoff_hz,
    )
    for run, record, own, motion in zip(runs, fitted.records, currents, motions, strict=True):
        assert own.external_torque is not None
        size = np.linalg.norm(run.wrench[:, :3], axis=1)
        touched, known = in_contact(size), finite_rows(own.external_torque)
        free = is_free(size, motion.period) & known
        row = {"recording": run.name, "external_nm": rms(own.external_torque[free])}
        row["false_n"] = rms(inverted(own.external_torque[free], run.jacobian[free]))
        states = joint_states(motion.motor_qd, motion.segment, motion.period)
        moves = free & (states < SETTLING).all(axis=1)
        row["moving_nm"] = rms(own.external_torque[moves])
        row["moving_false_n"] = rms(inverted(own.external_torque[moves], run.jacobian[moves]))
        if touched.any():
            fmap = fmap_problem(motion, own, residuals)
            assert fmap is not None
            found = fmap.solve(run.jacobian[fmap.rows], PRIOR).wrench
            row["contact_n"] = rms((found - run.wrench)[touched, :3])
        if TRUE in run.motions:
            ideal = run.torques(TRUE).measured[run.model]
            row["motion_nm"] = rms(SMOOTH(record.torque - ideal, record)[free])
        yield row


def inverted(torque: Array, jacobian: Array) -> Array:
    """Return the forces (M, 3) [N] by J⁻ᵀ of torques (N, 6) [Nm], away from singularities."""
    least = np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    firm = least >= SETTINGS.singularities.min_singular_value
    wrench = np.linalg.solve(jacobian[firm].mT, torque[firm][..., None])[..., 0]
    return np.asarray(wrench[:, :3])


def thesis_rows(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the figures of a built study's contact-free recordings with an IMU, by motion."""
    plan = yaml.safe_load((folder / "configuration.yaml").read_text())
    runs = [recorded(folder, own) for own in plan["recordings"] if own["role"] != "contact"]
    encoders = [run.motion(ENCODERS) for run in runs]
    paths = group_by_path([path_of(own.q, own.qd, own.period) for own in encoders])
    for name, fitted in fits(runs, [ENCODERS, FUSED]):
        rows = zip(runs, paths, judged(runs, fitted), strict=True)
        yield from (
            {"path": path, "motion": name} | row for run, path, row in rows if FUSED in run.motions
        )


def recorded(folder: Path, entry: Mapping[str, Any]) -> Run:
    """Return a contact-free recording of a built study."""
    own = folder / "recordings" / entry["name"]
    robot = load_robot(folder / "parameters" / entry["robot"] / "arm.yaml")
    signals, payload = Signals.read(own / "signals.parquet"), entry.get("payload")
    declared = Payload.model_validate(payload) if payload else None
    motions = {ENCODERS: Motion.read(own / "motion.parquet")}
    fused = FusedMotion.read(own / "fused_motion.parquet")
    if len(fused.time):
        motions[FUSED] = fused
    return Run(
        entry["name"],
        robot,
        robot.fullest_model(),
        carried(declared, signals),
        signals,
        Kinematics.read(own / "kinematics.parquet").jacobian,
        motions,
        entry["role"] == "fit",
        np.zeros((len(signals.time), 6)),
    )


def rms(values: Array) -> float:
    """Return the root mean square length of rows (N, M), NaN without any."""
    return float(np.sqrt((values**2).sum(axis=1).mean())) if len(values) else np.nan


def show_stand(table: pd.DataFrame) -> None:
    """Print the figures of the stand, and by how much they differ from those of the encoders."""
    print(f"virtual test stand, {table['seed'].nunique()} seeds")
    for column, title in FIGURES.items():
        print(title)
        show_differences(table.pivot_table(column, "seed", "motion", sort=False))


def show_thesis(table: pd.DataFrame) -> None:
    """Print the figures of each recording, and their differences, of which a path is a sample."""
    print(f"contact-free recordings of the thesis with an IMU, {table['path'].nunique()} paths")
    known = FIGURES | IN_MOTION
    for column in ("external_nm", "false_n", *IN_MOTION):
        print(known[column])
        each = table.pivot_table(column, "recording", "motion", sort=False)
        print(each.to_string(float_format="%.3f"))
        show_differences(table.pivot_table(column, "path", "motion", sort=False))


def show_differences(table: pd.DataFrame) -> None:
    """Print the mean of each motion, and its difference from that of the encoders.

    table: (samples, motions); the interval is Student's, of the paired differences.
    """
    for name in table.columns:
        line = f"{name:>42}: {table[name].mean():7.3f}"
        if name != ENCODERS:
            more = table[name] - table[ENCODERS]
            line += f", {more.mean():+.4f} ({interval(more.to_numpy())}) more"
        print(line)


def interval(values: Array) -> str:
    """Return the 95 % interval of the mean of values (N,), as text."""
    if len(values) < 2:
        return "one sample"
    half = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)
    return f"{values.mean() - half:+.4f} to {values.mean() + half:+.4f}"


if __name__ == "__main__":
    main()
