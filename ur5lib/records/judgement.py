"""What is judged of a recording."""

from dataclasses import dataclass, field

from ur5lib.records.force_errors import OffsetAccount
from ur5lib.records.quality import Finding

Value = str | bool | int | float | None
Rows = list[dict[str, Value]]  # of a table, by column


@dataclass(frozen=True)
class Judgement:
    """judgement.json: the recording's rows of the study's tables, by table.

    findings: about its files, clocks and sensor, for the table `quality`; offset: what is not force
    of the sensor's reading, its bias and its tool.
    """

    rows: dict[str, Rows] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    offset: OffsetAccount | None = None
