"""Torque from motion on public data: a part of docs/benchmark.md.

    python -m benchmarks.torque_from_motion [--folder raw/kuka-kr300] [--test <path>] [--page]

Fits to the motions train-*.csv of the KUKA KR300 (doi 10.26204/DATA/5, `ur5 fetch kuka-kr300`) and
judges val-*.csv; with `--test`, the test part of the benchmark's own file in their place,
inverse_identification_without_raw_data.mat, or the files of another folder, in the same form (time,
six positions, six motor torques), none of which is a motion of the fit. Files follow each other by
name. With `--test`, a column has the RMSE of identibench 0.4, BenchmarkRobotInverse_Simulation: the
mean of those of the six motors' torques, without the first 100 samples. `--page` writes the part;
`--quick` takes a few files.
"""

import sys
import tempfile
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import starmap
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.io import loadmat

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import options_of
from benchmarks.harness.torque_models import (
    Ours,
    Run,
    chained,
    least_squares,
    linear_map,
    rigid_links,
    with_gears,
    with_memory,
)
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.drives import as_counted
from ur5lib.timeseries.arrays import Array, Mask
from ur5rivals.estimators import gaussian_process
from ur5rivals.learned_residual import Predict, TrainingSamples, standardised

PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
TITLE = "Torque from motion"
QUICK_FILES = 6
POINTS_OF_PROCESS = 600  # for learning a Gaussian process
REPEATS_AFTER = 3  # files; file k + 3 repeats the motion of file k
SAME_MOTION = 0.1  # rad; two runs with smaller differences repeat one motion
FIRST_SCORED = 100  # samples; identibench reserves them for models that use earlier torques
FIRST_MOTION = 0.01  # rad; after this motion, friction does not depend on its history


class Row(NamedTuple):
    """A model's torques (N, n) [Nm] of each judged run, and half-widths of 95 % bands, if any."""

    model: str
    torque: Sequence[Array]
    half: Sequence[Array] = ()


def main() -> None:
    """Fit, predict, print and write."""
    options = options_of(__doc__)
    options.add_argument("--folder", type=Path, default=Path("raw/kuka-kr300"))
    options.add_argument("--test", type=Path, help="what to judge: a folder, or the MAT file")
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    given = options.parse_args()
    if given.test and given.test.suffix == ".mat":
        given.test = withheld_part(given.test, Path(tempfile.mkdtemp()))
    judged = sorted(given.test.glob("*.csv") if given.test else given.folder.glob("val-*.csv"))
    files = sorted(given.folder.glob("train-*.csv"))
    if not (files and judged):
        sys.exit(f"{given.folder} or {given.test} has no files; `ur5 fetch kuka-kr300` first")
    if given.quick:
        files, judged = files[:QUICK_FILES], judged[:1]
    validated = sorted(given.folder.glob("val-*.csv")) if given.test else []
    between = [run_of(file) for file in validated if file.name not in {own.name for own in judged}]
    fitted, tested = [*map(run_of, files)], [*map(run_of, judged)]
    if seen := [run.name for run in tested if is_repeated(run, fitted)]:
        sys.exit(f"{', '.join(seen)}: motions of the fit; judge files that it has not seen")
    text = table(fitted, tested, between, is_scored=given.test is not None)
    print(text)
    if given.page:
        write_page(replaced(read_page(PAGE), TITLE, text), PAGE)


def withheld_part(file: Path, folder: Path) -> Path:
    """Write the test part of the benchmark's inverse task as a file of `folder`; return this.

    It has u_test (18, N), of which the first six are positions [deg], y_test (6, N) [Nm], and
    time_test (1, N) [s].
    """
    part = loadmat(file, variable_names=["time_test", "u_test", "y_test"])
    columns = part["time_test"], np.deg2rad(part["u_test"][:6]), part["y_test"]
    names = ["time", *(f"{name}_{k}" for name in ("q", "motor_torque") for k in range(6))]
    table = pd.DataFrame(np.vstack(columns).T, columns=names)
    table.to_csv(folder / "test.csv", index=False)
    return folder


def run_of(file: Path) -> Run:
    """Read a file of the KR300."""
    return Run(load_robot(robot_path("kuka-kr300")), file)


def is_repeated(run: Run, fitted: Sequence[Run]) -> bool:
    """Return whether a run repeats the motion of a fitted one."""
    return any(largest_difference(run, own) < SAME_MOTION for own in fitted)


def largest_difference(one: Run, two: Run) -> float:
    """Return the largest difference [rad] of positions at the same times since each start."""
    length = min(len(one.torque), len(two.torque))
    return float(np.abs(one.signals.actual_q[:length] - two.signals.actual_q[:length]).max())


def table(
    fitted: Sequence[Run], judged: Sequence[Run], between: Sequence[Run], is_scored: bool
) -> str:
    """Return the table of NRMSE, R² and shares in the band, by joint.

    between: runs after the fitted and before the judged ones; is_scored: with identibench's score.
    """
    joints = [str(joint) for joint in judged[0].arm.joint_numbers]
    header = ["model", *joints, "mean", "R² of each joint", "in the 95 % band"]
    header += ["RMSE [Nm]"] * is_scored
    following = chained([*fitted, *between, *judged])
    known = following[: len(fitted)], following[-len(judged) :]
    predicted = [*rows(fitted, judged), *rows_after(*known)]
    lines = [line(row, judged) + [scored(row, judged)] * is_scored for row in predicted]
    floor = [cells + [""] * is_scored for cells in repeated(judged)]
    return markdown(header, [*lines, *floor])


def rows(fitted: Sequence[Run], judged: Sequence[Run]) -> Iterator[Row]:
    """Yield the torques of the judged runs by each model."""
    by_least_squares = partial(least_squares, fitted=fitted, judged=judged)
    yield Row("linear map of 18 inputs", by_least_squares(linear_map))
    yield Row("rigid links, rotors, Coulomb, viscous, offset", by_least_squares(rigid_links))
    yield Row("+ root and square of velocity, counterbalances", by_least_squares(with_gears))
    yield Row("+ dry friction with four memories", by_least_squares(with_memory))
    ours = Ours(fitted[0].arm, fitted)
    torques, halves = zip(*map(ours.predicted, judged), strict=True)
    yield Row("ours", torques, halves)
    process = residual_process(ours, fitted)
    inputs = [ours.inputs(run, ours.friction.fit)[0] for run in judged]
    corrected = [torque + process(own) for torque, own in zip(torques, inputs, strict=True)]
    yield Row("ours + Gaussian process", corrected)


def rows_after(fitted: Sequence[Run], judged: Sequence[Run]) -> Iterator[Row]:
    """Yield the torques of judged runs by models that use the earlier motions."""
    torques = least_squares(with_memory, fitted, judged)
    yield Row("four memories, from the file before", torques)
    ours = Ours(fitted[0].arm, fitted)
    yield Row("ours, from the file before", *zip(*map(ours.predicted, judged), strict=True))


def residual_process(ours: Ours, fitted: Sequence[Run]) -> Predict:
    """Return a Gaussian process's prediction of the residual torques of fits without the path.

    It learns from (q, q̇, predicted torque) at POINTS_OF_PROCESS samples of the fitted runs.
    """
    learnt = [ours.inputs(run, ours.friction.fit_for(run.name)) for run in fitted]
    inputs, left = map(np.concatenate, zip(*learnt, strict=True))
    every = max(1, len(inputs) // POINTS_OF_PROCESS)
    samples = TrainingSamples(inputs[::every], left[::every])
    return standardised(gaussian_process.train, samples, samples)


def line(row: Row, judged: Sequence[Run]) -> list[str]:
    """Return a row of the table."""
    measured = np.concatenate([run.torque for run in judged])
    error = measured - np.concatenate(row.torque)
    nrmse = np.sqrt(np.nanmean(error**2, axis=0)) / np.nanstd(measured, axis=0)
    half = np.concatenate(row.half) if row.half else np.full_like(error, np.nan)
    within = np.where(np.isfinite(half), np.abs(error) < half, np.nan)
    share = ", ".join(f"{own:.3f}" for own in np.nanmean(within, axis=0)) if row.half else ""
    r2 = ", ".join(f"{own:.2f}" for own in 1 - nrmse**2)
    return [row.model, *(f"{own:.3f}" for own in nrmse), f"{nrmse.mean():.3f}", r2, share]


def scored(row: Row, judged: Sequence[Run]) -> str:
    """Return identibench's score of a model: the mean RMSE [Nm] of the motors' torques without the
    first samples of all.
    """
    error = np.concatenate([run.torque for run in judged]) - np.concatenate(row.torque)
    of_motors = as_counted("actual_torque", error[FIRST_SCORED:], judged[0].arm)
    return f"{np.sqrt(np.mean(of_motors**2, axis=0)).mean():.4f}"


def repeated(judged: Sequence[Run]) -> Iterator[list[str]]:
    """Yield rows of differences between repeated runs, over √2: of all samples, and of those after
    each joint's first motion.
    """
    pairs = [*zip(judged, judged[REPEATS_AFTER:], strict=False)]
    if pairs:
        differences, moved = map(np.concatenate, zip(*starmap(driven_twice, pairs), strict=True))
        size = np.concatenate([run.torque for run in judged]).std(axis=0)
        for where, used in (("", np.ones_like(moved)), (", behind its first 0.01 rad", moved)):
            squares = np.where(used, differences**2, np.nan)
            floor = np.sqrt(np.nanmean(squares, axis=0)) / size
            name = f"the same motion driven twice, difference over √2{where}"
            yield [name, *(f"{own:.3f}" for own in floor), f"{floor.mean():.3f}", "", ""]


def driven_twice(one: Run, two: Run) -> tuple[Array, Mask]:
    """Return the difference of two runs' torques over √2 (N, n) [Nm], and a mask (N, n) of samples
    after each joint's first motion in both.
    """
    length = min(len(one.torque), len(two.torque))
    moved = [
        np.maximum.accumulate(np.abs(own - own[0]))[:length] > FIRST_MOTION
        for own in (one.signals.actual_q, two.signals.actual_q)
    ]
    return (one.torque[:length] - two.torque[:length]) / np.sqrt(2), moved[0] & moved[1]


if __name__ == "__main__":
    main()
