"""Evaluation of kernels over any number of samples, in batches that fit the caches."""

import warnings
from collections.abc import Callable
from functools import cache

import torch
from torch import Tensor

from ur5lib.dynamics.arm import Arm
from ur5lib.dynamics.tracing import Geometry, Kernel, straight_line

# Samples per batch: some hundred intermediate rows should stay in the caches of a processor; a GPU
# needs enough for all its cores.
CPU, GPU = 1 << 14, 1 << 20


def evaluate(arm: Arm, kernel: Kernel, *states: Tensor, wrench: Tensor | None = None) -> Tensor:
    """Evaluate a kernel of (geometry, parameters, *states, wrench) for all samples.

    states: (N, n) each, of n joints; wrench: (N, 6). The kernel takes (n, N) and (6, N). Returns
    (N, ...) of its (..., N).
    Raises ValueError where they are not of these shapes with the same N, or not of the arm's
    precision.
    """
    joints, dtype = len(arm.geometry.joints), arm.parameters.dtype
    given = [*states] if wrench is None else [*states, wrench]
    widths = [joints] * len(states) + [6] * (len(given) - len(states))
    if any(
        (rows.shape, rows.dtype) != ((len(states[0]), width), dtype)
        for rows, width in zip(given, widths, strict=True)
    ):
        found = ", ".join(f"{tuple(rows.shape)} {rows.dtype}" for rows in given)
        raise ValueError(f"states must be (N, {joints}) of the same N, {dtype}, not {found}")
    program = (_fused if arm.fused else straight_line)(kernel, arm.geometry)

    def samples_first(*batch: Tensor) -> Tensor:
        rows = program(arm.parameters, *(state.T.contiguous() for state in batch))
        return rows.movedim(-1, 0)

    return in_batches(samples_first, batch_size(arm), *given)


def in_batches(function: Callable[..., Tensor], size: int, *states: Tensor) -> Tensor:
    """Evaluate function(*states) in batches, so that its memory does not grow with N."""
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


def batch_size(arm: Arm) -> int:
    """Return the number of samples in a batch."""
    if arm.parameters.device.type != "cpu":
        return GPU
    return CPU * torch.get_num_threads() if arm.fused else CPU


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
