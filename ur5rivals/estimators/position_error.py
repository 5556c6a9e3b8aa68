"""The force from the position error of the joints' control loops [Stolt et al. 2012].

    τ̂_m = τ_model + K (q_target - q) + c,   τ_ext = τ_model + τ_f - τ̂_m

The motors' torque is the torque of the model plus that of the position loop, computed from the
position error instead of the current. The paper detunes a robot's loops, so that the error is large
and a given gain converts it into a torque. The loops here are stiff and closed, so that gains and
constant are fitted to the contact-free recordings, by least squares against the friction that the
loop must overcome there. The paper's estimator of the force, which is given the touching object, is
left out: all estimators compute the force from the torque in the same way.

A trial push cannot measure the latency, because the motion does not react to it. The low-pass has
the largest latency that the rule allows.

A. Stolt, M. Linderoth, A. Robertsson, R. Johansson: Force controlled robotic assembly without a
force sensor. ICRA (2012).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ur5lib.errors import InputError
from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.least_squares import LowPassed
from ur5rivals.run import Run
from ur5rivals.tuning import MAX_LATENCY, untuned


@dataclass(frozen=True)
class PositionError:
    """The external torque from the position error of the joints' loops.

    gain: K (6,) [Nm/rad]; constant: c (6,) [Nm].
    """

    gain: Array
    constant: Array

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm], NaN where the error is unknown."""
        assert run.position_error is not None
        feedback = self.gain * run.position_error + self.constant
        return LowPassed(MAX_LATENCY).filtered(run.friction - feedback, run)


def fitted_loops(runs: Sequence[Run]) -> PositionError:
    """Return the loops' gains and constants with which the position error explains the friction
    best, joint by joint.
    """
    error = np.concatenate([run.position_error for run in runs if run.position_error is not None])
    feedback = np.concatenate([run.friction - run.torque for run in runs])
    finite = finite_rows(error + feedback)
    lines = [np.polyfit(*pair, 1) for pair in zip(error[finite].T, feedback[finite].T, strict=True)]
    return PositionError(*np.transpose(lines))


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator with the loops' gains fitted to the runs. Raises InputError if the
    target angles were not recorded.
    """
    if any(run.position_error is None for run in runs):
        raise InputError("a recording to fit on has no target_q; record it")
    learned = untuned(fitted_loops(runs).torque, runs)
    return Learned(
        lambda run: None if run.position_error is None else learned.method(run),
        {"time_constant": MAX_LATENCY},
    )


ESTIMATORS = [Contender("position error", "Stolt et al. 2012", True, learn)]
