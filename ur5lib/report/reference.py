"""Published values and errata, for comparison with a study's results."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from ur5lib.errors import InputError
from ur5lib.strict import Strict, read_yaml

OLDER_MODEL = "[21]"  # a link model whose equations the thesis does not print


class PrintedTable(Strict):
    """A published table: by model or estimate, six values, joints or components in order."""

    source: str
    recording: str
    values: dict[str, tuple[float, float, float, float, float, float]]


class Printed(Strict):
    """The published tables that are compared with."""

    closed_loop_q: PrintedTable | None = None
    closed_loop_qd: PrintedTable | None = None
    torque_mae: PrintedTable | None = None
    acceleration_mae: PrintedTable | None = None
    force_mae: PrintedTable | None = None
    force_max: PrintedTable | None = None
    current_torque: PrintedTable | None = None


class Erratum(Strict):
    """An error in the published work, and its treatment here."""

    place: str
    error: str
    choice: str


class Reference(Strict):
    """Published values of the recordings of a study."""

    printed: Printed = Printed()
    errata: tuple[Erratum, ...] = ()

    def recordings(self, *names: str) -> set[str]:
        """Return the recordings with published values, in some tables or, without names, in any."""
        return {table.recording for table in self._tables(*names)}

    def of_older_model(self) -> set[str]:
        """Return the names of the recordings with published values of the older model."""
        return {table.recording for table in self._tables() if OLDER_MODEL in table.values}

    def _tables(self, *names: str) -> list[PrintedTable]:
        tables = (getattr(self.printed, name) for name in names or type(self.printed).model_fields)
        return [table for table in tables if table is not None]


def read_reference(path: str | Path | None) -> Reference:
    """Read a file of published values; empty without a path.

    Raises InputError when the file is wrong.
    """
    if path is None:
        return Reference()
    try:
        return Reference.model_validate(read_yaml(Path(path)))
    except (ValidationError, yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path} does not hold valid published values: {error}") from error


def published(printed: PrintedTable | None, recording: str) -> dict[str, Any]:
    """Return a table's printed values of a recording; empty for any other recording."""
    if printed is None or printed.recording != recording:
        return {}
    return dict(printed.values)
