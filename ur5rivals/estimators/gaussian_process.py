"""A Gaussian process for the residual of friction and model [Rasmussen and Williams 2006].

It is exact, on samples 0.4 s apart. The kernel is a squared exponential with one length each for q,
q̇ and the model's torque, common to all joints; lengths, amplitude and noise maximise the marginal
likelihood of the contact-free torque (their Equation 5.8) times a lognormal prior, without which
the lengths diverge on few paths. The predicted residual is subtracted before least squares
(offline) and before the momentum observer (causal).

C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning. MIT Press (2006).
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.optimize import Bounds, minimize

from ur5lib.timeseries.arrays import Array
from ur5rivals.learned_residual import Predict, TrainingSamples, on_top

SAMPLE_STEP = 0.4  # s between samples, beyond which the torque's errors are nearly independent
MAX_ITERATIONS = 60  # of L-BFGS
# Index of the length of each input.
LENGTH_OF_INPUT = torch.tensor([0] * 6 + [1] * 6 + [2] * 6)
# Start of the search and centre of the prior, whose width is 1: logarithms of lengths, amplitude
# and noise in units of the standard deviations.
PRIOR_LOGARITHMS = [1.5, 1.5, 1.5, 0.0, -0.5]
SEARCH_WIDTH = 5.0  # of the search, in widths of the prior


def kernel(first: torch.Tensor, second: torch.Tensor, logs: torch.Tensor) -> torch.Tensor:
    """Return the covariances (n, m) between inputs (n, 18) and (m, 18)."""
    length = logs[:3].exp()[LENGTH_OF_INPUT]
    exact = "donot_use_mm_for_euclid_dist"
    squares = torch.cdist(first / length, second / length, compute_mode=exact) ** 2
    return (2 * logs[3]).exp() * torch.exp(-squares / 2)


def factor(points: torch.Tensor, logs: torch.Tensor) -> torch.Tensor:
    """Return the Cholesky factor (n, n) of K + σ² I."""
    noise = (2 * logs[4]).exp() + 1e-6
    return torch.linalg.cholesky(kernel(points, points, logs) + noise * torch.eye(len(points)))


def negative_log_likelihood(
    points: torch.Tensor, values: torch.Tensor, logs: torch.Tensor
) -> torch.Tensor:
    """Return the negative log-likelihood Σ ½ yᵀ (K + σ² I)⁻¹ y + ½ log |K + σ² I| over the joints,
    up to a constant.
    """
    root = factor(points, logs)
    whitened = torch.linalg.solve_triangular(root, values, upper=False)
    return (whitened**2).sum() / 2 + values.shape[1] * root.diagonal().log().sum()


def train(learnt: TrainingSamples, _: TrainingSamples) -> Predict:
    """Return a function that predicts the residual by a fitted process; the left-out path is not
    needed.
    """
    points, values = map(torch.as_tensor, learnt)
    logs = most_probable(partial(negative_log_likelihood, points, values), PRIOR_LOGARITHMS)
    weights = torch.cholesky_solve(values, factor(points, logs))

    def predict(new: Array) -> Array:
        return (kernel(torch.as_tensor(new), points, logs) @ weights).numpy()

    return predict


def most_probable(
    misfit: Callable[[torch.Tensor], torch.Tensor], centre: ArrayLike
) -> torch.Tensor:
    """Return the logarithms (n,) of maximum posterior density.

    misfit: negative log-likelihood; centre: of the normal prior (n,) with standard deviations 1.
    """
    centre = np.asarray(centre)

    def cost(logs: Array) -> tuple[float, Array]:
        at = torch.tensor(logs, requires_grad=True)
        unlikely = ((at - torch.as_tensor(centre)) ** 2).sum() / 2
        loss = misfit(at) + unlikely
        (slope,) = torch.autograd.grad(loss, at)
        return loss.item(), slope.numpy()

    bounds = Bounds(centre - SEARCH_WIDTH, centre + SEARCH_WIDTH)
    solution = minimize(cost, centre, jac=True, bounds=bounds, options={"maxiter": MAX_ITERATIONS})
    return torch.as_tensor(solution.x)


ESTIMATORS = on_top("Gaussian process", "Rasmussen and Williams 2006", train, SAMPLE_STEP)
