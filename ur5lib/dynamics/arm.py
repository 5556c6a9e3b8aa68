"""An arm under one of its link models as tensors, and its kernels evaluated in batches."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import torch
from torch import Tensor

from ur5lib.dynamics.tracing import Geometry, Kernel, Tail, straight_line
from ur5lib.robots.description import Robot
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import inertial_parameters, link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array

# Samples per batch: some hundred intermediate rows should fit into a processor's caches; a GPU
# needs enough samples for all its cores.
CPU_BATCH = 1 << 14
GPU_BATCH = 1 << 20


@dataclass(frozen=True)
class ArmTensors:
    """Parameters of the equations of motion of an arm of n joints; frame k is the
    Denavit-Hartenberg frame of link k.

    urdf: the arm as URDF, for `chains`;
    mass: (n,) [kg]; center_of_mass: (n, 3) [m] in frame k;
    inertia: (n, 3, 3) [kg m²] about the centre of mass, axes of frame k;
    rotor_inertia: (n,) [kg m²], seen through the gear;
    gravity: (3,) [m/s²] in the base frame;
    parameters: (11 n,), π of τ = Y π, see `inertial_parameters`, used by `rigid_body`;
    geometry: the lengths and twists, the same for all models; fused: see `build_arm`.
    """

    urdf: str
    mass: Tensor
    center_of_mass: Tensor
    inertia: Tensor
    rotor_inertia: Tensor
    gravity: Tensor
    parameters: Tensor
    geometry: Geometry
    fused: bool


def build_arm(
    robot: Robot,
    model: str,
    dtype: torch.dtype = torch.float64,
    device: str = "cpu",
    fused: bool = False,
) -> ArmTensors:
    """Build an arm under one of its models, e.g. "A", "B" or "C"; KeyError for an unknown model.

    dtype: float64, or float32, with errors below 1e-6 of the largest result. fused: torch.compile
    makes each term one loop. The first call takes 5 to 20 s, less if it was compiled before;
    further calls take a third of the time, which pays from tens of millions of samples on. Without
    a compiler, a warning is given and the terms run uncompiled.
    """
    bodies = rigid_bodies(robot, model)

    def tensor(values: object) -> Tensor:
        return torch.as_tensor(values, dtype=dtype, device=device)

    return ArmTensors(
        urdf=urdf(robot, bodies),
        mass=tensor(bodies.mass),
        center_of_mass=tensor(bodies.center_of_mass),
        inertia=tensor(bodies.inertia),
        rotor_inertia=tensor(bodies.rotor_inertia),
        gravity=tensor(robot.gravity),
        parameters=tensor(inertial_parameters(robot, bodies)),
        geometry=geometry(robot),
        fused=fused,
    )


def geometry(robot: Robot) -> Geometry:
    """Return lengths, twists and gravity of an arm as plain numbers; right angles are exact."""

    def exact(value: float) -> float:
        return round(value) + 0.0 if abs(value - round(value)) < 1e-15 else value

    return Geometry(
        tails=tuple(
            Tail(tuple(tuple(map(exact, row)) for row in rotation.tolist()), tuple(lever.tolist()))
            for rotation, lever in map(link_tail, robot.link_poses())
        ),
        gravity=robot.gravity,
    )


def evaluate(
    arm: ArmTensors, kernel: Kernel, *states: Tensor, wrench: Tensor | None = None
) -> Tensor:
    """Evaluate a kernel of (geometry, parameters, *states, wrench) for all samples.

    states: (N, n) each, of n joints; wrench: (N, 6). The kernel takes (n, N) and (6, N), and
    returns (..., N); the result is (N, ...). Raises ValueError for other shapes, different N, or
    another precision than the arm's.
    """
    joints, dtype = len(arm.geometry.joints), arm.parameters.dtype
    tensors = [*states] if wrench is None else [*states, wrench]
    widths = [joints] * len(states) + [6] * (len(tensors) - len(states))
    if any(
        (rows.shape, rows.dtype) != ((len(states[0]), width), dtype)
        for rows, width in zip(tensors, widths, strict=True)
    ):
        shapes = ", ".join(f"{tuple(rows.shape)} {rows.dtype}" for rows in tensors)
        raise ValueError(f"states must be (N, {joints}) of the same N, {dtype}, not {shapes}")
    program = (_fused if arm.fused else straight_line)(kernel, arm.geometry)

    def samples_first(*batch: Tensor) -> Tensor:
        rows = program(arm.parameters, *(state.T.contiguous() for state in batch))
        return rows.movedim(-1, 0)

    return in_batches(samples_first, batch_size(arm), *tensors)


def in_batches(function: Callable[..., Tensor], size: int, *states: Tensor) -> Tensor:
    """Evaluate function(*states) in batches of `size` samples: memory does not grow with N."""
    count = len(states[0])
    result = torch.empty(0)
    for start in range(0, max(count, 1), size):
        part = function(*(state[start : start + size] for state in states))
        if count <= size:
            return part.contiguous()
        if start == 0:
            result = part.new_empty(count, *part.shape[1:])
        result[start : start + size] = part
    return result


def batch_size(arm: ArmTensors) -> int:
    """Return the number of samples in a batch."""
    if arm.parameters.device.type != "cpu":
        return GPU_BATCH
    return CPU_BATCH * torch.get_num_threads() if arm.fused else CPU_BATCH


@cache
def _fused(kernel: Kernel, geometry: Geometry) -> Callable[..., Tensor]:
    """Return the program as one compiled loop; if compiling fails, warn once and run it plainly."""
    plain = straight_line(kernel, geometry)
    program: Callable[..., Tensor] = torch.compile(plain, dynamic=True)

    def run(*rows: Tensor) -> Tensor:
        nonlocal program
        try:
            return program(*rows)
        except torch._dynamo.exc.TorchDynamoException as error:
            reason, *_ = str(error).splitlines()
            warnings.warn(
                f"torch.compile fails, so the program is not fused: {reason}", stacklevel=2
            )
            program = plain
            return plain(*rows)

    return run


PullBack = Callable[[Array], tuple[Array, ...]]
"""From ∂f/∂value, an array like the value, to ∂f/∂state of each state, arrays like the states."""


def with_pull_back(function: Callable[..., Tensor], *states: Array) -> tuple[Array, PullBack]:
    """Return function(*states) and its pull-back, by automatic differentiation.

    The pull-back may be called once.
    """
    inputs = [torch.from_numpy(state).requires_grad_() for state in states]
    value = function(*inputs)

    def pull_back(sensitivity: Array) -> tuple[Array, ...]:
        change = (value * torch.from_numpy(sensitivity)).sum()  # of an array, torch loads sympy
        gradients = torch.autograd.grad(change, inputs, materialize_grads=True)
        return tuple(gradient.numpy() for gradient in gradients)

    return value.detach().numpy(), pull_back
