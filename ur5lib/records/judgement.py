"""What is judged of a recording by itself, without a sensor and its contacts."""

from dataclasses import dataclass, field

from ur5lib.records.quality import Finding

Value = str | bool | int | float | None
Rows = list[dict[str, Value]]  # of a table, by column


@dataclass(frozen=True)
class Judgement:
    """judgement.json: the recording's rows of the study's tables, by table.

    findings: about its files and clocks, for the table `quality`.
    """

    rows: dict[str, Rows] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
