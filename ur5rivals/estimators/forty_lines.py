"""F̂ᵐᵃᵖ in forty lines: what a new idea has to beat.

The background is the running median of the torque. A contact begins where the rest exceeds
CONTACT_START deviations of its fast error, and ends below CONTACT_END. What gears and stiction took
of it is given back, and the wrench is a ridge regression: the most probable one, with a prior of
PRIOR_FORCE.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from ur5lib.force.contact_prior import wrench_covariance
from ur5lib.force.contact_wrench import regularised_wrench
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import MEAN_STICTION, mean_stiction_torque
from ur5lib.force.gate import diagonal
from ur5lib.force.residual_model import USUAL_STICTION, ResidualModel
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import by_segment, inside_spans, spans
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.ours import OURS
from ur5rivals.force import breakaway_of, learned_noise
from ur5rivals.run import Estimate, Run

MEDIAN_SPAN = 10.0  # s; the median is taken over it
CONTACT_START, CONTACT_END = 8.0, 2.0  # deviations
PRIOR_FORCE = 30.0  # N
# A contact has this lever [m]; friction takes of it, in motion, this share of the breakaway torque
# and, in the gears, this share of the torque that they carry.
LEVER, RUBBING, LOSS = 0.03, 0.2, 0.1


def running_median(torque: Array, samples: int) -> Array:
    """Return the median (N, 6) of `samples` values of a torque around each, unknown ones
    left out.
    """
    frame = pd.DataFrame(torque)
    return frame.rolling(samples, center=True, min_periods=1).median().to_numpy(np.float64)


def estimate(run: Run, noise: ResidualModel) -> Estimate:
    """Return wrench and standard deviation of a run; noise: of its low-passed torque."""
    median = partial(running_median, samples=round(MEDIAN_SPAN / run.period))
    rest = run.smoothed - by_segment(median, run.smoothed, run.segment)
    still, deviation = run.states == JointState.STILL, noise.change[run.states, np.arange(6)]
    size = np.nan_to_num(np.linalg.norm(rest / deviation, axis=1))
    touched = inside_spans(spans(size, CONTACT_START, CONTACT_END), len(size))
    # gears and stiction
    carried, _ = run.gears.where_moving(run.states).contact_torque(rest)
    carried += still * mean_stiction_torque(carried, noise.breakaway, USUAL_STICTION)
    absorbed = np.where(still, USUAL_STICTION * np.sqrt(1 - MEAN_STICTION**2), RUBBING)
    taken = absorbed * noise.breakaway
    lost = LOSS * carried
    # ridge
    covariance = diagonal(deviation**2 + taken**2 + lost**2)
    wrench, std = np.full_like(rest, np.nan), np.full_like(rest, np.nan)
    finite = np.isfinite(rest).all(axis=1) & np.isfinite(run.jacobian).all(axis=(1, 2))
    prior = wrench_covariance(PRIOR_FORCE, LEVER)
    wrenches = regularised_wrench(carried[finite], run.jacobian[finite], covariance[finite], prior)
    wrench[finite] = np.where(touched[finite, None], wrenches.mean, 0.0)
    std[finite] = np.sqrt(np.linalg.diagonal(wrenches.covariance))
    return Estimate(wrench, std)


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator with the noise of the torque that the runs show."""
    noise = learned_noise(lambda run: run.smoothed, runs, breakaway_of(runs))
    return Learned(lambda run: estimate(run, noise), {})


ESTIMATORS = [Contender(f"{OURS} in forty lines", "ours", False, learn)]
