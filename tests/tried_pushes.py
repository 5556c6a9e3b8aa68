"""Trial pushes of a made-up detector."""

import numpy as np

from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import Trials, Untouched, pushes_at_each_place
from ur5lib.timeseries.arrays import Array, Mask

PERIOD, COUNT = 0.01, 30_000  # s, samples: five minutes
EYE = np.broadcast_to(np.eye(6), (COUNT, 6, 6))


def is_resting() -> Mask:
    """The samples (N,) at rest, the first half; the others are in fast motion."""
    return np.arange(COUNT) < COUNT / 2


def detected_above(limit: Array, typical: float = 15.0, seed: int = 0) -> Trials:
    """Return trials, about a typical contact [N], of a detector whose odds turn where a torque
    exceeds a limit (N,) [Nm]; none during an alarm of the first half minute.
    """

    run = Untouched(EYE, np.where(is_resting(), 0.0, 0.6), PERIOD, [(0, 3000)], np.ones((COUNT, 6)))
    pushes = pushes_at_each_place(run, np.random.default_rng(seed), typical)
    odds = 10 * (np.abs(pushes.torque).max(axis=1) - limit)
    return pushes.tried(run, alarms(odds, 0.0))
