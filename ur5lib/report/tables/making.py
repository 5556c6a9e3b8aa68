"""The study's tables from the results of all recordings and arms: `columns.yaml` lists them.

Tidy: one value a row, SI units, joints from 1.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import pandas as pd

from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import ClosedLoop, Torques
from ur5lib.report.reference import Printed
from ur5lib.report.tables import files, forces, friction, models, motion
from ur5lib.report.tables.source import Source
from ur5lib.robots.description import load_robot
from ur5lib.strict import Strict, read_yaml
from ur5lib.tables import read_json

GROUPS: dict[str, ModuleType] = {
    "files": files,
    "motion": motion,
    "models": models,
    "friction": friction,
    "forces": forces,
}
READERS: dict[str, Callable[[str], Any]] = {
    "signals": Signals.read,
    "torques": Torques.read,
    "closed_loop": ClosedLoop.read,
    "arm": load_robot,
}
WORDS = {True: "yes", False: "no"}


class Declared(Strict):
    """A table: its columns; `kind`: only recordings or arms with this kind of result have rows."""

    kind: str
    columns: list[str]


class Declarations(Strict):
    """All tables, by the module that makes their rows."""

    files: dict[str, Declared]
    motion: dict[str, Declared]
    models: dict[str, Declared]
    friction: dict[str, Declared]
    forces: dict[str, Declared]

    def tables(self) -> dict[str, tuple[ModuleType, Declared]]:
        """Return the module and the declaration of each table."""
        return {
            name: (module, declared)
            for group, module in GROUPS.items()
            for name, declared in getattr(self, group).items()
        }


class LazyResults(Mapping[str, Any]):
    """The results of a kind by recording or arm, read on access; JSON, which is small, is cached.

    paths: each lies in the folder of its recording or arm.
    """

    def __init__(self, kind: str, paths: Sequence[str]) -> None:
        self._read = READERS.get(kind, cache(read_json))
        self._files = {Path(path).parent.name: path for path in paths}

    def __getitem__(self, name: str) -> Any:
        return self._read(self._files[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


@cache
def declarations() -> Declarations:
    """Return the declared tables."""
    path = Path(__file__).with_name("columns.yaml")
    return Declarations.model_validate(read_yaml(path))


def make_table(
    name: str, kinds: Mapping[str, Mapping[str, Any]], printed: Printed | None = None
) -> pd.DataFrame:
    """Return a table, with True and False as yes and no.

    kinds: results by their kind, then by recording or arm; printed: published tables.
    """
    module, declared = declarations().tables()[name]
    first = "recording" if "recording" in declared.columns else "robot"
    rows = [
        {first: owner} | {column: _in_words(value) for column, value in row.items()}
        for owner in kinds[declared.kind]
        for row in getattr(module, name)(Source(owner, kinds, printed or Printed()))
    ]
    return pd.DataFrame(rows, columns=declared.columns)


def _in_words(value: Any) -> Any:
    return WORDS[value] if isinstance(value, bool) else value
