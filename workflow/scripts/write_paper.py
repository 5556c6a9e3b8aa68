"""What a paper takes over from the study: its report's tables, methods and references as LaTeX."""

from typing import Any

from ur5lib.report.compose import compose
from ur5lib.report.document import contents
from ur5lib.report.paper import methods, paper, references, write_tables
from ur5lib.report.results import Results
from ur5lib.robots.description import load_robot
from ur5lib.tables import write_text


def write_paper(input: Any, output: Any, params: Any) -> None:
    reference = input.get("reference")
    arms = [load_robot(path) for path in input.described]
    results = Results.read(params.study, input.tables, input.figures, reference, arms)
    document = compose(contents(), results)
    write_tables(document, output.tables)
    write_text(methods(results), output.methods)
    write_text(references(), output.references)
    write_text(paper(document, results), output.document)
