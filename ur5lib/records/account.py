"""The account of an imported file: the channel assigned to each of its columns, and why."""

from dataclasses import dataclass
from typing import Literal

Evidence = Literal["option", "name", "numbers", "position"]
Confidence = Literal["check", "proven", "assumed", "left out", "evidence"]
NOTHING = "nothing"  # the channel of a column that is left out
UNKNOWN_NAME = "no channel is named so; if it is one, write its name in the entry"


@dataclass(frozen=True)
class AccountRow:
    """A row of account.csv.

    subject: columns of the file, or, for a row on the whole file, robot, rate or role; taken_for:
    the channel and its unit, or what was decided; evidence: the user's option, the name, the
    numbers, or the position in the file; confidence: check (the user should look), proven (by
    numbers that beat an alternative), assumed, left out, or evidence: what one source says, with
    the log-odds of each candidate below its favourite as taken_for; reason: in words.
    """

    subject: str
    taken_for: str
    evidence: Evidence
    confidence: Confidence
    reason: str = ""
