"""The study's report, as HTML, as PDF and its summary as JSON, its details, study and tables."""

import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from ur5lib.report.page.handed import handed_over
from ur5lib.report.page.typeset import pdf_document, report_and_details
from ur5lib.report.results import Results
from ur5lib.report.summary import last_summary, page_data, summary, summary_schema
from ur5lib.robots.description import Robot


class Report(NamedTuple):
    """The report of a study and what accompanies it.

    html, pdf: the report; details: its supplement; study: configuration as YAML; results, schema:
    summary and its schema; archive: all tables.
    """

    html: str
    details: str
    pdf: bytes
    study: str
    results: dict[str, Any]
    schema: dict[str, Any]
    archive: bytes


def write_report(
    study: str,
    tables: list[Path],
    figures: list[Path],
    described: Mapping[str, Robot],
    last: Path,
) -> Report:
    """Return the report of a study.

    study: its configuration as YAML; described: its arms; last: the summary of the last build, if
    there was one.
    """
    results = Results.read(study, tables, figures, [*described.values()])
    data = page_data(results, last_summary(last))
    with handed_over(results, data) as root:
        pages = *report_and_details(root), pdf_document(root)
    return Report(*pages, study, summary(results, data), summary_schema(), archived(tables))


def archived(files: list[Path]) -> bytes:
    """Return files as one zip archive, which has the same bytes as long as the files have."""
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files:
            entry = zipfile.ZipInfo(f"tables/{file.name}")  # of 1980
            archive.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED)
    return content.getvalue()
