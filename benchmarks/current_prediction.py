"""Motor currents along real paths that no fit has seen: ours, least squares, and FIGAROH's.

    python -m benchmarks.current_prediction [<study> ...]

Takes results/<study> as built; by default `thesis` and `ur10e`. Currents of a recording are
predicted by fits without its path, and scored behind the study's low-pass. What runs of one path
differ by is a floor: no function of the motion can predict both of two runs better. Writes
results/current_prediction.csv, from which `make leaderboard` takes its table, and
results/figaroh/<study>_<robot>/ for `benchmarks/figaroh/identification.py`, whose answers are
scored, too, where they lie there already.
"""

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray

from benchmarks.harness.options import built, study_options
from benchmarks.harness.prediction import (
    CONSTANT,
    FIGAROH,
    FLOOR,
    LEAST_SQUARES,
    OURS,
    prediction_table,
)
from ur5lib.identification.current_samples import (
    Smoother,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.identification.samples import (
    Record,
    Smooth,
    record_paths,
    smoothed_moving,
)
from ur5lib.identification.validation import baseline_current, least_squares_coefficients
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot
from ur5lib.study.model import Settings
from ur5lib.tables import read_record, write_csv
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import DEAD_ZONE, starts
from ur5lib.timeseries.trajectories import nearest, place

RESULTS = Path("results")
TABLE, FOR_FIGAROH = RESULTS / "current_prediction.csv", RESULTS / "figaroh"
LEAST = 1.0  # s of samples, below which nothing is judged


@dataclass(frozen=True)
class Own:
    """A recording without contact: its record, our prediction (N, 6) [A], its accelerations (N, 6)
    [rad/s²], and the torque (N, 6) [Nm] of its payload, which differs between recordings.
    """

    record: Record
    predicted: Array
    qdd: Array
    payload_torque: Array
    ratio: Array
    fitted: bool


@dataclass(frozen=True)
class Known:
    """Contact-free recordings of an arm without an undeclared load, and labels of their paths."""

    name: str
    folder: Path
    robot: Robot
    smooth: Smooth
    runs: list[Own]
    paths: Labels

    def unseen(self) -> Iterator[tuple[int, list[Own], list[Own]]]:
        """Yield each path with the recordings to fit of the other paths, and those of this one."""
        for path in np.unique(self.paths):
            pairs = [*zip(self.runs, self.paths, strict=True)]
            fit = [own for own, label in pairs if own.fitted and label != path]
            yield int(path), fit, [own for own, label in pairs if label == path]


def main() -> None:
    """Write and print the errors."""
    given = study_options(__doc__).parse_args()
    folders = built(RESULTS / name for name in given.studies)
    arms = [arm for folder in folders for arm in read_arms(folder)]
    for arm in arms:
        write_samples(arm)
    table = pd.DataFrame([row for arm in arms for row in arm_rows(arm)])
    write_csv(table, TABLE)
    print(prediction_table(table))


def read_arms(folder: Path) -> Iterator[Known]:
    """Yield the arms of a built study."""
    plan = yaml.safe_load((folder / "configuration.yaml").read_text())
    lowpass = Settings.model_validate(plan["settings"]).lowpass.currents
    for name in dict.fromkeys(entry["robot"] for entry in plan["recordings"]):
        robot = load_robot(folder / "parameters" / name / "arm.yaml")
        entries = [own for own in plan["recordings"] if own["robot"] == name]
        found = [
            read_run(folder / "recordings" / own["name"], own["role"], robot) for own in entries
        ]
        runs = [own for own in found if own is not None]
        paths = record_paths([own.record for own in runs])
        smooth = Smoother(lowpass.order, lowpass.cutoff_hz)
        yield Known(
            f"{folder.name}_{name}", folder / "parameters" / name, robot, smooth, runs, paths
        )


def read_run(folder: Path, role: str, robot: Robot) -> Own | None:
    """Return a recording, None if it is touched, carries a load, or has no currents."""
    loaded = read_record(Prediction, folder / "currents.json").is_loaded
    if role == "contact" or loaded:
        return None
    signals = Signals.read(folder / "signals.parquet")
    motion = Motion.read(folder / "motion.parquet")
    torques = Torques.read(folder / "torques.parquet")
    predicted = Currents.read(folder / "currents.parquet").predicted_current
    record = current_record(folder.name, signals, motion, torques, robot.fullest_model())
    if record is None or predicted is None:
        return None
    ratio = controllers_ratio(signals, motion)
    return Own(record, predicted, motion.qdd, torques.payload_torque, ratio, role == "fit")


def maker_constants(arm: Known) -> Array:
    """Return the torque constants (6,) [Nm/A] that are known without a fit."""
    fitted = [own.ratio for own in arm.runs if own.fitted]
    return 1 / prior_of(arm.robot, fitted).inverse_constant.mean


def write_samples(arm: Known) -> None:
    """Write what FIGAROH is given: motion, torques less the payload's, labels, and the URDF.

    A joint that rests has a velocity of zero, as in our least squares: otherwise FIGAROH's Coulomb
    friction would follow the sign of noise.
    """
    constant, folder = maker_constants(arm), FOR_FIGAROH / arm.name
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(arm.folder / "arm.urdf", folder)
    parts = [
        {
            "q": own.record.q,
            "qd": np.where(np.abs(own.record.qd) > DEAD_ZONE, own.record.qd, 0.0),
            "qdd": own.qdd,
            "torque": constant * own.record.current - own.payload_torque,
            "starts": starts(own.record.segment),
            "path": np.full(len(own.record.q), path),
            "fitted": np.full(len(own.record.q), own.fitted),
        }
        for own, path in zip(arm.runs, arm.paths, strict=True)
    ]
    joined = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    joined["stretch"] = np.cumsum(joined.pop("starts"))
    known = np.concatenate([known_rows(own) for own in arm.runs])
    period = np.median([own.record.period for own in arm.runs])
    np.savez(folder / "samples.npz", period=period, **{k: v[known] for k, v in joined.items()})


def known_rows(own: Own) -> Mask:
    """Return the samples (N,) of which FIGAROH is given motion and torque."""
    known = own.record.q + own.record.qd + own.qdd + own.record.current + own.payload_torque
    return np.asarray(np.isfinite(known).all(axis=1))


def figaroh_currents(arm: Known) -> dict[str, list[Array]]:
    """Return what FIGAROH predicts of each recording (N, 6) [A], by how it solved."""
    file = FOR_FIGAROH / arm.name / "predicted.npz"
    if not file.exists():
        print(f"{file} is missing; benchmarks/figaroh/identification.py writes it")
        return {}
    ends, constant = np.cumsum([known_rows(own).sum() for own in arm.runs]), maker_constants(arm)
    found = {}
    with np.load(file) as torques:
        for key, title in FIGAROH.items():
            parts = np.split(torques[key], ends[:-1])
            found[title] = [
                filled(part, own, constant) for part, own in zip(parts, arm.runs, strict=True)
            ]
    return found


def filled(torque: Array, own: Own, constant: Array) -> Array:
    """Return the current (N, 6) [A] that a torque without payload (n, 6) [Nm] needs."""
    whole = np.full_like(own.record.q, np.nan)
    whole[known_rows(own)] = torque
    return (whole + own.payload_torque) / constant


def arm_rows(arm: Known) -> Iterator[dict[str, Any]]:
    """Yield mean squares [A²] of what each model leaves of a recording's current, by joint."""
    figaroh = figaroh_currents(arm)
    for _, fit, tested in arm.unseen():
        coefficients = least_squares_coefficients([own.record for own in fit])
        mean = np.nanmean(np.concatenate([own.record.current for own in fit]), axis=0)
        for own in tested:
            at = arm.runs.index(own)
            models = {
                CONSTANT: np.broadcast_to(mean, own.record.current.shape),
                LEAST_SQUARES: baseline_current(own.record, coefficients),
                **{title: currents[at] for title, currents in figaroh.items()},
                OURS: own.predicted,
            }
            yield from run_rows(arm, own, models)
    yield from floor_rows(arm)


def run_rows(arm: Known, own: Own, models: Mapping[str, Array]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a recording, of the samples that all models predict."""
    errors = {title: arm.smooth(own.record.current - i, own.record) for title, i in models.items()}
    common = np.all([np.isfinite(error).all(axis=1) for error in errors.values()], axis=0)
    moving = smoothed_moving(own.record, arm.smooth)
    path = int(arm.paths[arm.runs.index(own)]) + 1
    about = {"arm": arm.name, "path": path, "recording": own.record.name, "fitted": yes(own.fitted)}
    for (title, error), (during, where) in product(
        errors.items(), (("motion", moving), ("rest", ~moving))
    ):
        known = about | {"during": during, "model": title}
        yield from joint_rows(known, error**2, common[:, None] & where, own.record.period)


def joint_rows(
    about: dict[str, Any], square: Array, rows: Mask, period: float
) -> Iterator[dict[str, Any]]:
    """Yield the mean of squares (N, 6) [A²] in some samples (N, 6), where these suffice."""
    for joint in range(6):
        kept = rows[:, joint]
        if (seconds := kept.sum() * period) >= LEAST:
            mean = float(square[kept, joint].mean())
            yield about | {"joint": joint + 1, "seconds": seconds, "square": mean}


def yes(fitted: bool) -> str:
    """Return how tables say whether a recording is of the role `fit`."""
    return "yes" if fitted else "no"


def floor_rows(arm: Known) -> Iterator[dict[str, Any]]:
    """Yield the rows of all pairs of runs of one path."""
    pairs = combinations(zip(arm.runs, arm.paths, strict=True), 2)
    for (first, path), (second, other) in pairs:
        if path == other:
            about = {"arm": arm.name, "path": int(path) + 1}
            for row in pair_rows(arm, first, second):
                yield about | row


def pair_rows(arm: Known, first: Own, second: Own) -> Iterator[dict[str, Any]]:
    """Yield half the mean square [A²] by which the currents of two runs of a path differ, where
    they pass the same states in motion, and what our prediction leaves of the second run there.

    If each run's current is what the motion needs plus what does not repeat, half of it is the
    mean square of the latter.
    """
    near, at = nearest_states(first, second)
    currents = [arm.smooth(own.record.current, own.record) for own in (first, second)]
    difference = np.full_like(currents[1], np.nan)
    difference[near] = currents[0][at[near]] - currents[1][near]
    left = arm.smooth(second.record.current - second.predicted, second.record)
    moving = smoothed_moving(second.record, arm.smooth) & np.isfinite(left + difference)
    name = f"{first.record.name} and {second.record.name}"
    about = {"during": "repeat", "recording": name, "fitted": yes(second.fitted)}
    for model, square in ((FLOOR, difference**2 / 2), (OURS, left**2)):
        yield from joint_rows(about | {"model": model}, square, moving, second.record.period)


def nearest_states(first: Own, second: Own) -> tuple[Mask, NDArray[np.intp]]:
    """Return whether the first run passes each state (N,) of the second, and where it is next."""
    places = [place(own.record.q, own.record.qd) for own in (first, second)]
    known = [np.flatnonzero(np.isfinite(own).all(axis=1)) for own in places]
    near, at = np.zeros(len(places[1]), bool), np.zeros(len(places[1]), np.intp)
    found, index = nearest(places[1][known[1]], places[0][known[0]])
    near[known[1]], at[known[1][found]] = found, known[0][index[found]]
    return near, at


if __name__ == "__main__":
    main()
