"""What is judged of a recording by itself, without a sensor and its contacts."""

from dataclasses import dataclass, field

from ur5lib.records.account import AccountRow
from ur5lib.records.clocks import ClockRow
from ur5lib.records.dynamics import TorqueError
from ur5lib.records.prediction import CurrentError, LoadRow
from ur5lib.records.quality import FileRead, Finding, RecordingSummary


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """judgement.json: findings about a recording, for the table `quality`, and its rows of the
    tables that the other fields name.
    """

    findings: list[Finding] = field(default_factory=list)
    recordings: list[RecordingSummary] = field(default_factory=list)
    files: list[FileRead] = field(default_factory=list)
    account: list[AccountRow] = field(default_factory=list)
    clocks: list[ClockRow] = field(default_factory=list)
    torque_mae: list[TorqueError] = field(default_factory=list)
    current_rmse: list[CurrentError] = field(default_factory=list)
    payload: list[LoadRow] = field(default_factory=list)
