"""What the section of a topic shows on a page, of results that a test makes up."""

import re
from dataclasses import dataclass, replace
from functools import cached_property

from lxml.html import HtmlElement

from tests.made_study import study
from tests.typeset_page import page_of, plain
from ur5lib.report.results import Results
from ur5lib.workspace.places import PACKAGE

OF_TOPICS = ("next_recordings", "changes")  # which a made-up study has, too
ID = re.compile(r"^#let id = .*", re.MULTILINE)


@dataclass(frozen=True)
class Shown:
    """A section of a page."""

    section: HtmlElement

    @cached_property
    def text(self) -> str:
        return plain(self.section.text_content())

    @cached_property
    def tables(self) -> dict[str, list[dict[str, str]]]:
        """The rows of each table by its name, a dictionary by heading each."""
        found = self.section.xpath(".//div[@class='scroll']")
        return {str(table.get("id")): rows_of(table) for table in found}

    @cached_property
    def figures(self) -> list[str]:
        return [str(figure.get("id")) for figure in self.section.iter("figure")]

    @property
    def drawn(self) -> str:
        """What the pictures say to those who do not see them."""
        found = self.section.xpath(".//@alt | .//svg/@aria-label")
        return plain("; ".join(found))


def rows_of(table: HtmlElement) -> list[dict[str, str]]:
    heads, *rows = ([plain(cell.text_content()) for cell in row] for row in table.iter("tr"))
    return [dict(zip(heads, row, strict=True)) for row in rows]


def filled(results: Results) -> Results:
    """Results; what they lack is that of a made-up study, but for what topics make."""
    made = study()
    tables = {name: own for name, own in made.tables.items() if name not in OF_TOPICS}
    own = made.study | {key: value for key, value in results.study.items() if value}
    return replace(results, study=own, tables=tables | {**results.tables})


def shown(topic: str, results: Results, page: str = "report") -> Shown | None:
    """The section of a topic on a page of a study with these results, none where it is not."""
    (line,) = ID.findall((PACKAGE / "topics" / topic / "section.typ").read_text())
    ids = {*re.findall(r'"([\w-]+)"', line)}
    sections = page_of(filled(results), page).iter("section")
    found = [own for own in sections if own.get("id") in ids]
    return Shown(*found) if found else None


def section(topic: str, results: Results, page: str = "report") -> Shown:
    """The section of a topic, which there must be."""
    found = shown(topic, results, page)
    assert found is not None
    return found
