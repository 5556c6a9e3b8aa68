"""The page of one recording as HTML, with the figures that the report has of a few recordings."""

from dataclasses import replace
from pathlib import Path

from ur5lib.report.page.handed import handed_over
from ur5lib.report.page.typeset import html_page
from ur5lib.report.results import Results
from ur5lib.report.summary import verdict_rows
from ur5lib.robots.description import Robot


def write_run(
    recording: str, study: str, tables: list[Path], figures: list[Path], described: Robot
) -> str:
    """Return the page of a recording; study: its configuration as YAML; described: its arm."""
    whole = Results.read(study, tables, figures, [described])
    own = replace(whole.of_run(recording), figures=whole.figures.parent)
    with handed_over(own, {"verdicts": verdict_rows(own)}) as root:
        return html_page(root, "run")
