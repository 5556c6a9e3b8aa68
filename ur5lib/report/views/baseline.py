"""Errors beside those of an estimate of zero, the state that follows from them.

docs/report.md explains the states.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import pandas as pd

from ur5lib.report.page.document import Number, State
from ur5lib.report.page.formats import VISIBLE_DIFFERENCE, measured
from ur5lib.report.page.sentences import say

ZERO_ESTIMATE = "zero baseline"
MIN_GOOD_SKILL = 0.5  # smallest skill of a good estimate: less than half the error of zero
BETTER_RIVAL_RATIO = 0.95  # share of an error, below which another is clearly less
MAX_GOOD_FLOORS = 3.0  # of a good estimate's error, in what repetition alone leaves
MIN_GOOD_BAND_FACTOR = 0.5  # share of its width with which a good 95 % band would not hold
MIN_GOOD_COVERAGE = 0.9  # smallest share of readings in a good 95 % band
WIDE_BAND_COVERAGE = 0.99  # smallest share, from which on a 95 % band is wider than it states


def state(
    error: float,
    zero: float,
    coverage: float = 1.0,
    tested: bool = True,
    better: float = MIN_GOOD_SKILL,
    plain: float = math.nan,
    floor: float = math.nan,
) -> State:
    """Return the state of an error beside its rivals: zero, the simplest method, repetition.

    coverage: share of readings in the stated 95 % band; tested: whether the error comes from
    recordings that no fit has seen and, where errors have intervals, has one; better: least skill
    of a good estimate; plain: error of the simplest method; floor: what repetition alone leaves.
    """
    if math.isnan(error) or not zero > 0:
        return "not determined"
    skill = 1 - error / zero
    if skill <= 0:
        return "do not use"
    beaten = error >= BETTER_RIVAL_RATIO * plain or error > MAX_GOOD_FLOORS * floor
    sure = coverage >= MIN_GOOD_COVERAGE and tested and not beaten
    return "good" if skill > better and sure else "usable"


@dataclass(frozen=True)
class Rival:
    """A simple method beside ours.

    means: of the errors, columns `ours` and `rival`, by joint, component or recording.
    """

    name: str
    means: pd.DataFrame

    @property
    def better(self) -> pd.DataFrame:
        """Where it errs clearly less."""
        means = self.means
        seen = means["ours"] - means["rival"] > VISIBLE_DIFFERENCE
        return means[seen & (means["rival"] < BETTER_RIVAL_RATIO * means["ours"])]

    @property
    def equal(self) -> pd.DataFrame:
        """Where it errs neither clearly less nor clearly more."""
        means = self.means[self.means["ours"] > VISIBLE_DIFFERENCE].drop(
            self.better.index, errors="ignore"
        )
        return means[means["ours"] >= BETTER_RIVAL_RATIO * means["rival"]]

    @classmethod
    def beside(
        cls, name: str, rows: pd.DataFrame, error: str, place: str, models: Mapping[str, str]
    ) -> Self:
        """Compare errors by place; models: `ours` and `rival` by their names in the column of
        models, `model` or `estimate`.
        """
        column = "model" if "model" in rows else "estimate"
        rows = rows.assign(who=rows[column].map(models))
        means = rows.pivot_table(error, place, "who", sort=False)
        return cls(name, means.reindex(columns=["ours", "rival"]))

    def after(self, verdict: str, unit: str) -> str:
        """Return the sentence of a verdict, and where the rival errs less."""
        if self.better.empty:
            return verdict
        words = {"better": self.better, "joints": self.better.index.name == "joint"}
        return " ".join([verdict, say("error.rival", name=self.name, unit=unit, **words)])


@dataclass(frozen=True)
class AgainstBaseline:
    """Errors beside those of the baseline `zero`, by joint or component (column `place`).

    rows: by recording and place, with the errors in the columns `error` and `baseline`; unit: of
    the numbers; zero: name of the baseline; floors: what repetition alone leaves, by joint or
    component, where that is known; rival: the simplest method.
    """

    rows: pd.DataFrame
    error: str
    baseline: str
    unit: str
    place: str = "joint"
    zero: str = ZERO_ESTIMATE
    floors: Mapping[Any, float] = field(default_factory=dict)
    rival: Rival | None = None

    @cached_property
    def errors(self) -> pd.DataFrame:
        """Mean error and zero's error over recordings, with low, high and count, by place.

        Places whose zero has hardly an error are left out: nothing acts there.
        """
        groups = self.rows.groupby(self.place, sort=False)
        table = groups[self.error].agg(error="mean", low="min", high="max", count="size")
        table["zero"] = groups[self.baseline].mean()
        return table[table["zero"] > VISIBLE_DIFFERENCE]

    @cached_property
    def worst(self) -> pd.Series:
        """The row of `errors` with the largest error relative to zero's; its name is the place."""
        return self.errors.loc[(self.errors["error"] / self.errors["zero"]).idxmax()]

    @cached_property
    def largest(self) -> pd.Series:
        """The largest error of a recording, of components among those of the worst one's unit."""
        rows = self.rows
        if self.place == "component":
            turns = rows["component"].str.startswith("r")
            rows = rows[turns == str(self.worst.name).startswith("r")]
        names = {self.place: "place", self.error: "error", self.baseline: "zero"}
        return rows.loc[rows[self.error].idxmax()].rename(names)

    def by_place(self) -> pd.DataFrame:
        """Return `errors` with the largest error of a recording, this recording, and the floor."""
        rows = self.rows.loc[self.rows.groupby(self.place)[self.error].idxmax()]
        most = rows.set_index(self.place)[[self.error, "recording"]]
        table = self.errors.join(most.set_axis(["largest", "recording"], axis="columns"))
        return table.assign(floor=table.index.map(lambda place: self.floors.get(place, math.nan)))

    def floor(self) -> float:
        """Return what repetition alone leaves at the worst place, NaN where that is unknown."""
        return self.floors.get(self.worst.name, math.nan)

    def plain(self) -> float:
        """Return the error of the simplest method at the worst place, NaN where that is unknown."""
        known = {} if self.rival is None else self.rival.means["rival"].to_dict()
        return float(known.get(self.worst.name, math.nan))

    @cached_property
    def in_floors(self) -> pd.Series:
        """Errors in what repetition alone leaves, the largest first, where that is known."""
        floors = pd.Series(self.floors, dtype=float)
        return (self.errors["error"] / floors).dropna().sort_values(ascending=False)

    def state(
        self, coverage: float = 1.0, tested: bool = True, better: float = MIN_GOOD_SKILL
    ) -> State:
        """Judge the worst joint or component, where a rival errs less, and the one farthest above
        its floor; arguments as of the function `state`.
        """
        close = not (self.in_floors > MAX_GOOD_FLOORS).any()
        rival = self.rival
        unbeaten = close and (rival is None or (rival.better.empty and rival.equal.empty))
        errors = self.worst["error"], self.worst["zero"]
        return state(*errors, coverage, tested and unbeaten, better)

    def after(self, verdict: str) -> str:
        """Return the sentence of a verdict, with where a rival does no worse."""
        told = [verdict if self.rival is None else self.rival.after(verdict, self.unit)]
        if self.rival is not None and len(self.rival.equal):
            told.append(say("error.equal", against=self))
        if len(self.in_floors) and self.in_floors.iloc[0] > MAX_GOOD_FLOORS:
            told.append(say("error.far", against=self))
        return " ".join(told)

    def percent(self) -> str:
        """Return the worst error in per cent of zero's."""
        return say("error.worst", row=self.worst)

    def shown(self) -> str:
        """Return the worst error, its range over recordings, and its baseline."""
        low, high = (measured(self.worst[end]) for end in ("low", "high"))
        return say("error.with range", row=self.worst, spread=low != high, against=self)

    def largest_shown(self) -> str:
        """Return the largest error with its place, its recording and its baseline."""
        return say("error.largest", row=self.largest, against=self)

    def numbers(self, name: str) -> tuple[Number, Number]:
        """Return the worst error with its range and baseline, and the largest on a recording."""
        row, largest = self.worst, self.largest
        prefix = "joint " if self.place == "joint" else ""
        mean = Number(name, float(row["error"]), self.unit, f"{prefix}{row.name}")
        if row["count"] > 1:
            mean = mean.within(row["low"], row["high"], f"range over {row['count']:.0f} recordings")
        place = f"{prefix}{largest['place']} on {largest['recording']}"
        most = Number("largest error on a recording", float(largest["error"]), self.unit, place)
        mean = mean.above(self.floor())
        return mean.beside(row["zero"], self.zero), most.beside(largest["zero"], self.zero)
