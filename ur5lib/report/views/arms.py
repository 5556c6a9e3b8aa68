"""Verdicts on several arms: each arm is judged by itself, so that none hides another in a mean."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import pandas as pd

from ur5lib.report.page.document import Number, State, Verdict
from ur5lib.report.results import Results

Judge = Callable[[Results], Verdict | None]
STATES_BY_SEVERITY: list[State] = ["do not use", "usable", "good", "not determined"]


def by_arm(judge: Judge) -> Judge:
    """Return a judge of all arms of a study, each by its own results."""

    def judged(results: Results) -> Verdict | None:
        arms = results.robots()
        if len(arms) < 2:
            return judge(results)
        by_name = {arm: verdict for arm in arms if (verdict := judge(results.of_arm(arm)))}
        return together(by_name) if by_name else None

    return judged


def together(verdicts: Mapping[str, Verdict]) -> Verdict:
    """Return the verdict on all arms: the severest, with the sentences of each, the severest first;
    good only if all are.
    """
    arms = sorted(verdicts, key=lambda arm: STATES_BY_SEVERITY.index(verdicts[arm].state))
    severest = verdicts[arms[0]]
    arms_by_sentence: dict[str, list[str]] = {}
    for arm in arms:
        arms_by_sentence.setdefault(verdicts[arm].sentence, []).append(arm)
    mixed = severest.state == "good" and verdicts[arms[-1]].state != "good"
    return replace(
        severest,
        state="usable" if mixed else severest.state,
        sentence=" ".join(
            f"{', '.join(of)}: {sentence}" for sentence, of in arms_by_sentence.items()
        ),
        answers=tuple(f"{arm}: {text}" for arm in arms for text in verdicts[arm].answers),
        evidence=" ".join(f"{arm}: {text}" for arm in arms if (text := verdicts[arm].evidence)),
        numbers=tuple(_of(arm, number) for arm in arms for number in verdicts[arm].numbers),
    )


def of_each_arm(results: Results, table: Callable[[Results], pd.DataFrame]) -> pd.DataFrame:
    """Return a table of each arm, by its own results, one below the other, with `robot`."""
    own = {arm: table(results.of_arm(arm)).reset_index() for arm in results.robots()}
    return pd.concat([rows.assign(robot=arm) for arm, rows in own.items()])


def _of(arm: str, number: Number) -> Number:
    """Return a number of an arm with the arm's name in its place."""
    return replace(number, place=f"{arm}, {number.place}" if number.place else arm)
