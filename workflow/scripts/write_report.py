"""The study's report, as HTML and as PDF, and the study that it is of."""

import os
from pathlib import Path
from typing import Any

import yaml

from ur5lib.report.compose import compose
from ur5lib.report.contents import contents
from ur5lib.report.reference import read_reference
from ur5lib.report.render import write_html, write_pdf
from ur5lib.report.results import Results
from ur5lib.report.versions import commit, versions
from ur5lib.tables import read_csv, write_text


def write_report(input: Any, output: Any, params: Any) -> None:
    study = yaml.safe_load(params.study)
    results = Results(
        study=study,
        tables={Path(path).stem: read_csv(path) for path in input.tables},
        figures=Path(os.path.commonpath(input.figures)),
        drawn=frozenset(Path(path).parent.name for path in input.figures),
        errata=read_reference(input.get("reference")).errata,
        commit=commit(),
        versions=versions(),
    )
    document = compose(contents(), results)
    write_html(document, output.html)
    write_pdf(document, output.pdf)
    write_text(params.study, output.study)
