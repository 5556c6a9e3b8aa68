"""The contents of the report as data: `contents.yaml`, its blocks not yet filled from results."""

from functools import cache
from pathlib import Path

from ur5lib.report.document import Block, DeclaredTable
from ur5lib.strict import Strict, read_yaml

MOST_SHOWN = 4  # recordings with tables and figures of their own in one section
MOST_ROWS = 60  # shown of a table; its CSV file has all


class Repeated(Strict):
    """Blocks repeated for each recording or arm; each: the view that lists them."""

    each: str
    heading: str = ""
    blocks: list[Block | DeclaredTable]


class Part(Strict):
    """A section; absent: the reason that the report states if the study has no data for it."""

    title: str
    absent: str = ""
    blocks: list[Block | DeclaredTable | Repeated]


class Contents(Strict):
    """The whole report."""

    sections: list[Part]


@cache
def contents() -> Contents:
    """Return the report's contents from `contents.yaml`."""
    return Contents.model_validate(read_yaml(Path(__file__).with_name("contents.yaml")))
