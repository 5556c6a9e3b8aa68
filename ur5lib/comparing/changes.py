"""The decision whether a number differs between two results by more than its error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import norm

from ur5lib.timeseries.arrays import Array

LEVEL = 0.05  # chance of any false change in a topic, and of a miss of a single interval
WORSE = 1.1  # ratio of two errors without interval from which they count as different


@dataclass(frozen=True)
class Comparison:
    """One number in two results, and whether it has changed between them.

    topic, name: of the number; before, after: its values with errors, as text; differs: whether the
    difference exceeds its 95 % interval; changed: whether it also exceeds the interval widened for
    the number of comparisons in the topic.
    """

    topic: str
    name: str
    before: str
    after: str
    differs: bool
    changed: bool

    def sentence(self) -> str:
        """Return the name and both values as a sentence."""
        return f"{self.name}: {self.before} before, {self.after} now"


def compare_estimates(
    topic: str, rows: pd.DataFrame, names: Sequence[str], unit: Sequence[str]
) -> list[Comparison]:
    """Compare estimates by their 95 % intervals, as independent normal variables.

    rows: one pair of estimates each, with columns `value` and `half` (half of the interval's width)
    that have the suffixes `_a` (before) and `_b` (after); names, unit: of each row. An estimate has
    changed if the difference exceeds its interval, widened by Bonferroni's correction for the
    number of rows.
    """
    # `to_numpy(float)` also gives the right shape and type without rows.
    numbers = rows[["value_a", "value_b", "half_a", "half_b"]].to_numpy(float)
    difference = np.abs(numbers[:, 1] - numbers[:, 0])
    half = np.hypot(numbers[:, 2], numbers[:, 3])
    wider = norm.isf(LEVEL / 2 / max(len(rows), 1)) / norm.isf(LEVEL / 2)
    texts = [
        [
            _with_error(value, width, measure)
            for value, width, measure in zip(
                rows[f"value_{side}"], rows[f"half_{side}"], unit, strict=True
            )
        ]
        for side in "ab"
    ]
    verdicts = ((difference > half).tolist(), (difference > wider * half).tolist())
    return [Comparison(topic, *row) for row in zip(names, *texts, *verdicts, strict=True)]


def compare_errors(
    topic: str, rows: pd.DataFrame, names: Sequence[str], unit: str
) -> list[Comparison]:
    """Compare errors that have no interval; they have changed if their ratio exceeds WORSE.

    rows: one pair of errors each, `value_a` (before) and `value_b` (after); names: of each row.
    """
    changed = _ratio(rows["value_a"].to_numpy(float), rows["value_b"].to_numpy(float)) > WORSE
    return [
        Comparison(topic, name, f"{a:.3g} {unit}", f"{b:.3g} {unit}", bool(is_new), bool(is_new))
        for name, a, b, is_new in zip(names, rows["value_a"], rows["value_b"], changed, strict=True)
    ]


def _ratio(before: Array, after: Array) -> Array:
    """Return the ratio, at least 1, of the larger to the smaller error; 1 where both are zero."""
    low, high = np.minimum(before, after), np.maximum(before, after)
    ratio: Array = np.divide(high, low, out=np.full(len(low), np.inf), where=low > 0)
    return np.where(high == 0, 1.0, ratio)


def _with_error(value: float, half: float, unit: str) -> str:
    return f"{value:.4g} ± {half:.2g} {unit}".strip()
