"""The page of one recording: what the report shows of a few, as HTML."""

from dataclasses import replace
from typing import Any

from ur5lib.report.page.compose import compose
from ur5lib.report.page.document import contents
from ur5lib.report.page.render import write_html
from ur5lib.report.results import Results
from ur5lib.robots.description import load_robot


def write_run(input: Any, output: Any, params: Any) -> None:
    arms = [load_robot(input.described)]
    whole = Results.read(params.study, input.tables, input.figures, None, arms)
    own = replace(whole.of_run(params.recording), figures=whole.figures.parent)
    write_html(replace(compose(contents().of_run(), own), home="../"), output.html)
