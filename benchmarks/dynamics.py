"""Inverse dynamics, side by side in one run: this library against Pinocchio called in a loop."""

import statistics
import time
from collections.abc import Callable

import numpy as np
import pinocchio
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.urdf import urdf

SIZES = (100, 1_000, 3_000, 10_000, 100_000)
ROUNDS = 5


def seconds(function: Callable[[], object]) -> float:
    """How long a call takes."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def main() -> None:
    """Print the table."""
    torch.set_num_threads(1)
    robot = load_robot(robot_path("ur5"))
    arm = build_arm(robot, "C")
    model = pinocchio.buildModelFromXML(urdf(robot, rigid_bodies(robot, "C")))
    data = model.createData()
    random = np.random.default_rng(0)

    print(f"median of {ROUNDS} rounds in turn, one thread, microseconds per state")
    print(f"{'states':>8} {'ours':>8} {'pinocchio':>10} {'ratio':>6}")
    for size in SIZES:
        states = [random.uniform(-3, 3, (size, 6)) for _ in range(3)]
        tensors = [torch.from_numpy(state) for state in states]
        rounds = [
            (
                seconds(lambda t=tensors: inverse_dynamics(arm, *t)),
                seconds(
                    lambda s=states: [
                        pinocchio.rnea(model, data, *row) for row in zip(*s, strict=True)
                    ]
                ),
            )
            for _ in range(ROUNDS + 1)
        ][1:]  # the first warms up
        ours, theirs = (1e6 * statistics.median(side) / size for side in zip(*rounds, strict=True))
        print(f"{size:>8} {ours:>8.2f} {theirs:>10.2f} {theirs / ours:>6.2f}")


if __name__ == "__main__":
    main()
