"""Slow presses on simulated arms at rest, without a recording to fit on, seed by seed.

    python -m benchmarks.slow_presses [<seeds>] [--study <study>[:<robot>]] [--quick]

A UR5e or a UR16e with friction of its own is pressed for seconds, with up to 100 N at the flange or
near it. In contact: RMSE of the force along the axes, share inside its 95 % band, median and
largest delay of the contact; with `untouched` from 0 to 1.5 s, without it, by twenty lines
(gravity, the maker's torque constants, the first 40 samples as zero, least squares), and of an
estimate of zero.

`--study` presses the rests of a built study's recordings instead, those without contact on paths
and days that are left out of the fit: with ramps of 3 s to 20 and 40 N, which then last to the end
of the rest. Of the samples then at which no contact is found: the share of axes within the band,
and within it or the force that could be hidden; of a press of the whole rest, within the force that
could be hidden at all.
"""

import tempfile
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.drawn_studies import FRICTION, posture
from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import options_of
from benchmarks.harness.stand import CURRENTS, Taken, currents, fitted_map, simulated
from benchmarks.leave_out import Fold, Recording, refusal
from benchmarks.worth import arm_of, folds
from benchmarks.worth import estimate as recording_estimate
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import is_still, joint_states
from ur5lib.force.problem import fmap_problem
from ur5lib.force.sensed_contact import TOUCH_FORCE
from ur5lib.force.tare import tared
from ur5lib.force.wrench_estimate import OPENING_PROBABILITY, WrenchEstimate
from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.motion import Motion
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.steps.fit_residuals import usual_residuals
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import spans

ARMS, SEEDS = ("ur5e", "ur16e"), 50
FIRST_SEED = 100  # constants were chosen on lower seeds
UNTOUCHED, STARTS = (0.0, 1.5), 2.0  # s
FORCES, POINT = (30.0, 100.0), 0.1  # N, m: ranges
RISES, HELD = (1.5, 5.0), (0, 3)  # s, 1; ranges of rise time, and of further overlapping pushes
FIRST = 40  # samples
REST, RAMP, PRESSES = 8.0, 3.0, (20.0, 40.0)  # s, s, N; least rest, and ramps with their forces
WAYS = 4  # directions for each rest and force
PRESSED = ["kind", "press", "in band", "in band or hidden", "shut", "samples"]
COLUMNS = ["seed", "by", "square", "inside", "samples", "late"]


class Pressed(NamedTuple):
    """A pressed recording; force: true (N, 3) [N]."""

    taken: Taken
    force: Array


def main() -> None:
    """Print a line for each estimate."""
    options = options_of(__doc__)
    options.add_argument("seeds", nargs="?", type=int, default=SEEDS, help="how many")
    options.add_argument("--study", help="press the rests of a built study, <study>[:<robot>]")
    given = options.parse_args()
    torch.set_num_threads(1)
    if given.study:
        print(pressed_rests(given.study, given.quick))
        return
    seeds = 1 if given.quick else given.seeds
    chosen = range(FIRST_SEED, FIRST_SEED + seeds)
    rows = pd.DataFrame([row for seed in chosen for row in seed_rows(seed)], columns=COLUMNS)
    print(f"{seeds} seeds{'':<15}RMSE [N]  inside  delay [s], longest   not found")
    for name, own in rows.groupby("by", sort=False):
        rmse = np.sqrt(own["square"].sum() / own["samples"].sum() / 3)
        late, lost = own["late"], own["late"].isna().sum()
        inside = own["inside"].sum() / own["samples"].sum()
        print(
            f"{name:<24}{rmse:>6.1f}{inside:>8.3f}{late.median():>11.2f}{late.max():>9.2f}{lost:>10}"
        )


def seed_rows(seed: int) -> Iterator[list[Any]]:
    """Yield the sums over the samples in contact, by estimate."""
    own = pressed(seed)
    for name, found in {
        "with an untouched span": estimate(own.taken, UNTOUCHED),
        "without": estimate(own.taken, None),
    }.items():
        yield [seed, name, *sums(own.force, found.wrench, found.std), delay(own, found)]
    for name, force in {"twenty lines": twenty_lines(own.taken), "zero": 0 * own.force}.items():
        yield [seed, name, *sums(own.force, force, np.full_like(force, np.nan)), np.nan]


def pressed(seed: int) -> Pressed:
    """Simulate and read the recording of a seed."""
    with tempfile.TemporaryDirectory() as folder:
        entry = RtdeFiles(format="rtde-csv", folder=folder, file="robot.csv")
        taken = simulated(load_robot(robot_path(ARMS[seed % 2])), plan(seed), entry)
        return Pressed(taken, taken.truth.at(taken.signals.time).wrench[:, :3])


def plan(seed: int) -> dict[str, Any]:
    """Return the plan of a seed: overlapping pushes add up to a long press."""
    random = np.random.default_rng([seed, 3])
    way, rise = random.normal(size=3), random.uniform(*RISES)
    push = {
        "kind": "push",
        "force": (random.uniform(*FORCES) * way / np.linalg.norm(way)).tolist(),
        "point": random.uniform(-POINT, POINT, 3).tolist(),
        "seconds": 2 * rise,
    }
    starts = STARTS + rise * np.arange(1 + random.integers(*HELD))
    factors = {
        f"{of}_factor": random.uniform(*FRICTION, 6).tolist() for of in ("coulomb", "viscous")
    }
    return {
        "trajectory": {"kind": "standstill", "posture": posture(random)},
        "seconds": starts[-1] + 2 * rise + STARTS,
        "seed": seed,
        "contacts": [push | {"start_s": start} for start in starts.tolist()],
    } | factors


def estimate(own: Taken, untouched: tuple[float, float] | None) -> WrenchEstimate:
    """F̂ᵐᵃᵖ without a recording to fit on."""
    friction = fitted_map([], [own])
    known = currents(friction, own)
    if untouched:
        known = tared(known, own.motion, untouched, CURRENTS.cutoff)
    problem = fmap_problem(own.motion, known, usual_residuals(friction.fit, CURRENTS.cutoff))
    assert problem is not None
    prior = ContactPrior.of(own.robot, None, ContactPlace())
    return problem.solve(own.kinematics.jacobian[problem.rows], prior)


def twenty_lines(own: Taken) -> Array:
    """The force (N, 3) [N] by least squares from gravity and the maker's constants."""
    constant = np.array(own.robot.maker_torque_constants())
    torque = own.record.torque - constant * own.record.current
    torque = ZeroPhaseLowpass(*CURRENTS)(torque - torque[:FIRST].mean(axis=0), own.record)
    linear = np.linalg.pinv(own.kinematics.jacobian[:, :3].mT)
    return np.asarray((linear @ torque[..., None])[..., 0], np.float64)


def sums(true: Array, wrench: Array, std: Array) -> tuple[float, float, int]:
    """Sum of squared errors [N²], of shares of axes inside the band, and number of samples, in
    contact.
    """
    rows = in_contact(true)
    error = (wrench[:, :3] - true)[rows]
    inside = np.abs(error) <= NORMAL95 * std[rows, :3]
    return float((error**2).sum()), float(inside.mean(axis=1).sum()), int(rows.sum())


def delay(own: Pressed, found: WrenchEstimate) -> float:
    """Time [s] from touch to the first sample of the gate's contact, NaN if there is none."""
    rows = in_contact(own.force)
    odds = np.flatnonzero(
        rows & (found.log_odds > np.log(OPENING_PROBABILITY / (1 - OPENING_PROBABILITY)))
    )
    period = own.taken.motion.period
    return float(odds[0] - np.argmax(rows)) * period if len(odds) else np.nan


def in_contact(force: Array) -> Array:
    """Samples (N,) at which a force (N, 3) counts as touched."""
    return np.linalg.norm(force, axis=1) > TOUCH_FORCE


def pressed_rests(name: str, quick: bool) -> str:
    """Return a table of presses on an arm's rests, by their kind and size."""
    study, rows = arm_of(name), []
    for fitted, tested in folds(study)[: 1 if quick else None]:
        free = [own for own in tested if own.entry["role"] != "contact"]
        with tempfile.TemporaryDirectory() as kept:
            fold = Fold(study, fitted, Path(kept))
            if refusal(fold, free) is None:
                rows += [row for own in free for row in on_rests(fold, own)]
    if not rows:
        return f"{name}: no recording without contact on a path left out rests for {REST:g} s"
    sums = pd.DataFrame(rows, columns=PRESSED).groupby(PRESSED[:2], sort=False).sum()
    lines = [
        [f"{size:.0f} N, {kind}", *(f"{own:.2f}" for own in (band / shut, held / shut, shut / n))]
        for (kind, size), band, held, shut, n in sums.itertuples()
    ]
    return markdown(["press", "in band", "in band or hidden", "no contact found"], lines)


def on_rests(fold: Fold, own: Recording) -> Iterator[list[Any]]:
    """Yield a row of PRESSED for each rest of a recording, and kind, size and way of a press."""
    motion, random = Motion.read(own.file("motion.parquet")), np.random.default_rng(own.path)
    prior = ContactPrior.of(fold.arm, fold.study.settings.contact.force_n, ContactPlace())
    states = joint_states(motion.motor_qd, motion.segment, motion.period, fold.study.lowpass.cutoff)
    for first, end in spans(is_still(states).astype(float), 0.5, 0.5):
        since = motion.time[first:end] - motion.time[first]
        if since[-1] < REST:
            continue
        rises = np.clip((since - RAMP / 2) / RAMP, 0, 1)
        rows = slice(first + int(np.argmax(since > 2 * RAMP)), end)
        for size, way in product(PRESSES, random.normal(size=(WAYS, 3))):
            force = size * way / np.linalg.norm(way)
            for kind, share in {"ramp of 3 s": rises, "whole rest": np.ones_like(rises)}.items():
                press = np.zeros((len(motion.time), 6))
                press[first:end, :3] = np.outer(share, force)
                found = recording_estimate(fold, own, prior, press)
                limit = found.hidden if kind != "whole rest" else found.hidden_at_all
                yield [kind, size, *shut_sums(found, limit, force, rows)]


def shut_sums(
    found: WrenchEstimate, limit: Array, force: Array, rows: slice
) -> tuple[float, float, int, int]:
    """Return, of the samples in some rows without a found contact, sums of the shares of axes
    within the band, and within it or a limit (N, 3) [N], their number, and that of all samples.

    force: (3,) [N], which presses there.
    """
    shut = np.asarray(~found.wrench[rows].any(axis=1))
    error, band = np.abs(force - found.wrench[rows, :3]), NORMAL95 * found.std[rows, :3]
    inside = [error <= band, error <= np.maximum(band, limit[rows])]
    within, held = (float(own[shut].mean(axis=1).sum()) for own in inside)
    return within, held, int(shut.sum()), len(shut)


if __name__ == "__main__":
    main()
