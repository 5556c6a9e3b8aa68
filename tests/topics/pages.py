"""What a topic shows in the report, of results that a test makes up."""

from dataclasses import replace

import pandas as pd

from ur5lib.report.page.compose import compose
from ur5lib.report.page.document import (
    Contents,
    DeclaredSection,
    Paragraph,
    Section,
    topic_pages,
)
from ur5lib.report.results import Results

STUDY = {"study": "s", "title": "t"}
FIRST = DeclaredSection(title="First", blocks=[])


def sections(topic: str, results: Results) -> list[Section]:
    """The sections of a topic in report and details, as far as results fill them."""
    page = topic_pages()[topic]
    own = Contents(topics=[page], run=[])
    recordings = pd.DataFrame({"recording": ["one"], "duration_s": [60.0]})
    entries = results.study.get("recordings") or [{"name": "one", "robot": "ur5", "role": "fit"}]
    whole = replace(
        results,
        study=STUDY | {"recordings": entries} | {**results.study, "recordings": entries},
        tables={"recordings": recordings} | {**results.tables},
    )
    parts = [*own.report(), *own.details()]
    return [found for part in parts for found in compose([FIRST, part], whole).sections]


def shown(topic: str, results: Results) -> list[str]:
    """The kinds of blocks of a topic's sections, but texts."""
    blocks = [block for section in sections(topic, results) for block in section.blocks]
    return [type(block).__name__ for block in blocks if not isinstance(block, Paragraph)]
