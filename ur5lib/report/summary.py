"""The summary of a study as data: `results.json`, and its schema."""

import re
from collections.abc import Iterable
from dataclasses import asdict
from itertools import pairwise
from typing import Any

from pydantic import Field

from ur5lib.report.document import Document, Heading, Items, Number, State, Verdict, Verdicts
from ur5lib.report.results import Results
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


class Listed(Strict):
    """A list under its heading."""

    heading: str
    sentences: list[Sentence]


class Summary(Strict):
    """The first screen of a report as data."""

    schema_file: str = Field(alias="$schema")
    study: str
    title: str
    simulated: list[str] = Field(description="recordings of the virtual test stand")
    commit: str = Field(description="of the code")
    verdicts: list[Judged]
    lists: list[Listed] = Field(description="what to do next, findings, and what may follow them")


def summary(document: Document, results: Results) -> dict[str, Any]:
    """Return the first section of a report as plain data that fit `summary_schema`."""
    recordings, blocks = results.study["recordings"], document.sections[0].blocks
    judged = [
        verdict for block in blocks if isinstance(block, Verdicts) for verdict in block.verdicts
    ]
    names = [*results.roles(), *map(results.file_of, results.roles())]
    return Summary.model_validate(
        {
            "$schema": SCHEMA,
            "study": results.study["study"],
            "title": results.study["title"],
            "simulated": [one["name"] for one in recordings if one.get("simulate")],
            "commit": results.commit,
            "verdicts": [_judged(verdict, names) for verdict in judged],
            "lists": [
                _listed(above, block, names)
                for above, block in pairwise(blocks)
                if isinstance(above, Heading) and isinstance(block, Items)
            ],
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


def _listed(heading: Heading, items: Items, names: Iterable[str]) -> Listed:
    sentences = [_sentence(text, names) for text in items.items]
    return Listed(heading=heading.text, sentences=sentences)


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
