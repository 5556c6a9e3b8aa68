"""A page of results that a test makes up or reads, and what it holds."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lxml.html import HtmlElement, fromstring

from ur5lib.jobs import files
from ur5lib.report.page.handed import handed_over
from ur5lib.report.page.typeset import html_page, said
from ur5lib.report.results import Results
from ur5lib.report.summary import page_data
from ur5lib.robots.description import Robot


def built(folder: Path) -> Results:
    """The results of a study that was built."""
    arms = [files.read_file(Robot, path) for path in folder.glob("parameters/*/described.yaml")]
    figures = sorted((folder / "figures").rglob("*.svg"))
    tables = sorted((folder / "tables").glob("*.csv"))
    return Results.read((folder / "configuration.yaml").read_text(), tables, figures, arms)


@contextmanager
def sources(results: Results, **data: Any) -> Iterator[Path]:
    """The folder that Typst reads; data: in place of what results say."""
    with handed_over(results, page_data(results) | data) as root:
        yield root


def page_of(results: Results, page: str = "report") -> HtmlElement:
    """A page as HTML."""
    with sources(results) as root:
        return fromstring(html_page(root, page))


def text_of(results: Results, page: str = "report") -> str:
    """The text of a page."""
    return plain(page_of(results, page).text_content())


def plain(text: str) -> str:
    """A text without what keeps lines whole or lets them break."""
    return " ".join(text.replace("\u200b", "").replace("\u00a0", " ").split())


def tables_of(results: Results, page: str = "report") -> dict[str, list[dict[str, str]]]:
    """The tables of a page by name: a dictionary by heading for each row."""
    with sources(results) as root:
        return {
            one["name"]: [
                dict(zip(map(plain, one["header"]), map(cell, row), strict=True))
                for row in one["cells"]
            ]
            for one in said(root, "<table>", page)
        }


def cell(value: Any) -> str:
    """The text of a cell."""
    if isinstance(value, dict):
        return cell(value.get("text") or value.get("body") or value.get("children") or "")
    return plain("".join(map(cell, value)) if isinstance(value, list) else str(value))


def cards_of(results: Results) -> list[dict[str, Any]]:
    """The cards of the first screen, with their states and numbers."""
    with sources(results) as root:
        return said(root, "<card>")


def headline_of(page: HtmlElement) -> str:
    """The first sentence of a page, empty where it has none."""
    return plain(" ".join(one.text_content() for one in page.xpath("//p[@class='headline']")))
