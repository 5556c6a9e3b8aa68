"""F̂ᵐᵃᵖ, live: the estimator that `ur5 export --format live` writes, fed sample by sample.

Its inputs are the controller's positions, velocities and currents, unsmoothed. Its noise and
threshold are learnt from the fit runs; its constants are fixed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.records.measured import Measured
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.live.live_file import learned, numbers
from ur5lib.topics.live.live_recording import follow
from ur5rivals.estimator import Contender, Learned
from ur5rivals.run import Estimate, Run
from ur5rivals.tuning import latency

OURS_LIVE = "F̂ᵐᵃᵖ, live"
FALSE_PER_MIN = 1.0  # false alarms allowed a minute; no force depends on it


@dataclass(frozen=True)
class LiveMap:
    """The live estimator of `ur5 export --format live`; known: the result of `learned` on runs
    without contact.
    """

    known: dict[str, Any]

    def estimate(self, run: Run) -> Estimate | None:
        """Return the wrench and its deviation, None without the controller's samples."""
        if (given := inputs(run)) is None:
            return None
        arm, measured = given
        followed = follow({**arm, **self.known}, measured)
        return Estimate(followed.wrench, followed.std)

    def torque(self, run: Run) -> Array:
        """Return the joint torques Jᵀ F (N, 6) [Nm] that the estimate explains, NaN without one."""
        estimate = self.estimate(run)
        if estimate is None:
            return np.full_like(run.q, np.nan)
        return (run.jacobian.mT @ estimate.wrench[..., None])[..., 0]


def inputs(run: Run) -> tuple[dict[str, Any], Measured] | None:
    """Return `numbers` of a run's arm, by the fit without the run's path, and the controller's
    samples of the run; None without such samples.
    """
    if run.measured is None or run.arm is None:
        return None
    robot, friction, payload, place = run.arm
    return numbers(robot, friction, run.name, payload, place), run.measured


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator with the noise and the threshold that the runs show. Raises InputError
    if no run has the controller's samples.
    """
    given = {run: own for run in runs if (own := inputs(run)) is not None}
    known, paths = [*given.values()], len({run.path for run in given})
    if not known:
        raise InputError("no run has what its controller stated; name others")
    live = LiveMap(learned(known, paths, FALSE_PER_MIN))
    gain = {"gain": live.known["constants"]["gain"]}
    return Learned(live.estimate, gain, latency(live.torque, runs))


ESTIMATORS = [Contender(OURS_LIVE, "ours", True, learn)]
