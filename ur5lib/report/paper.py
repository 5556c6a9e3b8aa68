"""Parts of a report for a paper: tables, methods and references as LaTeX."""

import os
from pathlib import Path
from typing import Any

import jinja2

from ur5lib.report.document import Document, Picture, Table
from ur5lib.report.render import TEMPLATES
from ur5lib.report.results import Results
from ur5lib.report.tex import file_name, tex, tex_table
from ur5lib.tables import write_text

PURPOSES = {  # of recordings, by role
    "fit": "without contact for the fits",
    "validate": "without contact to validate them",
    "contact": "with contacts",
}
FILTERS = {  # by the name of their settings
    "motion": "torques in the identification of the links",
    "currents": "currents",
    "accelerations": "accelerations of the end effector",
}


class Raw(str):
    """Text that is LaTeX already."""


def write_tables(document: Document, folder: str | Path) -> None:
    """Write each table of a report as a file of its own; the folder is made."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for table in _tables(document):
        write_text(tex_table(table), Path(folder, f"{file_name(table)}.tex"))


def methods(results: Results) -> str:
    """Return a paragraph on the methods of a study, with the settings that it used."""
    settings = results.study["settings"]
    filters = {name: settings["lowpass"][key] for key, name in FILTERS.items()}
    return _filled(
        "methods.tex", results=results, settings=settings, purposes=PURPOSES, filters=filters
    )


def references() -> str:
    """Return the publications that the methods cite, as BibTeX."""
    return (TEMPLATES / "references.bib").read_text(encoding="utf-8")


def paper(document: Document, results: Results) -> str:
    """Return a LaTeX document of methods, figures and tables, which lie beside it.

    Figures lie in `figures` as in the results, as PDF; tables in `tables`.
    """
    pictures = [
        {"path": _column(block, results), "caption": block.caption}
        for block in document.blocks()
        if isinstance(block, Picture)
    ]
    tables = [file_name(table) for table in _tables(document)]
    return _filled("paper.tex", document=document, pictures=pictures, tables=tables)


def _tables(document: Document) -> list[Table]:
    return [block for block in document.blocks() if isinstance(block, Table)]


def _column(picture: Picture, results: Results) -> str:
    """Return the path of a figure of a paper, from its folder."""
    inside = os.path.relpath(picture.path, results.figures)
    return str(Path("figures", inside).with_suffix(".pdf"))


def _as_tex(value: Any) -> str:
    """Return a value of a template as LaTeX."""
    if isinstance(value, Raw):
        return value
    return f"{value:g}" if isinstance(value, float) else tex(str(value))


def _filled(template: str, **values: Any) -> str:
    """Return a template with its values, which become LaTeX unless they are `raw`."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        block_start_string="<%",
        block_end_string="%>",
        variable_start_string="<<",
        variable_end_string=">>",
        comment_start_string="<#",
        comment_end_string="#>",
        trim_blocks=True,
        undefined=jinja2.StrictUndefined,
        finalize=_as_tex,
    )
    return environment.get_template(f"{template}.jinja").render(raw=Raw, **values)
