"""The rules that turn an error and its baseline into a state; docs/report.md explains them."""

import math

from ur5lib.report.document import State

BETTER = 0.5  # smallest skill of a good estimate: less than half the error of zero
HELD = 0.9  # smallest share of readings in a good 95 % band


def state(error: float, zero: float, held: float = 1.0, tested: bool = True) -> State:
    """Return the state of an error beside the error of an estimate of zero.

    held: share of readings in the stated 95 % band; tested: whether the error comes from recordings
    that no fit has seen and, where errors have intervals, has one.
    """
    if math.isnan(error) or not zero > 0:
        return "not determined"
    skill = 1 - error / zero
    if skill <= 0:
        return "do not use"
    return "good" if skill > BETTER and held >= HELD and tested else "usable"
