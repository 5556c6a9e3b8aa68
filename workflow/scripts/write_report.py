"""The study's report, as HTML, as PDF and its summary as JSON, and the study that it is of."""

from typing import Any

from ur5lib.report.page.compose import compose
from ur5lib.report.page.document import contents
from ur5lib.report.page.render import write_html, write_pdf
from ur5lib.report.page.summary import summary, summary_schema
from ur5lib.report.results import Results
from ur5lib.robots.description import load_robot
from ur5lib.tables import write_json, write_text


def write_report(input: Any, output: Any, params: Any) -> None:
    reference = input.get("reference")
    arms = [load_robot(path) for path in input.described]
    results = Results.read(params.study, input.tables, input.figures, reference, arms)
    document = compose(contents(), results)
    write_html(document, output.html)
    write_pdf(document, output.pdf)
    write_text(params.study, output.study)
    write_json(summary(document, results), output.results)
    write_json(summary_schema(), output.schema)
