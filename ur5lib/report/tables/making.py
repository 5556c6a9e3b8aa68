"""The study's tables from the results of all recordings and arms: `columns.yaml` lists them.

Tidy: one value a row, SI units, joints from 1.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.published_constants import PublishedConstants
from ur5lib.pipeline.records.accelerations import ImuComparison
from ur5lib.pipeline.records.closed_loop import ClosedLoop
from ur5lib.pipeline.records.contacts import Detected, TouchedLinks
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.force_errors import Ablated, Audit, Compared
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.gains import GainSummary
from ur5lib.pipeline.records.models import Identification, Rotors
from ur5lib.pipeline.records.motion import MotionAccount
from ur5lib.pipeline.records.prediction import Prediction
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Contradictions, Quality
from ur5lib.report.reference import Printed
from ur5lib.report.tables import files, forces, friction, models, motion
from ur5lib.report.tables.forces import LINKS
from ur5lib.report.tables.source import Published, Row
from ur5lib.robots.description import load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.strict import read_yaml
from ur5lib.tables import ByKey, read_cells, read_record

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
RECORDS: dict[str, type] = {
    "quality": Quality,
    "clocks": dict[str, SettledClock],
    "contradictions": Contradictions,
    "gains": GainSummary,
    "accelerations": ImuComparison,
    "motion": dict[str, MotionAccount],
    "fused": dict[str, MotionAccount],
    "forces": Compared,
    "constants": PublishedConstants,
    "rotors": Rotors,
    "identification": Identification,
    "calibration": dict[str, ImuCalibration],
    "friction": Friction,
    "residuals": Residuals,
    "currents": Prediction,
    "detection": dict[str, Detected],
    "links": dict[str, list[TouchedLinks]],
    "ablation": dict[str, Ablated],
    "audit": Audit,
}
WORDS = {True: "yes", False: "no"}


class Declared(NamedTuple):
    """A table: its columns, the function that makes its rows, and the parameters of this."""

    columns: list[str]
    rows: Callable[..., Iterator[Row]]
    needs: list[str]


def lazy_results(kind: str, paths: Sequence[str]) -> ByKey[Any]:
    """Return the results of a kind by recording or arm, read on access; JSON, small, is cached.

    paths: each lies in the folder of its recording or arm.
    """
    read = READERS.get(kind) or cache(partial(read_record, RECORDS[kind]))
    return ByKey({Path(path).parent.name: partial(read, path) for path in paths})


@cache
def declarations() -> dict[str, Declared]:
    """Return each declared table."""
    groups = read_yaml(Path(__file__).with_name("columns.yaml"))
    return {
        name: Declared(columns, rows, [*inspect.signature(rows).parameters])
        for group, module in GROUPS.items()
        for name, columns in groups[group].items()
        for rows in [getattr(module, name)]
    }


def make_table(
    name: str, kinds: Mapping[str, Mapping[str, Any]], printed: Printed | None = None
) -> pd.DataFrame:
    """Return a table, with True and False as yes and no.

    kinds: results by their kind, then by recording or arm; printed: published tables.
    """
    columns, rows_of, needs = declarations()[name]
    first = "recording" if "recording" in columns else "robot"

    def given(need: str, owner: str) -> Any:
        if need == "published":
            return Published(printed or Printed(), owner)
        return kinds[needs[0]] if need == "every" else kinds[need].get(owner)

    rows = [
        {first: owner} | {column: _in_words(value) for column, value in row.items()}
        for owner in kinds[needs[0]]
        for row in rows_of(*(given(need, owner) for need in needs))
    ]
    more = sorted({name for row in rows for name in row if name in LINKS} - {*columns})
    return pd.DataFrame(rows, columns=[*columns, *more])


def joined(parts: Sequence[str]) -> pd.DataFrame:
    """Return a table that a step has written for each arm, in the folder of its name.

    parts: paths; their cells are taken over as text.
    """
    tables = {Path(part).parent.name: read_cells(part) for part in parts}
    return pd.concat(tables, names=["robot", None]).reset_index("robot")


def joined_texts(parts: Sequence[str]) -> str:
    """Return a table as CSV from those of each recording; some may have more columns at the end.

    Thousands of tables are joined as text, since parsing takes a hundred times as long.
    """
    split = [part.partition("\n")[::2] for part in parts]
    longest = max((header for header, _ in split), key=len)
    rows = (
        body.replace("\n", "," * (longest.count(",") - header.count(",")) + "\n")
        for header, body in split
    )
    return "".join([longest, "\n", *rows])


def _in_words(value: Any) -> Any:
    return WORDS[bool(value)] if isinstance(value, bool | np.bool_) else value
