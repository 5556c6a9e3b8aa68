"""No force at all: the baseline that every estimate has to beat. It states no band."""

from collections.abc import Sequence

import numpy as np

from ur5rivals.estimator import Contender, Learned
from ur5rivals.run import Estimate, Run


def learn(_: Sequence[Run]) -> Learned:
    """Return the estimate of no force; nothing is learnt."""
    return Learned(lambda run: Estimate(np.zeros_like(run.q)), {}, 0.0)


ESTIMATORS = [Contender("zero", "baseline", True, learn)]
