"""The results of a study, as the report's views read them."""

import os
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from datetime import date
from functools import cached_property
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.errors import InputError
from ur5lib.records.pushes import SmallestPush
from ur5lib.records.quality import UNREADABLE
from ur5lib.records.repetition import Repeated
from ur5lib.report.page.document import MOST_ROWS, MOST_SHOWN
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import bearing_joints
from ur5lib.strict import FAST_LOADER
from ur5lib.tables import read_csv
from ur5lib.workspace.places import IN_CLONE, WORKFLOW

AT_REST = "at rest"
PACKAGES = ["snakemake", "numpy", "scipy", "pandas", "pyarrow"]
PACKAGES += ["torch", "pytorch-kinematics", "mujoco", "matplotlib", "typst"]
OPTIONAL = {  # tables that not every study has
    "repetition": pd.DataFrame(columns=["robot", *(one.name for one in fields(Repeated))]),
    "pushes": pd.DataFrame(columns=["robot", *(one.name for one in fields(SmallestPush))]),
    # of topics, as far as they are read elsewhere
    "next_recordings": pd.DataFrame(columns=["robot", "after", "force"]),
    "printed": pd.DataFrame(columns=["table", "recording"]),
}


def with_zero(rows: pd.DataFrame, method: str, each: list[str]) -> pd.DataFrame:
    """Return rows, and after each recording's its `zero` as values of a further method "zero".

    method: column of the methods' names; each: columns that tell apart a method's rows.
    """
    zero = rows.dropna(subset="zero").drop_duplicates(["recording", *each], keep="last")
    both = pd.concat([rows, zero.assign(**{method: "zero", "value": zero["zero"]})])
    return both.iloc[np.argsort(pd.factorize(both["recording"])[0], kind="stable")]


@dataclass(frozen=True)
class Results:
    """A study's results.

    study: the configuration; tables: by name; figures: the folder of figures; drawn: recordings
    with figures; left_out: for each omitted section, a sentence with the reason; other_arms: those
    that are no UR arms; placeholders: those whose links are found from their measured torques;
    effort: that is measured, of torques where all arms measure these; bearing: by arm, the joints
    that gravity loads; loads: by arm, a known load [kg] that it carries well.
    """

    study: Mapping[str, Any]
    tables: Mapping[str, pd.DataFrame]
    figures: Path
    drawn: frozenset[str] = frozenset()
    commit: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    left_out: Sequence[str] = ()
    other_arms: frozenset[str] = frozenset()
    placeholders: frozenset[str] = frozenset()
    effort: Effort = CURRENT
    bearing: Mapping[str, Sequence[int]] = field(default_factory=dict)
    loads: Mapping[str, float] = field(default_factory=dict)

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
            study=yaml.load(study, FAST_LOADER),
            tables={path.stem: read_csv(path) for path in tables},
            figures=Path(os.path.commonpath(figures)),
            drawn=frozenset(path.parent.name for path in figures),
            commit=commit(),
            versions=versions(),
            other_arms=frozenset(arm.name for arm in arms if not arm.denavit_hartenberg),
            placeholders=frozenset(arm.name for arm in arms if arm.links == "unknown"),
            effort=TORQUE if {arm.measured for arm in arms} == {TORQUE} else CURRENT,
            bearing={arm.name: bearing_joints(arm) for arm in arms},
            loads={arm.name: load.mass for arm in arms if (load := arm.known_load())},
        )

    def of_run(self, name: str) -> "Results":
        """Return the results of one recording and of its arm.

        Raises InputError where the recording was left out.
        """
        if name not in {*self.tables["recordings"]["recording"]}:
            raise InputError(f"{name} cannot be read, see tables/quality.csv: it has no page")
        (entry,) = (one for one in self.study["recordings"] if one["name"] == name)
        title = f"{name}, {self.study['title']}"
        own = self._only([entry], self.arms()[name])
        return replace(own, study={**own.study, "title": title})

    def of_arm(self, robot: str) -> "Results":
        """Return the results of one arm's recordings."""
        arms = self.arms()
        entries = [one for one in self.study["recordings"] if arms[one["name"]] == robot]
        return self._only(entries, robot)

    def _only(self, entries: Sequence[Mapping[str, Any]], robot: str) -> "Results":
        """Return the results of some recordings, all of one arm, and of this arm."""
        known = {"recording": [one["name"] for one in entries], "robot": robot}
        tables = {
            table: self.rows(table, **{key: known[key] for key in known if key in rows})
            for table, rows in self.tables.items()
        }
        return replace(self, study={**self.study, "recordings": entries}, tables=tables)

    @property
    def many(self) -> bool:
        """Whether there are more recordings than a table has rows."""
        return len(self.study.get("recordings", ())) > MOST_ROWS

    def unusable(self) -> list[str]:
        """Return the recordings that were left out, because their files cannot be used."""
        used = {*self.tables["recordings"]["recording"]}
        return [name for name in self.roles() if name not in used]

    def roles(self) -> dict[str, str]:
        """Return the role of each recording, AT_REST of postures, which have no other use."""
        entries = self.study["recordings"]
        return {one["name"]: AT_REST if one.get("still") else one["role"] for one in entries}

    def with_role(self, role: str, among: Iterable[str] | None = None) -> list[str]:
        """Return the names of the recordings with a role, of all or among some."""
        roles = self.roles()
        names = roles if among is None else {*among}
        return [name for name in roles if roles[name] == role and name in names]

    def listed(self, table: str, column: str = "recording") -> list[str]:
        """Return the names in a column of a table, each once."""
        return [*self.tables[table][column].unique()]

    def printed(self, table: str) -> list[str]:
        """Return the names of the recordings with published values of a table."""
        return [*self.rows("printed", table=table)["recording"].unique()]

    @property
    def of_thesis(self) -> bool:
        """Whether the study is compared with published values."""
        return "reference" in self.study

    def moving(self, recording: str) -> set[int]:
        """Return the joints, from 1, that move on a recording."""
        return self._moving.get(recording, set())

    @cached_property
    def _moving(self) -> dict[str, set[int]]:
        """Return the moving joints by recording; cached, as views ask for them row by row."""
        moving = self.tables["recordings"].set_index("recording")["moving_joints"].dropna()
        return {
            str(recording): {int(float(joint)) for joint in str(joints).split()}
            for recording, joints in moving.items()
        }

    def stopped(self) -> bool:
        """Return whether a recording or an arm contradicts the study; one that cannot be read does
        not.
        """
        found = self.rows("quality", severity="stop")["finding"]
        return bool((found != UNREADABLE).any()) or len(self.rows("remarks", step="stop sign")) > 0

    def file_of(self, recording: str) -> str:
        """Return the robot's file of a recording, or the recording's name if it is a folder."""
        entries = {entry["name"]: entry for entry in self.study["recordings"]}
        return str(entries[recording].get("file", recording))

    def floors(self, quantity: str) -> dict[int, float]:
        """Return what repetition alone leaves of the errors of an arm's joints, where known."""
        rows = self.rows("repetition", quantity=quantity)
        return dict(zip(rows["joint"].astype(int), rows["floor"], strict=True))

    def floor(self, quantity: str, recording: str, place: int | str) -> float | None:
        """Return what repetition alone leaves of the errors on a recording, None if unknown.

        place: joint or component.
        """
        rows = self.rows("repetition", quantity=quantity, robot=self.arms()[recording])
        rows = rows[rows["component" if quantity == "force" else "joint"] == place]
        return float(rows["floor"].iloc[0]) if len(rows) else None

    def robots(self) -> list[str]:
        """Return the arms of the study."""
        return sorted({*self.arms().values()})

    def arms(self) -> dict[str, str]:
        """Return the arm of each recording, by its name in results."""
        return {entry["name"]: _arm(entry["robot"]) for entry in self.study["recordings"]}

    def dates(self) -> dict[str, date | None]:
        """Return the date of each recording, by its name."""
        entries = self.study["recordings"]
        given = {one["name"]: one.get("date") for one in entries}
        return {name: date.fromisoformat(str(own)) if own else None for name, own in given.items()}

    def shown(self, names: Sequence[str], most: int = MOST_SHOWN) -> list[str]:
        """Return the first few recordings, as a report has room for, of those with figures.

        Of many recordings, it is one: each has a page of its own.
        """
        most = 1 if self.many else most
        return [name for name in dict.fromkeys(names) if name in self.drawn][:most]

    def rows(self, table: str, /, **values: Any) -> pd.DataFrame:
        """Return the rows of a table with these values, in each column one or a list of them."""
        rows = self.tables.get(table, OPTIONAL.get(table))
        for column, value in values.items():
            rows = rows[rows[column].isin(value if isinstance(value, list) else [value])]
        return rows


def _arm(robot: str | Mapping[str, str]) -> str:
    """Return an arm's name in results, from its name or description in the study."""
    return robot if isinstance(robot, str) else robot.get("name", robot["arm"])


def versions() -> dict[str, str]:
    """Return the versions of the software on which the numbers depend."""
    return {"Python": platform.python_version()} | {
        name: metadata.version(name) for name in PACKAGES
    }


def commit() -> str:
    """Return the commit of the code, with "+ changes" when the files differ from it.

    Of an installed package, which has none, its version is returned.
    """
    if not IN_CLONE:
        return f"ur5lib {metadata.version('ur5lib')}"
    command = ["git", "-C", str(WORKFLOW), "describe", "--always", "--abbrev=12"]
    command += ["--dirty= + changes"]
    try:
        name = subprocess.check_output(command, text=True, stderr=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError):
        return "(unknown)"
    return name.strip()
