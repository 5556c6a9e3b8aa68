"""The verdicts on a study, as commands print them: the state of each card, and the reason."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.errors import printable
from ur5lib.finished import StudyFiles
from ur5lib.records.phrases import number
from ur5lib.records.verdicts import State, reason_in_words, state_in_words


@dataclass(frozen=True)
class CardState:
    """The state of a card of the report: how well one question is answered.

    question: as in verdicts.csv; arm: "" for all arms; reason: the code of why the state is not
    better; why: the same in words; number: with its label and unit, "" without one.
    """

    question: str
    arm: str
    state: State
    reason: str
    why: str
    number: str = ""

    def line(self, with_arm: bool = False) -> str:
        """Return the state as a line."""
        of = f" of {self.arm}" if with_arm and self.arm else ""
        parts = [state_in_words(self.state, self.question), self.number, self.why]
        return printable(f"{self.question}{of}: {'. '.join(filter(None, parts))}")


def card_states(results: Path) -> list[CardState] | None:
    """Return the states of the cards, from verdicts of rank 1; None if nothing was judged."""
    if not (results / "tables" / "verdicts.csv").is_file():
        return None
    study = StudyFiles(results)
    rows = study.verdicts
    rows = rows[(rows["rank"] == 1) & rows["state"].notna()]
    named = rows.astype({"arm": object, "reason": object}).fillna({"arm": "", "reason": ""})
    return [_card_state(study, row) for row in named.itertuples()]


def lines(states: list[CardState] | None, study: str) -> Iterator[str]:
    """Yield a line for each state of `card_states`, or one line that there are none.

    study: the address of its file. If a question has states for arms, its state for all arms is
    left out.
    """
    if states is None:
        yield f"no verdicts, as results of an earlier version; next: ur5 run {study}"
        return
    several = {one.question for one in states if one.arm}
    with_arm = len({one.arm for one in states if one.arm}) > 1
    yield from (one.line(with_arm) for one in states if one.arm or one.question not in several)


def measured(study: StudyFiles, arm: str) -> Effort:
    """Return the effort that an arm measures; arm "": torque if all of the study's arms do."""
    arms = [arm] if arm else [path.name for path in (study.folder / "parameters").glob("*")]
    known = [one for one in arms if (study.folder / "parameters" / one / "arm.yaml").is_file()]
    return TORQUE if {study.arm(one).measured for one in known} == {TORQUE} else CURRENT


def _card_state(study: StudyFiles, row: Any) -> CardState:
    why = reason_in_words(row.reason, measured(study, row.arm)) if row.reason else ""
    return CardState(row.question, row.arm, row.state, row.reason, why, in_words(row))


def in_words(row: Any) -> str:
    """Return the number of a verdict with its label and unit, "" without one."""
    if pd.notna(row.count):
        whole = "" if pd.isna(row.of) else f" of {row.of:.0f}"
        return f"{row.count:.0f}{whole} {row.quantity}"
    if pd.isna(row.value):
        return ""
    unit = f" {row.unit}" if isinstance(row.unit, str) else ""
    return f"{row.quantity}: {number(row.value, '.3g')}{unit}"
