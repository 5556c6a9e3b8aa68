"""The summary of a study as data: `results.json`, and its schema."""

from dataclasses import dataclass
from itertools import pairwise

from pydantic import Field

from ur5lib.records.verdicts import Verdict
from ur5lib.report.page.document import Cards, Document, Heading, Items
from ur5lib.report.results import Results
from ur5lib.report.views.cards import known, number
from ur5lib.report.views.citing import analysed_on
from ur5lib.strict import Strict

SCHEMA_FILE = "results.schema.json"


@dataclass(frozen=True, kw_only=True)
class StatedVerdict(Verdict):
    """A row of verdicts.csv; before: its number and date in the last build, if it was another."""

    before: str = ""


class ListSummary(Strict):
    """A list under its heading."""

    heading: str
    sentences: list[str]


class Summary(Strict):
    """The first screen of a report as data."""

    schema_file: str = Field(alias="$schema")
    study: str
    title: str
    simulated: list[str] = Field(description="recordings of the virtual test stand")
    commit: str = Field(description="of the code")
    analysed: str = Field(default="", description="date on which the last step ended")
    verdicts: list[StatedVerdict] = Field(description="the rows of tables/verdicts.csv")
    lists: list[ListSummary] = Field(
        description="what to do next, findings, and what may follow them"
    )


def summary(document: Document, results: Results) -> dict[str, object]:
    """Return the first section of a report as plain data that fit `summary_schema`."""
    recordings, blocks = results.study["recordings"], document.sections[0].blocks
    cards = [card for block in blocks if isinstance(block, Cards) for card in block.cards]
    before = {one.key: one.before for card in cards for one in card.numbers}
    plain = {
        "$schema": SCHEMA_FILE,
        "study": results.study["study"],
        "title": results.study["title"],
        "simulated": [entry["name"] for entry in recordings if entry.get("simulate")],
        "commit": results.commit,
        "analysed": analysed_on(results),
        "verdicts": [
            row | {"before": before.get(number(row).key, "")}
            for row in map(known, results.rows("verdicts").to_dict("records"))
        ],
        "lists": [
            {"heading": above.heading, "sentences": block.items}
            for above, block in pairwise(blocks)
            if isinstance(above, Heading) and isinstance(block, Items)
        ],
    }
    return Summary.model_validate(plain).model_dump(by_alias=True)


def summary_schema() -> dict[str, object]:
    """Return the JSON schema of a summary."""
    return Summary.model_json_schema(by_alias=True)
