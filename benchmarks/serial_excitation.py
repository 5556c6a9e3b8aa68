"""What designed motions of other makers' arms are worth, beside random ones, on the virtual stand.

    python -m benchmarks.serial_excitation <urdf> [<tip>] [--seeds <n>] [--quick]

The arm is described from its URDF, once with torque sensors in its joints and once with motor
currents alone. The designed motion and, for each seed, a random Fourier series of the same length
that keeps the same limits, as fast as they allow, are recorded on the stand. To each recording, all
parameters are fitted, from values that are drawn from what is known before. Printed are their
standard errors as predicted before the recording, as stated after it by the noise that it has, and
the errors found against the truth, each over what is known before, as the median over parameters;
and the error of the torques of random motions that no fit has seen. `example-robot-data` on PyPI
has a Panda.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path as File
from typing import Any

import numpy as np
import pandas as pd
import torch
import yaml

from benchmarks.excitation import QUICK, USUAL, fit, random_motions
from benchmarks.harness.options import options_of
from benchmarks.serial_arms import taken, with_motors
from benchmarks.stand_seeds import Taken
from ur5lib.commands.excite import ExciteOptions, task_of
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.design import design, free_postures, random_path
from ur5lib.excitation.files import stand_study
from ur5lib.excitation.objective import Task
from ur5lib.excitation.problem import (
    CORRELATION_TIME,
    INDEPENDENT_STEP,
    DesignProblem,
    MeasurementNoise,
)
from ur5lib.excitation.trajectory import Path
from ur5lib.identification.estimation import physical_values
from ur5lib.robots.description import Robot
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass

SEEDS, SECONDS, SHORT, UNSEEN = 5, 20.0, 6.0, 5
CUTOFF = 4, 8.0  # order, Hz: of a low-pass of what the joints state
GROUPS = {
    "links": (" of link", "rotor"),
    "gain or torque constant": ("gain", "torque constant"),
    "bias or offset": ("bias", "offset"),
    "friction": ("friction",),
}


def main() -> None:
    """Print errors of both motions, with sensors and with currents."""
    options = options_of(__doc__)
    options.add_argument("urdf", type=File, help="the arm")
    options.add_argument("tip", nargs="?", help="its flange; by default what the last joint turns")
    options.add_argument("--seeds", type=int, default=SEEDS, help="how many")
    options.add_argument("--table", type=float, default=0.0, help="its height [m]")
    given = options.parse_args()
    torch.set_num_threads(1)
    seeds, seconds, effort = (1, SHORT, QUICK) if given.quick else (given.seeds, SECONDS, USUAL)
    robot, _ = robot_from_urdf(given.urdf, tip=given.tip)
    for name, arm in (("torque sensors", robot), ("currents", with_motors(robot))):
        asked = ExciteOptions(arm.name, seconds, "model", None, given.table, None, 0)
        task = task_of(asked, arm, None)
        designed = design(task, 0, effort).path
        rows = pd.DataFrame(
            row
            for seed in range(seeds)
            for motion, path in (("designed", designed), ("random", random_motion(task, seed)))
            for row in figures(task, arm, motion, path, seed)
        )
        print(f"{arm.name} with {name}, {seconds:g} s, {seeds} seeds")
        print(rows.groupby(["what", "motion"], sort=False).mean().round(3))


def random_motion(task: Task, seed: int) -> Path:
    """Return a random motion, as large as the limits allow."""
    drawn = np.random.default_rng(1000 + seed)
    return random_path(task, drawn, free_postures(task.cell, drawn))


def figures(task: Task, arm: Robot, motion: str, path: Path, seed: int) -> Iterator[dict[str, Any]]:
    """Yield what is printed of one recording."""
    own = recorded(arm, path, seed)
    Y, qd, stated = samples(own)
    problem, drawn = task.problem, np.random.default_rng(seed)
    spread = np.linalg.cholesky(np.linalg.inv(problem.prior))
    guess = replace(problem, theta=problem.theta + spread @ drawn.normal(size=len(spread)))
    fitted = fitted_to(guess, Y, qd, stated)
    error = np.abs(in_units(problem, fitted.theta) - in_units(problem, true_parameters(task, own)))
    columns = {
        "predicted": problem.standard_errors(task.information(path)),
        "stated": fitted.standard_errors(
            fitted.prior + fitted.information(Y, qd, INDEPENDENT_STEP)
        ),
        "found": error,
    }
    before = problem.standard_errors(problem.prior)
    for group, words in GROUPS.items():
        rows = [any(word in name for word in words) for name in problem.names()]
        shares = {name: float(np.median((own / before)[rows])) for name, own in columns.items()}
        yield {"motion": motion, "what": group} | shares
    unseen = [Y for Y, _ in random_motions(task, UNSEEN)]
    torque = float(np.mean([np.abs(fitted.torque(Y) - problem.torque(Y)) for Y in unseen]))
    yield {"motion": motion, "what": "torque of unseen motion [Nm]", "found": torque}


def recorded(arm: Robot, path: Path, seed: int) -> Taken:
    """Return the recording of a path on the stand."""
    (entry,) = yaml.safe_load(stand_study(arm.name, None, path))["recordings"]
    with tempfile.TemporaryDirectory() as folder:
        return taken(arm, entry["simulate"] | {"seed": seed}, File(folder))


def samples(own: Taken) -> tuple[Array, Array, Array]:
    """Return Y, q̇ and what the joints state, every INDEPENDENT_STEP of a recording."""
    motion, stated = own.motion, own.signals.actual_current
    low = zero_phase_lowpass(stated, 1 / own.signals.period, *CUTOFF)
    every = slice(None, None, round(INDEPENDENT_STEP / own.signals.period))
    q, qd, qdd = (part[every] for part in (motion.q, motion.qd, motion.qdd))
    return LinkModel(own.robot, own.robot.fullest_model()).regressor(q, qd, qdd), qd, low[every]


def fitted_to(problem: DesignProblem, Y: Array, qd: Array, stated: Array) -> DesignProblem:
    """Return the problem at its estimate, with the noise that the recording has."""
    slow = np.sqrt(CORRELATION_TIME / INDEPENDENT_STEP)
    for _ in range(2):
        size = np.concatenate([np.full_like(problem.noise.torque, np.inf), problem.noise.current])
        measured = np.hstack([np.zeros_like(stated), stated]) / size
        found = replace(problem, theta=fit(problem, Y, qd, measured))
        left = measured - found.measured(found.theta, Y, qd)
        noise = slow * left[:, problem.joints :].std(axis=0) * problem.noise.current
        problem = replace(problem, noise=MeasurementNoise(problem.noise.torque, noise))
    return replace(found, noise=problem.noise)


def in_units(problem: DesignProblem, theta: Array) -> Array:
    """Return parameters with gains, offsets and friction in their own units."""
    return np.concatenate(
        [theta[: problem.count], physical_values(theta[problem.of_currents].reshape(-1, 5)).ravel()]
    )


def true_parameters(task: Task, own: Taken) -> Array:
    """Return θ of the stand: its links are the described ones."""
    drive, friction = own.summary.drive, own.summary.friction
    k = drive.torque_constant
    offset = np.zeros_like(k) if drive.offset is None else drive.offset
    rows = [np.ones_like(k), -offset, friction["coulomb"], friction["viscous"], friction["load"]]
    maps = np.column_stack(rows) / k[:, None]
    return np.concatenate([task.problem.theta[: task.problem.count], maps.ravel()])


if __name__ == "__main__":
    main()
