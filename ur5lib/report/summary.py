"""The summary of a study as data: `results.json`, and its schema."""

import re
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from pydantic import Field

from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.results import Results
from ur5lib.report.views.found import findings
from ur5lib.report.views.glance import verdicts
from ur5lib.report.views.next_steps import steps
from ur5lib.strict import Strict

SCHEMA = "results.schema.json"
STATED = re.compile(
    r"(?<![\w.,])(?P<value>−?\d+(?:,\d{3})*(?:\.\d+)?)(?: ± (?P<error>\d+(?:\.\d+)?))?"
    r"(?: (?P<unit>Nm/A|Nm|kg|ms|Hz|m/s²|rad/s²|%|[NAsm]))?(?![\w])"
)


class Stated(Strict):
    """A number as a sentence states it: rounded, with its standard error if it gives one."""

    value: float
    std_error: float | None = None
    unit: str = ""


class Sentence(Strict):
    """A sentence, and its numbers in their order."""

    text: str
    numbers: list[Stated]


class Quantity(Strict):
    """A number behind a verdict, not rounded.

    place: the recording, joint or component that it is of; low, high: ends of the interval that
    `interval` names; baseline: the same number of what `baseline_of` names.
    """

    name: str
    value: float
    unit: str
    place: str
    low: float | None
    high: float | None
    interval: str
    baseline: float | None
    baseline_of: str


class Judged(Strict):
    """A verdict: one topic and whether its result can be used; docs/report.md has the rules."""

    topic: str
    state: State
    sentence: Sentence
    evidence: Sentence
    numbers: list[Quantity]


class Summary(Strict):
    """The first screen of a report as data."""

    schema_file: str = Field(alias="$schema")
    study: str
    title: str
    simulated: list[str] = Field(description="recordings of the virtual test stand")
    commit: str = Field(description="of the code")
    verdicts: list[Judged]
    next_steps: list[Sentence]
    findings: list[Sentence]


def summary(results: Results) -> dict[str, Any]:
    """Return the summary of a study as plain data that fit `summary_schema`."""
    recordings = results.study["recordings"]
    names = [*results.roles(), *map(results.file_of, results.roles())]
    return Summary.model_validate(
        {
            "$schema": SCHEMA,
            "study": results.study["study"],
            "title": results.study["title"],
            "simulated": [one["name"] for one in recordings if one.get("simulate")],
            "commit": results.commit,
            "verdicts": [_judged(verdict, names) for verdict in verdicts(results)],
            "next_steps": [_sentence(text, names) for text in steps(results)],
            "findings": [_sentence(text, names) for text in findings(results)],
        }
    ).model_dump(by_alias=True)


def summary_schema() -> dict[str, Any]:
    """Return the JSON schema of a summary."""
    return Summary.model_json_schema(by_alias=True)


def _judged(verdict: Verdict, names: Iterable[str]) -> Judged:
    return Judged(
        topic=verdict.topic,
        state=verdict.state,
        sentence=_sentence(verdict.sentence, names),
        evidence=_sentence(verdict.evidence, names),
        numbers=[_quantity(number) for number in verdict.numbers],
    )


def _quantity(number: Number) -> Quantity:
    return Quantity(**asdict(number))


def _sentence(text: str, names: Iterable[str]) -> Sentence:
    """Return a sentence with its numbers; digits of names of recordings and files are none."""
    bare = text
    for name in sorted(names, key=len, reverse=True):
        bare = bare.replace(name, "")
    return Sentence(text=text, numbers=[_stated(match) for match in STATED.finditer(bare)])


def _stated(match: re.Match[str]) -> Stated:
    def plain(digits: str) -> float:
        return float(digits.replace(",", "").replace("−", "-"))

    error = match["error"]
    return Stated(
        value=plain(match["value"]),
        std_error=plain(error) if error else None,
        unit=match["unit"] or "",
    )
