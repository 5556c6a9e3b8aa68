"""The page of the published numbers and the rebuilt ones, as HTML."""

from collections.abc import Mapping
from pathlib import Path

from ur5lib.report.page.handed import handed_over
from ur5lib.report.page.typeset import html_page
from ur5lib.report.results import Results
from ur5lib.report.summary import verdict_rows
from ur5lib.robots.description import Robot


def write_published(
    study: str, tables: list[Path], figures: list[Path], described: Mapping[str, Robot]
) -> str:
    """Return the page; study: its configuration as YAML; figures: of the study, and of
    recordings in a folder each; described: its arms.
    """
    results = Results.read(study, tables, figures, [*described.values()])
    with handed_over(results, {"verdicts": verdict_rows(results)}) as root:
        return html_page(root, "published")
