"""From a URDF and two logs of a made-up industrial arm to its predicted torques, seed by seed.

As in docs/robots.md, its user knows axes, weight, gears and how the controller counts, but neither
links nor friction. Each seed draws all of them, a log of six Fourier motions, cut into recordings
to fit, and logs along other paths: of the same day, with friction that differs by 3 %, and of other
seasons, by 10 %, as the bands allow for. Printed are, by joint, the shares of low-passed torque
inside the 95 % band of its prediction, and the error relative to the torque's standard deviation,
beside that of least squares over links, rotors, offsets and friction.
"""

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pinocchio
import torch
import yaml
from scipy.signal import butter, filtfilt

from benchmarks.harness.abb_like import JOINTS, PERIOD, MadeUpArm, write_files
from benchmarks.harness.options import asked
from benchmarks.harness.stand import CURRENTS, MOTIONS, SETTINGS
from ur5lib.identification.current_samples import FitSettings
from ur5lib.identification.currents import RUN_TO_RUN_STD, SEASON, friction_std
from ur5lib.identification.payload import PayloadEstimate
from ur5lib.recordings.entries import ENTRY
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, robot_of
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.steps.align_recording import align_recording
from ur5lib.steps.compute_torques import compute_torques
from ur5lib.steps.estimate_load import estimate_load
from ur5lib.steps.fit_friction import fit_friction
from ur5lib.steps.identify_model import identify_model
from ur5lib.steps.predict_currents import PredictedCurrents, predict_currents
from ur5lib.steps.read_recording import read_recording
from ur5lib.tables import write_table
from ur5lib.timeseries.arrays import Array

SEEDS, FITTED, FEWEST = 20, 6, 3  # motions, each a recording
UNSEEN_LOGS = 4  # of each seed, on the fit's day and as many in other seasons
COLUMNS = ["time", "actual_q", "actual_torque"]
UNSEEN = {"same day": RUN_TO_RUN_STD, "other seasons": friction_std(SEASON)}
ANGLES_HZ, SLOW = 10.0, 0.02  # Hz, rad/s: of least squares


def main() -> None:
    """Print the figures of all seeds."""
    seeds, quick = asked(__doc__, SEEDS)
    torch.set_num_threads(1)
    motions, logs = (FEWEST, 1) if quick else (FITTED, UNSEEN_LOGS)
    rows = pd.DataFrame([row for seed in range(seeds) for row in figures(seed, motions, logs)])
    print(
        f"{seeds} seeds, {PERIOD * motions:g} s to fit, {logs} logs of {2 * PERIOD:g} s of each day"
    )
    table = rows.pivot_table("value", "quantity", "joint", aggfunc=in_words, sort=False)
    print(table.to_string())


def in_words(values: pd.Series) -> str:
    """Return the mean over all logs, and the least and most."""
    return f"{values.mean():.3f} ({values.min():.2f} to {values.max():.2f})"


class Log(NamedTuple):
    """A recording on a uniform grid; file: of its signals."""

    file: Path
    motion: Motion
    quality: Quality

    @property
    def signals(self) -> Signals:
        """Return the signals of the recording."""
        return Signals.read(self.file)


class Fit(NamedTuple):
    """An arm with fitted links, its friction, and the estimated loads of its recordings."""

    arm: Robot
    friction: Friction
    loads: Mapping[str, PayloadEstimate]


def figures(seed: int, motions: int, unseen: int) -> Iterator[dict[str, Any]]:
    """Yield the figures of one seed; unseen: number of logs of each day."""
    made = MadeUpArm(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        days = {f"{day} {k}": day for day in UNSEEN for k in range(unseen)}
        logs = {"fit": (motions, RUN_TO_RUN_STD)}
        logs |= {log: (2, UNSEEN[day]) for log, day in days.items()}
        write_files(made, seed, folder, logs)
        arm = described(made, folder)
        cuts = {
            f"part {k}": {"from_s": k * PERIOD, "to_s": (k + 1) * PERIOD} for k in range(motions)
        }
        fit = fitted(
            arm, {part: taken(arm, folder, "fit", part, cut) for part, cut in cuts.items()}
        )
        for log, day in days.items():
            scores = predicted(fit, taken(arm, folder, log, log, {})).prediction.scores["fitted"]
            size = np.sqrt(scores.rmse_lowpassed**2 / (1 - scores.r2))
            yield from by_joint(f"in band, {day}", scores.coverage)
            yield from by_joint(f"NRMSE, {day}", scores.rmse_lowpassed / size)
            yield from by_joint(f"of least squares, {day}", least_squares(made, folder, "fit", log))


def by_joint(quantity: str, values: Array) -> Iterator[dict[str, Any]]:
    """Yield values (6,) with their joints."""
    for joint, value in enumerate(values, start=1):
        yield {"joint": joint, "quantity": quantity, "value": value}


def described(made: MadeUpArm, folder: Path) -> Robot:
    """Return the arm of a URDF, completed with its user's knowledge."""
    robot, _ = robot_from_urdf(folder / "arm.urdf")
    return robot_of(made.as_described(robot.model_dump(mode="json", exclude_none=True)))


def taken(arm: Robot, folder: Path, log: str, name: str, cut: Mapping[str, float]) -> Log:
    """Return a part of a log as a recording, read as by the steps of the workflow."""
    entry = {"format": "table-csv", "folder": str(folder), "file": f"{log}.csv", "columns": COLUMNS}
    of_file = ENTRY.validate_python({**entry, **cut})
    read = read_recording(of_file, [folder / f"{log}.csv"], arm, SETTINGS.frames.max_gap_s)
    aligned = align_recording(read.robot, read.force, read.imu, read.clocks)
    write_table(aligned.signals, str(folder / f"{name}.parquet"))
    return Log(folder / f"{name}.parquet", aligned.motion, read.quality)


def fitted(arm: Robot, logs: Mapping[str, Log]) -> Fit:
    """Return the results of the workflow's steps on the fit recordings."""
    signals = {name: log.signals for name, log in logs.items()}
    motion = {name: log.motion for name, log in logs.items()}
    found = identify_model(arm, signals, motion, dict.fromkeys(logs), MOTIONS, CURRENTS)
    known = robot_of(yaml.safe_load(found.arm))
    recordings = {name: with_torques(known, log, "fit") for name, log in logs.items()}
    friction = fit_friction(known, recordings, {}, dict.fromkeys(logs, ""), FitSettings(CURRENTS))
    loads = {
        name: estimate_load(own, friction, known, CURRENTS) for name, own in recordings.items()
    }
    return Fit(known, friction, loads)


def with_torques(arm: Robot, log: Log, role: str) -> Any:
    """Return a recording with its torques, and without contradictions."""
    known: dict[str, Any] = {"name": log.file.stem, "role": role, "quality": log.quality}
    known |= {"signals": log.signals, "motion": log.motion, "gravity": None, "untouched": None}
    known |= {"date": "", "chain": (), "before": {}}
    of_torques: Any = Opened(**known)
    found = compute_torques(of_torques, arm, {"currents": CURRENTS.cutoff})
    assert not found.premises.contradictions.stop_signs, "the checks refuse a right recording"
    return Opened(**known, torques=found.torques, premises=found.premises)


def predicted(fit: Fit, log: Log) -> PredictedCurrents:
    """Return the prediction of a recording that no fit has seen."""
    recording = with_torques(fit.arm, log, "validate")
    load = estimate_load(recording, fit.friction, fit.arm, CURRENTS)
    return predict_currents(recording, load, fit.loads, fit.friction, fit.arm, CURRENTS)


def least_squares(made: MadeUpArm, folder: Path, fit: str, unseen: str) -> Array:
    """Return the NRMSE (6,) of least squares over all rows, divided by their shaft's torque."""
    columns, torque = shaft_rows(made, folder, fit)
    size = torque.std(axis=0)
    weighted = (columns / size[:, None]).reshape(-1, columns.shape[2]), (torque / size).ravel()
    found = np.linalg.lstsq(*weighted, rcond=1e-6)[0]
    columns, torque = shaft_rows(made, folder, unseen)
    error, true = ((torque - columns @ found), torque) @ made.counts.coupling()
    return np.asarray(error.std(axis=0) / true.std(axis=0))


def shaft_rows(made: MadeUpArm, folder: Path, log: str) -> tuple[Array, Array]:
    """Return columns (N, 6, P) of links, rotors, offsets and friction, and shafts' torques (N, 6)
    [Nm], all low-passed; derivatives are differences of low-passed angles.
    """
    table = pd.read_csv(folder / f"{log}.csv").to_numpy()
    rate, (angle, torque) = 1 / (table[1, 0] - table[0, 0]), np.split(table[:, 1:], 2, axis=1)
    shaft = lowpassed(angle / made.counts.gears, ANGLES_HZ, rate)
    speed = np.gradient(shaft, 1 / rate, axis=0)
    change = np.gradient(speed, 1 / rate, axis=0)
    turn, signs = np.linalg.inv(made.counts.coupling()), made.counts.directions
    q, qd, qdd = (signs * (values @ turn.T) for values in (shaft, speed, change))
    model = pinocchio.buildModelFromUrdf(str(folder / "arm.urdf"))
    data = model.createData()
    states = zip(q + made.counts.home, qd, qdd, strict=True)
    links = [pinocchio.computeJointTorqueRegressor(model, data, *one).copy() for one in states]
    own = change, np.ones_like(shaft), np.tanh(speed / SLOW), speed
    columns = [np.eye(JOINTS) * values[:, None] for values in own]
    rows = np.concatenate([turn.T * signs @ links, *columns], axis=2)
    return lowpassed(rows, CURRENTS.cutoff, rate), lowpassed(
        made.counts.gears * torque, CURRENTS.cutoff, rate
    )


def lowpassed(values: Array, cutoff: float, rate: float) -> Array:
    """Return values (N, ...), low-passed without delay; cutoff, rate: [Hz]."""
    return np.asarray(filtfilt(*butter(4, cutoff / (rate / 2)), values, axis=0))


if __name__ == "__main__":
    main()
