"""Inverse dynamics on a GPU beside the processor of the same machine, in one run.

Million states a second, medians of rounds in which all take turns: on the processor; on the GPU
with the states there already; on the GPU with the states brought there and the torques fetched.
"error" is the GPU's largest difference from the processor in float64, as a share of the largest
torque of its joint.
"""

import platform
import statistics
from collections.abc import Callable

import torch
from torch import Tensor

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import timed
from ur5lib.dynamics.arm import ArmTensors, build_arm
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.robots.description import Robot, load_robot, robot_path

MODEL = "C+rotors"
VALUES = 24  # numbers read and written for each state: q, qd, qdd and the torque


def main() -> None:
    """Print the table, or that there is no GPU."""
    quick = options_of(__doc__).parse_args().quick
    if not torch.cuda.is_available():
        return print("no GPU is at hand")
    sizes = (1_000,) if quick else (10_000, 100_000, 1_000_000, 10_000_000)
    robot, rounds = load_robot(robot_path("ur5")), 1 if quick else 5
    bandwidth = copied_bytes_a_second(rounds)
    print(
        f"inverse dynamics, UR5 {MODEL}, PyTorch {torch.__version__}: "
        f"{torch.cuda.get_device_name()} ({bandwidth / 1e12:.2f} TB/s copied), "
        f"{torch.get_num_threads()} threads of {platform.machine()}"
    )
    columns = ("processor", "GPU", "with transfers", "of the memory limit", "error")
    print(f"{'states':>9}{'':>15}" + "".join(f"{name:>20}" for name in columns))
    for fused in (False, True)[: 2 - quick]:
        for dtype in (torch.float64, torch.float32):
            for size in sizes:
                print(line(robot, dtype, fused, size, rounds, bandwidth), flush=True)


def line(
    robot: Robot, dtype: torch.dtype, fused: bool, size: int, rounds: int, bandwidth: float
) -> str:
    """Return one line of the table."""
    here, there = (
        build_arm(robot, MODEL, dtype=dtype, device=device, fused=fused)
        for device in ("cpu", "cuda")
    )
    states = random_states(size, dtype)
    moved = [state.cuda() for state in states]
    rates = [
        size / time / 1e6
        for time in medians(
            [
                lambda: inverse_dynamics(here, *states),
                lambda: inverse_dynamics(there, *moved),
                lambda: inverse_dynamics(there, *(state.cuda() for state in states)).cpu(),
            ],
            rounds,
        )
    ]
    share = 1e6 * rates[1] * VALUES * dtype.itemsize / bandwidth
    label = f"{'fused' if fused else 'plain'} {str(dtype).removeprefix('torch.')}"
    cells = "".join(f"{rate:>20.1f}" for rate in rates)
    return f"{size:>9}{label:>15}{cells}{share:>20.1%}{error(robot, there, states):>20.0e}"


def random_states(size: int, dtype: torch.dtype) -> list[Tensor]:
    """Return random q, qd, qdd (N, 6) of a fixed seed."""
    random = torch.Generator().manual_seed(0)
    return [torch.rand(size, 6, dtype=dtype, generator=random) * 6 - 3 for _ in range(3)]


def error(robot: Robot, arm: ArmTensors, states: list[Tensor]) -> float:
    """Return the largest difference from the processor in float64, on the first 10,000 states."""
    few = [state[:10_000] for state in states]
    exact = inverse_dynamics(build_arm(robot, MODEL), *(state.double() for state in few))
    found = inverse_dynamics(arm, *(state.cuda() for state in few)).cpu().double()
    return float(((found - exact).abs() / exact.abs().amax(0)).max())


def copied_bytes_a_second(rounds: int) -> float:
    """Return the GPU's bandwidth [B/s], reading plus writing, for a copy of 1 GiB."""
    copied = torch.ones(1 << 28, device="cuda")
    return 2 * copied.nbytes / medians([copied.clone], rounds)[0]


def medians(calls: list[Callable[[], object]], rounds: int) -> list[float]:
    """Return the median time of each call [s], after one round that compiles and warms up."""
    measured = [[seconds(call) for call in calls] for _ in range(rounds + 1)][1:]
    return [statistics.median(times) for times in zip(*measured, strict=True)]


def seconds(call: Callable[[], object]) -> float:
    """Return the time of a call [s], until the GPU has finished."""

    def finished() -> None:
        call()
        torch.cuda.synchronize()

    torch.cuda.synchronize()
    return timed(finished)[0]


if __name__ == "__main__":
    main()
