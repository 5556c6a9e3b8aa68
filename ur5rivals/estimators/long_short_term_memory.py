"""A long short-term memory for the motors' torque without contact [Oh et al. 2026].

NEXT learns the whole torque of the motors from the motion of the last second, without a model of
friction or links; the external torque is the measured torque less the predicted one. Its inputs are
q, q̇ and, if the target was recorded, the position error. A push moves the arm off its target, so
that the position error may reveal the contact to the network, which must not predict it; a second
estimator does not use this error.

For each path of the fit recordings, one network learns from the others and stops at its least error
on the left-out path; the same seed gives the same network. The external torque passes the low-pass
of causal least squares, tuned by the same rule. The network is smaller than the published one (two
layers of 128 units with dropout, a head of 256, states 20 ms apart), so that one processor trains
it in seconds.

S. Oh, J. J. Liu, T. Tao, P. Han, K. Shaw, S. Funabashi, R. Salakhutdinov, D. Pathak: FACTR 2:
Learning external force sensing for commodity robot arms improves policy learning. arXiv 2606.12406
(2026).
"""

from collections.abc import Sequence
from copy import deepcopy
from functools import partial
from typing import NamedTuple

import numpy as np
import torch
from torch import nn
from torch.nn.functional import mse_loss

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import starts
from ur5rivals.estimator import Contender, Learned
from ur5rivals.learned_residual import (
    Predict,
    TrainingSamples,
    beyond,
    cross_fitted,
    motor,
    standardised,
)
from ur5rivals.run import Estimate, Run

SEQUENCE_LENGTH = 20  # states that the network sees
SEQUENCE_STEP = 0.05  # s between them
SAMPLE_STEP = 0.04  # s between training samples
HIDDEN_UNITS, LEARNING_RATE = 64, 3e-3  # units; step size of Adam
MAX_STEPS, BATCH_SIZE = 600, 128  # steps of training, samples of each
STEPS_BETWEEN_CHECKS = 25  # of the error on the left-out path
PATIENCE_STEPS = 200  # training ends after so many steps without a smaller error on that path
SOURCE = "Oh et al. 2026"


class Tensors(NamedTuple):
    """Inputs (n, M) and torques (n, 6), standardised."""

    inputs: torch.Tensor
    torque: torch.Tensor


class Memory(nn.Module):
    """A network that predicts 6 torques from the last state of a memory that has read a sequence of
    states.
    """

    def __init__(self, states: int) -> None:
        """Make a network with random initial weights, always the same; states: numbers in each
        state of the sequence.
        """
        super().__init__()
        torch.manual_seed(0)
        self.states = states
        self.memory = nn.LSTM(states, HIDDEN_UNITS, batch_first=True)
        self.head = nn.Linear(HIDDEN_UNITS, 6)

    def forward(self, past: torch.Tensor) -> torch.Tensor:
        """Return torques (n, 6); past: (n, SEQUENCE_LENGTH * states)."""
        read, _ = self.memory(past.unflatten(1, (SEQUENCE_LENGTH, self.states)))
        return self.head(read[:, -1])


def train(learnt: TrainingSamples, left_out: TrainingSamples) -> Predict:
    """Return the prediction by a network with the weights that predict the left-out path best, of
    those passed while the squared error is minimised.
    """
    seen, unseen = (
        Tensors(*(torch.as_tensor(values, dtype=torch.float32) for values in batch))
        for batch in (learnt, left_out)
    )
    layers = Memory(learnt.inputs.shape[1] // SEQUENCE_LENGTH)
    optimiser = torch.optim.Adam(layers.parameters(), lr=LEARNING_RATE)
    drawn = torch.Generator().manual_seed(0)
    best, since, kept = float("inf"), 0, layers.state_dict()
    for k in range(MAX_STEPS):
        if k % STEPS_BETWEEN_CHECKS == 0:
            with torch.no_grad():
                error = mse_loss(layers(unseen.inputs), unseen.torque).item()
            if error < best:
                best, since, kept = error, k, deepcopy(layers.state_dict())
            elif k - since >= PATIENCE_STEPS:
                break
        batch = torch.randint(len(seen.inputs), (BATCH_SIZE,), generator=drawn)
        optimiser.zero_grad()
        mse_loss(layers(seen.inputs[batch]), seen.torque[batch]).backward()
        optimiser.step()
    layers.load_state_dict(kept)

    def predict(new: Array) -> Array:
        with torch.no_grad():
            return layers(torch.as_tensor(new, dtype=torch.float32)).double().numpy()

    return predict


def motion(run: Run, *, with_error: bool) -> TrainingSamples:
    """Return as inputs sequences of past states in the order of time, (N, SEQUENCE_LENGTH * 12, or
    18 with the position error), and as torque that of the motors, k i [Nm].

    Before the start of a stretch, its first state is repeated.
    """
    states = [run.q, run.qd]
    if with_error and run.position_error is not None:
        states.append(run.position_error)
    now = np.concatenate(states, axis=1)
    back = round(SEQUENCE_STEP / run.period) * np.arange(SEQUENCE_LENGTH)[::-1]
    first = np.maximum.accumulate(np.where(starts(run.segment), np.arange(len(now)), 0))
    rows = np.maximum(np.arange(len(now))[:, None] - back, first[:, None])
    return TrainingSamples(now[rows].reshape(len(now), -1), motor(run))


def learn(runs: Sequence[Run], *, with_error: bool) -> Learned:
    """Return the estimator with a network trained without each path in turn, and a tuned low-pass.
    Raises as `cross_fitted`, and InputError if with_error and a run has no position error.
    """
    if with_error and any(run.position_error is None for run in runs):
        raise InputError("target_q was not recorded, which the position error needs")
    of, network = partial(motion, with_error=with_error), partial(standardised, train)
    learned = beyond(cross_fitted(network, runs, SAMPLE_STEP, of), runs)

    def estimate(run: Run) -> Estimate | None:
        lacking = with_error and run.position_error is None
        return None if lacking else learned.method(run)

    return learned._replace(method=estimate)


ESTIMATORS = [
    Contender("LSTM, NEXT", SOURCE, True, partial(learn, with_error=True)),
    Contender("LSTM, NEXT without position error", SOURCE, True, partial(learn, with_error=False)),
]
