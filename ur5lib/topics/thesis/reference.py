"""Published values and errata, for comparison with a study's results."""

from pathlib import Path
from typing import Literal, NamedTuple

import yaml
from pydantic import Field, ValidationError, field_validator

from ur5lib.errors import InputError
from ur5lib.robots.description import Vector3
from ur5lib.strict import Strict, explain, read_yaml


class LoopError(Strict):
    """The way in which an erratum says that the thesis computed an error of its closed loop.

    quantity: q [rad], qd [rad/s] or torque [Nm]; figure: the mean or the largest error over time;
    gains: the link model with the published gains that are simulated; velocity_gains: other gains
    [1/s] by joint, 1 to 6; model: the link model that computes the torque; masses [kg],
    centers_of_mass [m]: in place of its own, by link, 1 to 6; from_s: start [s] of the evaluated
    time; places: the signals are compared at these parts, 0 to 1, of each step between samples,
    interpolated linearly.
    """

    quantity: Literal["q", "qd", "torque"]
    figure: Literal["mean", "largest"] = "mean"
    gains: str
    velocity_gains: dict[int, float] = Field(default_factory=dict)
    model: str = ""
    masses: dict[int, float] = Field(default_factory=dict)
    centers_of_mass: dict[int, Vector3] = Field(default_factory=dict)
    from_s: float = 0.0
    places: tuple[float, ...] = (0.0,)


class AccelerationError(Strict):
    """How an error of the end effector's acceleration must have been computed.

    The IMU is filtered in its own axes, from rest and with gravity, and rotated afterwards by
    angles with the delay of the filter at low frequency. model_delay_s: delay of the modelled
    acceleration [s].
    """

    model_delay_s: float


NOT_PUBLISHED_VALUES = "does not hold published values"
OLDER_MODEL = "[21]"  # a link model; the thesis does not print its equations


class Lookup(Strict):
    """Where a study's table has the numbers of a published table.

    table: its name; value: column of the numbers, for all rows or by published row; row: column
    that names the published rows, empty if all share one row; number: column that identifies a
    number within its row (joint, component); where: values that other columns must have, for all
    rows or by published row.
    """

    table: str
    value: str | dict[str, str]
    row: str = ""
    number: str = "joint"
    where: dict[str, str | dict[str, str]] = Field(default_factory=dict)

    def of(self, row: str) -> tuple[str, dict[str, str]]:
        """Return the column with a published row's numbers, and the required values of others."""

        def of_row(value: str | dict[str, str]) -> str:
            return value if isinstance(value, str) else value[row]

        cells = {column: of_row(value) for column, value in self.where.items()}
        return of_row(self.value), cells | ({self.row: row} if self.row else {})


class PrintedTable(Strict):
    """A published table: for each model or estimate, six values by joint or component.

    A single value is the largest of six. sources: by row, if printed elsewhere; quantity: name of
    the values; rebuilt, right: their places in the study's tables, with and without the errata;
    relative, below_one: tolerances, the latter absolute and for values below 1.
    """

    source: str
    sources: dict[str, str] = Field(default_factory=dict)
    quantity: str = ""
    recording: str
    values: dict[str, tuple[float, ...]]
    rebuilt: Lookup
    right: Lookup | None = None
    relative: float = 0.05
    below_one: float = 0.0

    @field_validator("values")
    @classmethod
    def _six_or_one(cls, values: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
        for row, numbers in values.items():
            if len(numbers) not in (1, 6):
                raise ValueError(f"{row} has {len(numbers)} values; give six, or one for all")
        return values


OfLoop = Literal["closed_loop_q", "closed_loop_qd", "closed_loop_q_max", "closed_loop_qd_max"]
OfStudy = Literal["torque_mae", "acceleration_mae", "force_mae", "force_max", "current_torque"]
PrintedTableName = OfLoop | OfStudy
Printed = dict[PrintedTableName, PrintedTable]
"""The published tables that are compared with."""


class Published(NamedTuple):
    """All published tables, and the recording to look up in them."""

    printed: Printed
    recording: str

    def values(self, table: PrintedTableName) -> dict[str, tuple[float, ...]]:
        """Return a table's printed values by row, if the table is of this `recording`; otherwise
        {}.
        """
        printed = self.printed.get(table)
        return printed.values if printed and printed.recording == self.recording else {}


class Explanation(Strict):
    """How an erratum explains numbers: a row of a published table, and how to compute it."""

    printed: PrintedTableName
    row: str
    closed_loop: LoopError | None = None
    acceleration: AccelerationError | None = None


class Erratum(Strict):
    """An error in the published work, its treatment here, and the numbers that it explains."""

    place: str
    error: str
    choice: str
    explains: tuple[Explanation, ...] = ()


class PublishedValues(Strict):
    """Published values of the recordings of a study."""

    printed: Printed = Field(default_factory=dict)
    errata: tuple[Erratum, ...] = ()

    def recordings(self, *names: PrintedTableName) -> set[str]:
        """Return the recordings with published values in the named tables, by default in any."""
        tables = self.printed.items()
        return {table.recording for name, table in tables if not names or name in names}

    def of_older_model(self) -> set[str]:
        """Return the names of the recordings with published values of the older model."""
        tables = self.printed.values()
        return {table.recording for table in tables if OLDER_MODEL in table.values}

    def tables(self) -> list[str]:
        """Return the names of the study's tables with rebuilt and right numbers."""
        lookups = ((table.rebuilt, table.right) for table in self.printed.values())
        return sorted({lookup.table for pair in lookups for lookup in pair if lookup})

    def explained(self) -> set[str]:
        """Return the names of the recordings with published values that an erratum explains."""
        ways = (way for erratum in self.errata for way in erratum.explains)
        return {self.printed[way.printed].recording for way in ways}

    def explained_accelerations(self) -> dict[str, AccelerationError]:
        """Return, by recording, the error by which an erratum explains printed accelerations."""
        ways = (way for erratum in self.errata for way in erratum.explains)
        tables = self.printed
        return {tables[way.printed].recording: way.acceleration for way in ways if way.acceleration}


def read_reference(path: str | Path | None) -> PublishedValues:
    """Read a file of published values; empty without a path.

    Raises InputError when the file is wrong.
    """
    if path is None:
        return PublishedValues()
    try:
        content = read_yaml(Path(path))
        if not isinstance(content, dict):
            raise InputError(f"{path} {NOT_PUBLISHED_VALUES}: it is no mapping; name another file")
        return PublishedValues.model_validate(content)
    except ValidationError as error:
        schema = PublishedValues.model_json_schema()
        mistakes = "; ".join(explain(detail, schema) for detail in error.errors())
        raise InputError(f"{path} {NOT_PUBLISHED_VALUES}: {mistakes}") from error
    except (OSError, yaml.YAMLError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path} {NOT_PUBLISHED_VALUES} ({reason}); name another file") from error
