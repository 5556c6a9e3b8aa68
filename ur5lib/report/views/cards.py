"""Cards of the first screen: rows of verdicts.csv, and a sentence for each reason."""

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import pandas as pd

from ur5lib.records.verdicts import REASONS
from ur5lib.report.page.document import Card, Number
from ur5lib.report.page.formats import counted, measured, within
from ur5lib.report.page.sentences import names, spoken
from ur5lib.report.results import Results
from ur5lib.report.views import recordings

QUESTIONS = {  # by card
    "force": ["force", "contacts", "pushes", "alarms", "bands"],
    "recordings": ["recordings"],
    "constants": ["constants", "gravity"],
    "currents": ["currents", "friction"],
    "links": ["links", "load"],
    "motion": ["motion"],
}
KEY = ("question", "arm", "quantity", "unit", "interval", "joint", "axis", "motion", "recording")
WHOLE = {"rank", "joint", "count", "of"}  # numbers without decimals
SHOWN_OF_TITLE, SHOWN = 2, 1  # numbers of a question that are not folded


def cards(results: Results) -> list[Card]:
    """Return the cards of questions that have a state, those of topics last."""
    rows = results.rows("verdicts")
    judged = [*rows.dropna(subset="state")["question"].unique()]
    own = {*chain(*QUESTIONS.values())}
    every = QUESTIONS | {one: [one] for one in judged if one not in own}
    accepted = tuple(recordings.accepted(results))
    return [card(one, rows, every[one], accepted) for one in every if one in judged]


def card(
    title: str, rows: pd.DataFrame, questions: list[str], accepted: tuple[str, ...] = ()
) -> Card:
    """Return a card of a question (`title`) and further ones about the same: what decides each,
    and the next number of the first, are shown, others folded.
    """
    parts = [rows[rows["question"] == question] for question in questions]
    first = deciding(parts[0])
    each = [
        [number for number in of_arm if number.text] for part in parts for of_arm in _of_arms(part)
    ]
    ends = [SHOWN_OF_TITLE, *[SHOWN] * len(each)]
    return Card(
        topic=spoken(names("question").get(title, title)),
        state=first["state"],
        sentence=_sentence(first, _where(known(first.to_dict()))),
        numbers=tuple(chain(*(own[:end] for own, end in zip(each, ends, strict=False)))),
        further=tuple(chain(*(own[end:] for own, end in zip(each, ends, strict=False)))),
        accepted=accepted,
    )


def deciding(rows: pd.DataFrame) -> "pd.Series[Any]":
    """Return the row that decides a question: of the whole study, if there is one."""
    first = rows[rows["rank"] == rows["rank"].min()]
    of_study = first[first["arm"].isna()]
    return (of_study if len(of_study) else first).iloc[0]


def _of_arms(rows: pd.DataFrame) -> Iterator[list[Number]]:
    """Yield the numbers of each arm, or of the study where none is of an arm."""
    own = rows.dropna(subset="arm")
    groups = [*(own if len(own) else rows).groupby("arm", sort=False, dropna=False)]
    for _, part in groups:
        of_arm = [*map(known, part.sort_values("rank").to_dict("records"))]
        if groups[1:]:
            yield [number(row, names_arm=True) for row in of_arm]
        else:
            yield [number(_without_sentence(row)) for row in of_arm]


def _without_sentence(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row without the reason that the card's sentence gives."""
    return {key: value for key, value in row.items() if key != "reason" or "state" not in row}


def known(row: dict[Any, Any]) -> dict[str, Any]:
    """Return the cells of a row of verdicts.csv that are not empty."""
    own = {str(name): value for name, value in row.items() if pd.notna(value)}
    return own | {name: int(own[name]) for name in WHOLE & own.keys()}


def _sentence(row: Mapping[str, Any], where: str = "") -> str:
    """Return the sentence of a row's reason, empty without any; where: what it begins with."""
    told = spoken(REASONS.get(row["reason"], ""))
    return f"{where}: {told[0].lower()}{told[1:]}" if where and told else told


def _where(row: dict[str, Any]) -> str:
    """Return the joint or axis of a row, as a sentence begins with it."""
    if "joint" in row:
        return f"Joint {row['joint']}"
    return f"Along {row['axis']}" if "axis" in row else ""


def number(row: dict[str, Any], names_arm: bool = False) -> Number:
    """Return a row of verdicts.csv as a number of a card; row: without its empty cells."""
    about = [str(row["arm"])] if names_arm else []
    place = ", ".join([*about, *_about(row)])
    why = _sentence(row) if "reason" in row else ""
    key = tuple(str(row.get(part, "")) for part in KEY)
    told = ". ".join(filter(None, (place, why)))
    return Number(row.get("quantity", ""), text_of(row), told, key, row.get("before", ""))


def text_of(row: dict[str, Any]) -> str:
    """Return the number of a row: how many of how many, or a value with its interval."""
    count = f"{counted(row['count'])}{_of(row)}" if "count" in row else ""
    if "value" not in row:
        return count
    value = within(row["value"], row.get("low"), row.get("high"), row.get("unit", ""))
    return f"{value} ({count})" if count else value


def _of(row: dict[str, Any]) -> str:
    return f" of {counted(row['of'])}" if "of" in row else ""


def _about(row: dict[str, Any]) -> Iterator[str]:
    """Yield interval, place and rivals of a number."""
    unit = row.get("unit", "")
    if {"low", "high"} <= row.keys():
        ends = " to ".join(within(row[end], row["low"], row["high"]) for end in ("low", "high"))
        yield f"{row.get('interval', '')}: {ends}".lstrip(": ")
    if {"joint", "value"} <= row.keys():
        yield f"joint {row['joint']}"
    if "axis" in row:
        yield row["axis"] if " " in row["axis"] else f"along {row['axis']}"
    yield from (str(row[key]) for key in ("motion", "recording") if key in row)
    meant = {
        "zero": spoken(names("zero").get(row["question"], "zero")),
        "rival_value": row.get("rival"),
    }
    for key, word in (meant | {"floor": "repeatability"}).items():
        if key in row:
            yield f"{word}: {measured(row[key], unit)}"
    if row.get("basis") in ("trial", "fit"):
        yield names("basis")[row["basis"]]
