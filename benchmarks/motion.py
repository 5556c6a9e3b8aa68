"""Smoothed motion of simulated recordings: do its bands hold, and what does it gain?

Simulated with friction, noise, quantised positions and delayed velocities, in three kinds of
motion. Printed are the shares of q, q̇, q̈ within their 95 % bands, and the RMSE of q̈ relative to
that of the better of two central differences, of q̇ once and of q twice, each with the zero-phase
Butterworth low-pass whose cut-off is best for the truth, which nobody knows of a real recording.
"""

import argparse
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import signal

from ur5lib.robots.description import load_robot, robot_path
from ur5lib.signals.smoothing import SmoothedMotion, smooth_encoders
from ur5lib.stand.controller import frames
from ur5lib.stand.engine import perform
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import STEP
from ur5lib.timeseries.arrays import Array

PERIOD = 0.008  # s
WITHIN = 1.96  # standard deviations of a 95 % band
POSTURE = np.array([0.5, -1.6, 1.6, -1.5, 1.5, 0.3])
KINDS = ("moves", "moves with pauses", "Fourier series")
QUANTITIES = ("q", "qd", "qdd")
ORDER, CUTOFFS = 4, np.geomspace(0.5, 50, 60)


class Simulated(NamedTuple):
    """Measured q and q̇ (N, 6), and the true q, q̇, q̈ (N, 18)."""

    q: Array
    qd: Array
    truth: Array


def main() -> None:
    """Print coverage and gain of each kind of motion."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--seeds", type=int, default=20)
    options.add_argument("--quick", action="store_true", help="one seed, only shows that it runs")
    chosen = options.parse_args()
    seeds, seconds = (1, 6.0) if chosen.quick else (chosen.seeds, 20.0)
    print("kind; within the 95 % band: q, qd, qdd [%], in motion, at rest; RMSE of qdd by joint")
    for kind in KINDS:
        runs = [judged(simulated(kind, seed, seconds)) for seed in range(seeds)]
        moving, resting, ratios = (np.nanmean(part, axis=0) for part in zip(*runs, strict=True))
        print(f"{kind:>18}  {100 * moving.round(3)}  {100 * resting.round(3)}  {ratios.round(2)}")


def judged(own: Simulated) -> tuple[Array, Array, Array]:
    """Return the shares (3,) within bands in motion and at rest, and the RMSE's ratios (6,)."""
    motion = smooth_encoders(*clock(len(own.q)), own.q, own.qd)
    moving = np.abs(own.truth[:, 6:12]) > 1e-3
    return covered(motion, own, moving), covered(motion, own, ~moving), gain(motion, own)


def covered(motion: SmoothedMotion, own: Simulated, where: Array) -> Array:
    """Return the shares of q, q̇, q̈ (3,) within their bands, of joints and samples chosen (N, 6)."""
    inside = np.abs(motion.state - own.truth) <= WITHIN * motion.std
    chosen = np.where(np.tile(where, 3), inside, np.nan).reshape(len(where), 3, 6)
    return np.nanmean(chosen, axis=(0, 2)) if where.any() else np.full(3, np.nan)


def gain(motion: SmoothedMotion, own: Simulated) -> Array:
    """Return the RMSE of q̈ of each joint relative to that of the best differences (6,)."""
    qdd = own.truth[:, 12:]
    rivals = [np.gradient(own.qd, PERIOD, axis=0)]
    rivals += [np.gradient(np.gradient(own.q, PERIOD, axis=0), PERIOD, axis=0)]
    best = np.min([rmse(smooth - qdd) for rival in rivals for smooth in lowpassed(rival)], axis=0)
    return rmse(motion.qdd - qdd) / best


def lowpassed(values: Array) -> Iterator[Array]:
    """Yield the values by low-pass filters of all cut-offs."""
    for cutoff in CUTOFFS:
        yield signal.sosfiltfilt(
            signal.butter(ORDER, cutoff, fs=1 / PERIOD, output="sos"), values, axis=0
        )


def rmse(errors: Array) -> Array:
    """Return the root mean square of each column."""
    return np.sqrt(np.mean(errors**2, axis=0))


def clock(count: int) -> tuple[Array, Array]:
    """Return times [s] and labels of a recording without gaps."""
    return np.arange(count) * PERIOD, np.zeros(count, np.int64)


def simulated(kind: str, seed: int, seconds: float) -> Simulated:
    """Return what a UR5 on the virtual stand measures, and the truth."""
    random = np.random.default_rng([seed, KINDS.index(kind)])
    plan = SimulatedRecording.model_validate(
        {"seed": seed, "seconds": seconds, "trajectory": trajectory(kind, seed, random)}
    )
    experiment = perform(load_robot(robot_path("ur5")), plan, random)
    sent = frames(experiment, PERIOD, random)
    every = slice(None, None, round(PERIOD / STEP))
    # the engine's velocities are half a step late: the truth is what the positions do
    true_q = experiment.motion.q
    true_qd = np.gradient(true_q, STEP, axis=0)
    true_qdd = np.gradient(true_qd, STEP, axis=0)
    truth = np.hstack([true_q, true_qd, true_qdd])[every]
    q, qd = (sent.filter(regex=f"^{name}_\\d$").to_numpy() for name in ("actual_q", "actual_qd"))
    return Simulated(q, qd, truth)


def trajectory(kind: str, seed: int, random: np.random.Generator) -> dict[str, object]:
    """Return the plan of a motion."""
    if kind == "Fourier series":
        return {"kind": "fourier", "draw": seed}
    points = POSTURE + random.uniform(-0.6, 0.6, (8, 6))
    pause = 0.8 if kind == "moves with pauses" else 0.0
    return {"kind": "movej", "way_points": points.tolist(), "pause_s": pause}


if __name__ == "__main__":
    main()
