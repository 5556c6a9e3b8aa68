"""A small neural network for the residual of friction and model [Yilmaz et al. 2020].

Two hidden layers of 32 units, Adam with weight decay. For each path of the fit recordings, one
network learns from the others and stops at its least error on the left-out path; the same seed
gives the same network. The predicted residual is subtracted before least squares (offline) and
before the momentum observer (causal).

N. Yilmaz, J. Y. Wu, P. Kazanzides, U. Tumerdem: Neural network based inverse dynamics
identification and external force estimation on the da Vinci Research Kit. ICRA (2020). There, a
network learns the whole torque; here, its residual.
"""

import torch
from torch import nn

from ur5lib.timeseries.arrays import Array
from ur5rivals.learned_residual import Predict, TrainingSamples, on_top

SAMPLE_STEP = 0.1  # s between samples
HIDDEN_UNITS, TRAINING_STEPS = 32, 400  # units of a layer; steps of Adam, each over all samples
LEARNING_RATE, WEIGHT_DECAY = 3e-3, 1e-2  # of Adam


def network() -> nn.Sequential:
    """Return a network from 18 inputs to 6 torques, with initial weights by a fixed seed.

    Its output is almost zero at first, so that an untrained network subtracts almost nothing.
    """
    torch.manual_seed(0)
    hidden = [
        nn.Linear(18, HIDDEN_UNITS),
        nn.Tanh(),
        nn.Linear(HIDDEN_UNITS, HIDDEN_UNITS),
        nn.Tanh(),
    ]
    last = nn.Linear(HIDDEN_UNITS, 6)
    nn.init.zeros_(last.weight)
    nn.init.zeros_(last.bias)
    return nn.Sequential(*hidden, last).double()


def train(learnt: TrainingSamples, left_out: TrainingSamples) -> Predict:
    """Return the prediction by a network with the weights that predict the left-out path best, of
    those passed while the squared error is minimised.
    """
    learnt_pair, left_pair = (tuple(map(torch.as_tensor, values)) for values in (learnt, left_out))
    layers = network()
    optimiser = torch.optim.AdamW(layers.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    best, best_weights = float("inf"), layers.state_dict()
    for _ in range(TRAINING_STEPS):
        with torch.no_grad():
            error = _error(layers, left_pair).item()
        if error < best:
            best, best_weights = (
                error,
                {name: values.clone() for name, values in layers.state_dict().items()},
            )
        optimiser.zero_grad()
        _error(layers, learnt_pair).backward()
        optimiser.step()
    layers.load_state_dict(best_weights)

    def predict(new: Array) -> Array:
        with torch.no_grad():
            return layers(torch.as_tensor(new)).numpy()

    return predict


def _error(layers: nn.Module, pair: tuple[torch.Tensor, ...]) -> torch.Tensor:
    """Return the mean squared error, in units of the torques' variance."""
    return ((layers(pair[0]) - pair[1]) ** 2).mean()


ESTIMATORS = on_top("neural network", "Yilmaz et al. 2020", train, SAMPLE_STEP)
