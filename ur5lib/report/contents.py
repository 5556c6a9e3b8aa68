"""The contents of the report as data: `contents.yaml`.

A block is text, sentences or a list that a view makes of the results, a table that a view makes,
a figure that a rule drew, an equation, or a part that is repeated for each recording or arm that
a view names. Views are named `module.function`. In texts, captions and alternative texts,
{of} is the recording or arm of a repeated part; in texts, @name is a mention of the table or
figure of this name.
"""

from functools import cache
from pathlib import Path

from ur5lib.strict import Strict, read_yaml

MOST_SHOWN = 4  # recordings with tables and figures of their own in one section


class Text(Strict):
    """A paragraph; `beside`: shown only where the table or figure of this name is.

    Sentences that mention what is not shown are left out.
    """

    text: str
    beside: str = ""


class Sentences(Strict):
    """Paragraphs written by a view."""

    sentences: str


class List(Strict):
    """A list that a view writes."""

    items: str
    numbered: bool = False


class Tabular(Strict):
    """A table that a view makes; left out where it has no rows."""

    table: str
    caption: str
    source: str = ""


class Figure(Strict):
    """A figure of a rule: figures/<of>/<figure>.svg; omitted if it is empty."""

    figure: str
    rule: str
    caption: str
    alternative: str


class Formula(Strict):
    """An equation in typst's notation, and in words."""

    equation: str
    alternative: str


class Glance(Strict):
    """Verdicts that a view makes."""

    verdicts: str


class Title(Strict):
    """Opens a part of a section."""

    heading: str


class Listing(Strict):
    """Text shown as typed, that a view writes."""

    listing: str


Single = Text | Sentences | List | Tabular | Figure | Formula | Listing | Glance | Title


class Repeated(Strict):
    """Blocks for each recording or arm that a view names."""

    each: str
    heading: str = ""
    blocks: list[Single]


class Part(Strict):
    """A section; `absent`: the reason that is given if the study has no data for it."""

    title: str
    absent: str = ""
    blocks: list[Single | Repeated]


class Contents(Strict):
    """The whole report."""

    sections: list[Part]


@cache
def contents() -> Contents:
    """Return the report's contents from `contents.yaml`."""
    return Contents.model_validate(read_yaml(Path(__file__).with_name("contents.yaml")))
