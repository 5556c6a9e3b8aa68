"""Errors by joint or component beside those of an estimate of zero: mean and largest."""

from dataclasses import dataclass

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE, rounded
from ur5lib.report.document import Number, State
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.verdicts.states import state

ZERO = "an estimate of zero"


def by_joint(rows: pd.DataFrame, error: str, zero: str, name: str = "joint") -> pd.DataFrame:
    """Return mean error and zero's error over recordings, with low, high and count, by `name`.

    Joints or components whose zero has hardly an error are left out: nothing acts there.
    """
    groups = rows.groupby(name, sort=False)
    table = groups[error].agg(error="mean", low="min", high="max", count="size")
    table["zero"] = groups[zero].mean()
    return table[table["zero"] > SMALLEST_DIFFERENCE]


def largest(rows: pd.DataFrame, error: str, zero: str, name: str = "joint") -> pd.Series:
    """Return the largest error of a recording (place, recording, error, zero's error)."""
    row = rows.loc[rows[error].idxmax()]
    places = {"place": row[name], "recording": row["recording"]}
    return pd.Series(places | {"error": row[error], "zero": row[zero]})


@dataclass(frozen=True)
class AgainstBaseline:
    """Errors beside those of the baseline `zero`, by joint or component, and the largest error.

    errors, largest: of `by_joint` and `largest`; unit, digits: of the numbers; which: the words
    before a place, “on joint” or “along”; zero: name of the baseline.
    """

    errors: pd.DataFrame
    largest: pd.Series
    unit: str
    digits: int
    which: str = "on joint"
    zero: str = ZERO

    @property
    def worst(self) -> object:
        """The joint or component with the largest error relative to zero's."""
        return self._ratios().idxmax()

    def state(self, held: float = 1.0, tested: bool = True) -> State:
        """Judge the worst joint or component."""
        row = self.errors.loc[self.worst]
        return state(row["error"], row["zero"], held, tested)

    def percent(self) -> Sentence:
        """Return the worst error in per cent of zero's."""
        return say("error.worst", error=100 * float(self._ratios()[self.worst]))

    def shown(self) -> Sentence:
        """Return the worst error, its range over recordings, and its baseline."""
        row = self.errors.loc[self.worst]
        spread = rounded(row["low"], self.digits) != rounded(row["high"], self.digits)
        return say("error.with range", row=row, spread=spread, **self._words())

    def largest_shown(self) -> Sentence:
        """Return the largest error with its place, its recording and its baseline."""
        return say("error.largest", row=self.largest, which=self.which, **self._words())

    def drawing(self) -> str:
        """Draw the errors relative to zero's."""
        return bars({str(name): float(ratio) for name, ratio in self._ratios().items()})

    def numbers(self, name: str) -> tuple[Number, ...]:
        """Return the worst error with its range and baseline, and the largest on a recording."""
        row, prefix = self.errors.loc[self.worst], self.which.removeprefix("on ")
        prefix = "" if prefix == "along" else f"{prefix} "
        several = row["count"] > 1
        mean = Number(
            name=name,
            value=float(row["error"]),
            unit=self.unit,
            place=f"{prefix}{self.worst}",
            low=float(row["low"]) if several else None,
            high=float(row["high"]) if several else None,
            interval=f"range over {row['count']:.0f} recordings" if several else "",
            baseline=float(row["zero"]),
            baseline_of=self.zero,
        )
        worst_number = Number(
            name="largest error on a recording",
            value=float(self.largest["error"]),
            unit=self.unit,
            place=f"{prefix}{self.largest['place']} on {self.largest['recording']}",
            baseline=float(self.largest["zero"]),
            baseline_of=self.zero,
        )
        return mean, worst_number

    def _ratios(self) -> "pd.Series[float]":
        return self.errors["error"] / self.errors["zero"]

    def _words(self) -> dict[str, object]:
        return {"digits": self.digits, "unit": self.unit, "zero": self.zero}
