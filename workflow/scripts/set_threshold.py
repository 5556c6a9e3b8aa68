"""Thresholds of each estimate, with few alarms in contact-free recordings: on its odds of contact,
or, of the controller's and the thesis's estimates, on the size of the force [N].
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ur5lib.force.detection import alarm_threshold, force_threshold
from ur5lib.pipeline.estimators import GATED, PUBLISHED
from ur5lib.records.forces import Forces, PublishedForces
from ur5lib.tables import write_json
from ur5lib.timeseries.arrays import Array

Evidence = Sequence[tuple[Mapping[str, Array], float]]  # by estimate, of a recording, and period


def set_threshold(input: Any, output: Any, params: Any) -> None:
    rate, own = params.false_alarms_per_min, [Forces.read(path) for path in input.forces]
    others = [PublishedForces.read(path) for path in input.published]
    odds = [(one.log_odds, one.period) for one in own]
    causal = [
        ({"causal": one.causal_log_odds}, one.period)
        for one in own
        if one.causal_log_odds is not None
    ]
    sizes = [
        ({name: np.linalg.norm(f[:, :3], axis=1) for name, f in one.corrected.items()}, one.period)
        for one in others
    ]
    found = thresholds(GATED, odds, alarm_threshold, rate)
    found |= thresholds(["causal"], causal, alarm_threshold, rate)
    # without odds of contact, no force is stated, and nothing stands beside the published ones
    if found:
        found |= thresholds([*PUBLISHED], sizes, force_threshold, rate)
    write_json(found, output.threshold)


def thresholds(
    names: Sequence[str],
    evidence: Evidence,
    of: Callable[[list[Array], list[float], float], float],
    rate: float,
) -> dict[str, float]:
    """Return the threshold of each estimate that a recording has; rate: alarms a minute."""
    result = {}
    for name in sorted(names):
        known = [(one[name], period) for one, period in evidence if name in one]
        if known:
            values, periods = zip(*known, strict=True)
            result[name] = of([*values], [*periods], rate)
    return result
