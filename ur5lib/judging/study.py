"""The tables of a study, and its configuration of recordings and arms."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import pandas as pd
import yaml

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.records.codes import Found
from ur5lib.records.pushes import PushDirection, SmallestPush
from ur5lib.records.quality import STOP
from ur5lib.records.repetition import Repeated
from ur5lib.records.verdicts import Reason, Verdict
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import bearing_joints
from ur5lib.strict import FAST_LOADER
from ur5lib.tables import read_csv

AT_REST, IN_MOTION = "at rest", "in motion"
OPTIONAL = {  # tables that not every study has
    "repetition": pd.DataFrame(columns=["robot", *(one.name for one in fields(Repeated))]),
    "pushes": pd.DataFrame(columns=["robot", *(one.name for one in fields(SmallestPush))]),
    "push_directions": pd.DataFrame(
        columns=["robot", *(one.name for one in fields(PushDirection))]
    ),
    "verdicts": pd.DataFrame(columns=[one.name for one in fields(Verdict)]),
}


@dataclass(frozen=True)
class StudyTables:
    """The tables of a study, by name, and its configuration.

    placeholders: the arms with links fitted to measured torques; effort: the measured effort,
    torque if all arms measure it, else current; bearing: by arm, the joints that gravity loads;
    loads: by arm, a load [kg] that it carries safely.
    """

    study: Mapping[str, Any]
    tables: Mapping[str, pd.DataFrame]
    placeholders: frozenset[str] = field(default=frozenset(), kw_only=True)
    effort: Effort = field(default=CURRENT, kw_only=True)
    bearing: Mapping[str, Sequence[int]] = field(default_factory=dict, kw_only=True)
    loads: Mapping[str, float] = field(default_factory=dict, kw_only=True)

    def of_arm(self, robot: str) -> Self:
        """Return the results of one arm's recordings."""
        arms = self.arms()
        entries = [one for one in self.study["recordings"] if arms[one["name"]] == robot]
        return self._only(entries, robot)

    def _only(self, entries: Sequence[Mapping[str, Any]], robot: str) -> Self:
        """Return the results of one arm and of its recordings `entries`."""
        known = {"recording": [one["name"] for one in entries], "robot": robot}
        tables = {
            table: self.rows(table, **{key: known[key] for key in known if key in rows})
            for table, rows in self.tables.items()
        }
        return replace(self, study={**self.study, "recordings": entries}, tables=tables)

    def unusable(self) -> list[str]:
        """Return the recordings that were left out, because their files cannot be used."""
        used = {*self.tables["recordings"]["recording"]}
        return [name for name in self.roles() if name not in used]

    def roles(self) -> dict[str, str]:
        """Return the role of each recording; recordings of postures have AT_REST."""
        entries = self.study["recordings"]
        return {one["name"]: AT_REST if one.get("still") else one["role"] for one in entries}

    def with_role(self, role: str, among: Iterable[str] | None = None) -> list[str]:
        """Return the names of the recordings with a role; among: names to select from, None for
        all.
        """
        roles = self.roles()
        names = roles if among is None else {*among}
        return [name for name in roles if roles[name] == role and name in names]

    def listed(self, table: str, column: str = "recording") -> list[str]:
        """Return the names in a column of a table, each once."""
        return [*self.tables[table][column].unique()]

    def moving(self, recording: str) -> set[int]:
        """Return the joints, from 1, that move on a recording."""
        return self._moving.get(recording, set())

    @cached_property
    def _moving(self) -> dict[str, set[int]]:
        """Return the moving joints by recording; cached, as views ask for them row by row."""
        moving = self.tables["recordings"].set_index("recording")["moving_joints"].dropna()
        return {str(name): {*map(int, joints.split())} for name, joints in moving.items()}

    def stopped(self) -> bool:
        """Return whether a recording or an arm has a stop sign, which contradicts the study; an
        unreadable recording does not count.
        """
        found = self.rows("quality", severity="stop")["code"]
        return bool((found != Found.UNREADABLE).any()) or len(self.rows("remarks", step=STOP)) > 0

    def file_of(self, recording: str) -> str:
        """Return the robot's file of a recording, or the recording's name if it is a folder."""
        entries = {entry["name"]: entry for entry in self.study["recordings"]}
        return str(entries[recording].get("file", recording))

    def loaded(self) -> list[str]:
        """Return the recordings on which the currents prove an undeclared load."""
        return [*self.rows("payload", taken="yes")["recording"]]

    def silent(self) -> set[str]:
        """Return the recordings without the arm's effort."""
        return {*self.rows("quality", code=Found.NO_CURRENTS)["recording"]}

    def touched(self) -> list[str]:
        """Return the recordings of fit and validate on which a force sensor reads contacts."""
        return [*self.rows("quality", code=Found.TOUCHED)["recording"].unique()]

    def quiet(self, role: str) -> list[str]:
        """Return the recordings of a role without contacts at a sensor and without an undeclared
        load.
        """
        disturbed = {*self.loaded(), *self.touched()}
        return [name for name in self.with_role(role) if name not in disturbed]

    def why_unseen_is_missing(self) -> Reason:
        """Return why no validate recording is quiet."""
        validate, touched = {*self.with_role("validate")}, {*self.touched()}
        if not validate or not validate <= touched | {*self.loaded()}:
            return "no_unseen"
        return "touched" if validate <= touched else "loaded"

    def doubted(self) -> list[str]:
        """Return the recordings on which the force sensor's bias is uncertain."""
        doubt = {"device": "force", "severity": "warning", "code": Found.OFFSET}
        return [*self.rows("quality", **doubt)["recording"].unique()]

    def robots(self) -> list[str]:
        """Return the arms of the study."""
        return sorted({*self.arms().values()})

    def arms(self) -> dict[str, str]:
        """Return the name in results of each recording's arm."""
        return {entry["name"]: _arm(entry["robot"]) for entry in self.study["recordings"]}

    def dates(self) -> dict[str, date | None]:
        """Return the date of each recording, by its name."""
        entries = self.study["recordings"]
        given = {one["name"]: one.get("date") for one in entries}
        return {name: date.fromisoformat(str(own)) if own else None for name, own in given.items()}

    def rows(self, table: str, /, **values: Any) -> pd.DataFrame:
        """Return the rows of a table in which each named column has the given value, or one of a
        list of values.
        """
        missing = table in OPTIONAL and table not in self.tables
        rows = OPTIONAL[table] if missing else self.tables[table]
        for column, value in values.items():
            rows = rows[rows[column].isin(value if isinstance(value, list) else [value])]
        return rows


def _arm(robot: str | Mapping[str, str]) -> str:
    """Return an arm's name in results, from its name or description in the study."""
    return robot if isinstance(robot, str) else robot.get("name", robot["arm"])


def read_tables(study: str, tables: Sequence[Path], arms: Sequence[Robot]) -> StudyTables:
    """Return the tables of a study.

    study: the configuration as YAML; tables: paths; arms: of the study.
    """
    return StudyTables(
        study=yaml.load(study, FAST_LOADER),
        tables={path.stem: read_csv(path) for path in tables},
        placeholders=frozenset(arm.name for arm in arms if arm.links == "unknown"),
        effort=TORQUE if {arm.measured for arm in arms} == {TORQUE} else CURRENT,
        bearing={arm.name: bearing_joints(arm) for arm in arms},
        loads={arm.name: load.mass for arm in arms if (load := arm.known_load())},
    )
