"""Values of the dynamics together with their derivatives: arrays in, arrays out."""

from collections.abc import Callable

import torch
from torch import Tensor

from ur5lib.timeseries.arrays import Array

PullBack = Callable[[Array], tuple[Array, ...]]
"""From ∂f/∂value, an array like the value, to ∂f/∂state of each state, arrays like the states."""


def with_pull_back(function: Callable[..., Tensor], *states: Array) -> tuple[Array, PullBack]:
    """Return function(*states) and its pull-back, by automatic differentiation.

    The pull-back may be called once.
    """
    inputs = [torch.from_numpy(state).requires_grad_() for state in states]
    value = function(*inputs)

    def pull_back(sensitivity: Array) -> tuple[Array, ...]:
        gradients = torch.autograd.grad(
            value, inputs, torch.from_numpy(sensitivity), materialize_grads=True
        )
        return tuple(gradient.numpy() for gradient in gradients)

    return value.detach().numpy(), pull_back
