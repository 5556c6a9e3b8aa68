"""The results of a study, as the report's views read them."""

import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.judging.study import StudyTables, read_tables
from ur5lib.robots.description import Robot
from ur5lib.workspace.origin import commit

MOST_SHOWN = 4  # recordings with tables and figures of their own in one section
MOST_ROWS = 60  # of a table; with more recordings, none has a row of its own
PACKAGES = ["snakemake", "numpy", "scipy", "pandas", "pyarrow"]
PACKAGES += ["torch", "pytorch-kinematics", "mujoco", "matplotlib", "typst"]


def with_zero(rows: pd.DataFrame, method: str, each: list[str]) -> pd.DataFrame:
    """Return rows with further ones after those of each recording: the values of its column `zero`,
    as of a method "zero".

    method: column of the methods' names; each: columns that distinguish a method's rows.
    """
    zero = rows.dropna(subset="zero").drop_duplicates(["recording", *each], keep="last")
    both = pd.concat([rows, zero.assign(**{method: "zero", "value": zero["zero"]})])
    return both.iloc[np.argsort(pd.factorize(both["recording"])[0], kind="stable")]


@dataclass(frozen=True)
class Results(StudyTables):
    """A study's results, as the report's views read them.

    figures: the folder of figures; drawn: recordings with figures; commit, versions: of the
    software; other_arms: arms of other makers; first_number: number of the first recording, 1 for
    R1.
    """

    figures: Path = Path()
    drawn: frozenset[str] = frozenset()
    commit: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    other_arms: frozenset[str] = frozenset()
    first_number: int = 1

    @classmethod
    def read(
        cls,
        study: str,
        tables: Sequence[Path],
        figures: Sequence[Path],
        arms: Sequence[Robot] = (),
    ) -> "Results":
        """Read a study's results.

        study: the configuration as YAML; tables, figures: paths; arms: of the study.
        """
        return cls(
            **vars(read_tables(study, tables, arms)),
            figures=Path(os.path.commonpath(figures)),
            drawn=frozenset(path.parent.name for path in figures),
            commit=commit(),
            versions=versions(),
            other_arms=frozenset(arm.name for arm in arms if not arm.denavit_hartenberg),
        )

    def of_run(self, name: str) -> "Results":
        """Return the results of one recording and of its arm alone.

        Raises InputError where the recording was left out.
        """
        if name not in {*self.tables["recordings"]["recording"]}:
            raise InputError(f"{name} cannot be read, see tables/quality.csv: it has no page")
        (entry,) = (one for one in self.study["recordings"] if one["name"] == name)
        title = f"{name}, {self.study['title']}"
        own = self._only([entry], self.arms()[name])
        number = [*self.roles()].index(name) + 1
        return replace(own, study={**own.study, "title": title}, first_number=number)

    @property
    def many(self) -> bool:
        """Whether there are more recordings than a table has rows."""
        return len(self.study.get("recordings", ())) > MOST_ROWS

    def with_floor(self, rows: pd.DataFrame, quantity: str) -> pd.DataFrame:
        """Return rows with `floor`, the difference between repeated motions of the same arm, by
        component (of forces) or joint.
        """
        place = "component" if quantity == "force" else "joint"
        known = self.rows("repetition", quantity=quantity).drop_duplicates(["robot", place])
        floors = known.set_index(["robot", place])["floor"].to_dict()
        arms, places = rows["recording"].map(self.arms()), rows[place]
        return rows.assign(floor=[floors.get(key) for key in zip(arms, places, strict=True)])

    def shown(self, names: Sequence[str], most: int = MOST_SHOWN) -> list[str]:
        """Return the first `most` of the named recordings that have figures.

        Of a study with many recordings, only one is returned, since each has its own page.
        """
        most = 1 if self.many else most
        return [name for name in dict.fromkeys(names) if name in self.drawn][:most]


def versions() -> dict[str, str]:
    """Return the versions of the software on which the numbers depend."""
    return {"Python": platform.python_version()} | {
        name: metadata.version(name) for name in PACKAGES
    }
