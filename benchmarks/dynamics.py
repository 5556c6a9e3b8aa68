"""Dynamics side by side in one run: this library, Pinocchio and MuJoCo; then memory.

Microseconds a state, medians of rounds in which all take turns; "x" is the median of the rounds'
ratios to Pinocchio's loop. What is called in a Python loop is given at most LOOPED states: its
time a state does not depend on their number. Few states are given often, as a controller does:
CALLED states in all.
"""

import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio
import torch

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import seconds
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.one_state import OneState, pinocchio_model
from ur5lib.dynamics.rigid_body import inertia_matrix, inverse_dynamics
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies

LOOPED, CALLED = 10_000, 1_000
MODEL = "C+rotors"
REFERENCE = "pinocchio"
ONE_BY_ONE = (REFERENCE, "mujoco", "one by one")


@dataclass(frozen=True)
class Effort:
    """Size of the benchmark: states, rounds, and whether fused functions are compiled."""

    sizes: tuple[int, ...] = (1, 100, 1_000, 3_000, 10_000, 100_000, 1_000_000)
    large: tuple[int, ...] = (100_000, 1_000_000, 10_000_000)
    rounds: int = 5
    fused: bool = True


QUICK = Effort(sizes=(100,), large=(1_000,), rounds=1, fused=False)

States = list[np.ndarray]
Contender = Callable[[States], Callable[[], object]]
"""Prepares a call for given states; only the call is timed."""


def main() -> None:
    """Print the tables; each number of threads runs in a new process."""
    options = options_of(__doc__)
    options.add_argument("--threads", type=int, help="measure in this process, on so many")
    given = options.parse_args()
    robot, effort = load_robot(robot_path("ur5")), QUICK if given.quick else Effort()
    if given.threads:
        return compare_on_threads(robot, given.threads, effort)
    for threads in sorted({1, os.cpu_count() or 1}):
        command = [sys.executable, "-m", "benchmarks.dynamics", *sys.argv[1:]]
        subprocess.run([*command, "--threads", str(threads)], check=True)
    print_memory(robot, effort)


def compare_on_threads(robot: Robot, threads: int, effort: Effort) -> None:
    """Print the tables of torque and inertia matrix."""
    torch.set_num_threads(threads)
    for title, contenders in (
        ("inverse dynamics", torque_contenders(robot, threads, effort)),
        ("inertia matrix", inertia_contenders(robot, effort)),
    ):
        print(f"\n{title}, UR5 {MODEL}, {threads} thread{'s' * (threads > 1)}")
        print(f"{'states':>9}" + "".join(f"{name:>20}" for name in contenders))
        for size in effort.sizes:
            cells = row(contenders, size, effort.rounds)
            print(f"{size:>9}" + "".join(cells), flush=True)


def torque_contenders(robot: Robot, threads: int, effort: Effort) -> dict[str, Contender]:
    """Return all contenders that compute joint torques."""
    return {
        REFERENCE: pinocchio_loop(robot, pinocchio.rnea),
        "pinocchio, batched": pinocchio_batched(robot, threads),
        "mujoco": mujoco_loop(robot),
        "one by one": our_loop(robot),
        **ours(robot, inverse_dynamics, effort),
    }


def inertia_contenders(robot: Robot, effort: Effort) -> dict[str, Contender]:
    """Return all contenders that compute inertia matrices."""

    def crba(model: pinocchio.Model, data: pinocchio.Data, q: np.ndarray, *_: object) -> object:
        return pinocchio.crba(model, data, q)

    return {
        REFERENCE: pinocchio_loop(robot, crba),
        **ours(robot, lambda arm, q, *_: inertia_matrix(arm, q), effort),
    }


def ours(robot: Robot, term: Callable[..., object], effort: Effort) -> dict[str, Contender]:
    """Return this library's contenders, plain and fused, in double and single precision."""

    def contender(dtype: torch.dtype, fused: bool) -> Contender:
        arm = build_arm(robot, MODEL, dtype=dtype, fused=fused)

        def prepare(states: States) -> Callable[[], object]:
            tensors = [torch.from_numpy(state).to(dtype) for state in states]
            return lambda: term(arm, *tensors)

        return prepare

    return {
        f"{'fused' if fused else 'plain'}{name}": contender(dtype, fused)
        for name, dtype in (("", torch.float64), (" float32", torch.float32))
        for fused in (False, True)[: 1 + effort.fused]
    }


def pinocchio_loop(robot: Robot, function: Callable[..., object]) -> Contender:
    """Return one of Pinocchio's functions, called for state after state."""
    model, _ = pinocchio_model(robot, MODEL)
    data = model.createData()

    def prepare(states: States) -> Callable[[], object]:
        rows = list(zip(*(state[:LOOPED] for state in states), strict=True))
        return lambda: [function(model, data, *row) for row in rows]

    return prepare


def pinocchio_batched(robot: Robot, threads: int) -> Contender:
    """Return rneaInParallel, one call for all states."""
    pool = pinocchio.ModelPool(pinocchio_model(robot, MODEL)[0], threads)

    def prepare(states: States) -> Callable[[], object]:
        columns = [np.asfortranarray(state.T) for state in states]
        torque = np.empty_like(columns[0], order="F")
        return lambda: pinocchio.rneaInParallel(threads, pool, *columns, torque)

    return prepare


def our_loop(robot: Robot) -> Contender:
    """Return what `model.single()` calls, for state after state."""
    arm = OneState(robot, MODEL)

    def prepare(states: States) -> Callable[[], object]:
        rows = list(zip(*(state[:LOOPED] for state in states), strict=True))
        return lambda: [arm.inverse_dynamics(*row) for row in rows]

    return prepare


def mujoco_loop(robot: Robot) -> Contender:
    """Return mj_inverse, called for state after state."""
    bodies = rigid_bodies(robot, MODEL)
    model = mujoco.MjModel.from_xml_string(urdf(robot, bodies))
    model.dof_armature[:] = bodies.rotor_inertia
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)

    def prepare(states: States) -> Callable[[], object]:
        def call() -> None:
            rows = zip(*(state[:LOOPED] for state in states), strict=True)
            for data.qpos, data.qvel, data.qacc in rows:
                mujoco.mj_inverse(model, data)
                data.qfrc_inverse.copy()

        return call

    return prepare


def row(contenders: dict[str, Contender], size: int, rounds: int) -> list[str]:
    """Return the columns of a table's line: each contender's time per state and relative speed."""
    states = random_states(size)
    calls = {name: prepare(states) for name, prepare in contenders.items()}
    counts = {name: min(size, LOOPED) if name in ONE_BY_ONE else size for name in calls}
    times = max(1, CALLED // size)
    measured = [
        {name: microseconds(call, times) / counts[name] for name, call in calls.items()}
        for _ in range(rounds + 1)
    ][1:]  # the first warms up, and compiles
    return [
        f"{statistics.median(r[name] for r in measured):>12.3f}"
        f"{statistics.median(r[REFERENCE] / r[name] for r in measured):>6.1f} x"
        for name in calls
    ]


def microseconds(call: Callable[[], object], times: int) -> float:
    """Return the time of a call [µs], mean of several."""
    return 1e6 * seconds(lambda: [call() for _ in range(times)]) / times


def random_states(size: int) -> States:
    """Return random q, qd, qdd of a fixed seed."""
    random = np.random.default_rng(0)
    return [random.uniform(-3, 3, (size, 6)) for _ in range(3)]


def print_memory(robot: Robot, effort: Effort) -> None:
    """Print the peak memory in addition to the result of 48 bytes per state, without the states."""
    torch.set_num_threads(1)
    arm = build_arm(robot, MODEL)
    print("\nplain inverse dynamics, float64: peak memory of the process beyond its result [MiB]")
    for size in effort.large:
        state = torch.ones(1, 6, dtype=torch.float64).expand(size, 6)
        inverse_dynamics(arm, state, state, state)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{size:>9}{peak - size * 48 / 2**20:>12.0f}")


if __name__ == "__main__":
    main()
