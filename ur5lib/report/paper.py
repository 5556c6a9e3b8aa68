"""Parts of a report for a paper as LaTeX, which needs `booktabs` and `siunitx` (3)."""

import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2

from ur5lib import __version__
from ur5lib.report.document import UNDETERMINED, Cell, Document, Picture, Table
from ur5lib.report.render import TEMPLATES
from ur5lib.report.results import Results
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


SIGNS = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": "$<$",
    ">": "$>$",
    "|": r"\textbar{}",
    '"': "''",
    "“": "``",
    "”": "''",
    "‘": "`",
    "’": "'",
    "–": "--",
    "—": "---",
    "…": r"\ldots{}",
    "\u00a0": "~",
    "−": "$-$",
    "±": r"$\pm$",
    "×": r"$\times$",
    "·": r"$\cdot$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "→": r"$\to$",
    "°": r"\textdegree{}",
    "µ": r"\textmu{}",
} | {sign: f"\\{sign}" for sign in "{}$&#%_"}
ACCENTS = {"\u0302": "hat", "\u0303": "tilde", "\u0304": "bar", "\u0307": "dot", "\u0308": "ddot"}
RAISED = {"<super>": r"\textsuperscript", "<sub>": r"\textsubscript"}
LATIN = 0x17F  # the last letter that LaTeX's own encoding of Latin letters knows
UNITS = {  # as siunitx writes them
    unit: unit.replace("Nm", "N m").replace(" ", ".").replace("²", "^2")
    for unit in (
        *("A", "Hz", "MB", "N", "N s", "Nm", "Nm s/rad", "Nm/A", "kg", "kg m²"),
        *("m", "m/s²", "ms", "rad", "rad/s", "rad/s²", "s"),
    )
}
NUMBER = re.compile(r"([+−]?)(\d[\d,]*)(?:\.(\d+))?(?: ± (\d+)(?:\.(\d+))?)?")
NO_NUMBER = {"", "–", UNDETERMINED}


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
    text = (TEMPLATES / "references.bib").read_text(encoding="utf-8")
    return text.replace("VERSION", __version__)


def paper(document: Document, results: Results) -> str:
    """Return a LaTeX document of methods, figures and tables, which lie beside it.

    Figures lie in `figures` as in the results, as PDF; tables in `tables`.
    """
    pictures = [
        {"path": Path("figures", block.path.relative_to(results.figures)).with_suffix(".pdf")}
        | {"caption": block.caption}
        for block in document.blocks()
        if isinstance(block, Picture)
    ]
    tables = [file_name(table) for table in _tables(document)]
    return _filled("paper.tex", document=document, pictures=pictures, tables=tables)


def _tables(document: Document) -> list[Table]:
    return [block for block in document.blocks() if isinstance(block, Table)]


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


def tex(text: str) -> str:
    """Return text as LaTeX: every sign stands for itself, units in brackets are siunitx's.

    A letter that LaTeX does not have becomes its code point: U+4E2D.
    """
    parts = re.split(r"(?<=\[)([^\[\]]+)(?=\])", unicodedata.normalize("NFC", text))
    return "".join(_units(part) if i % 2 else _escaped(part) for i, part in enumerate(parts))


def file_name(table: Table) -> str:
    """Return the name of a table's file, which is its label, too, without the ending."""
    return table.label.replace(".", "-") or f"table-{table.number}"


def tex_table(table: Table) -> str:
    """Return a table as LaTeX: columns of numbers are aligned at the point, the smallest error of
    a row is bold.
    """
    columns = [[row[i] for row in table.rows] for i in range(len(table.header))]
    formats = [_number_format(column) if i else "" for i, column in enumerate(columns)]
    sides = [side[0] for side in table.alignment()]
    kinds = [
        f"S[{number}]" if number else side for number, side in zip(formats, sides, strict=True)
    ]
    header = [
        f"{{{tex(title)}}}" if number else tex(title)
        for title, number in zip(table.header, formats, strict=True)
    ]
    lines = [
        r"\begin{table}",
        r"  \centering",
        f"  \\caption{{{tex(table.caption)}}}",
        f"  \\label{{tab:{file_name(table)}}}",
        f"  \\begin{{tabular}}{{{' '.join(kinds)}}}",
        r"    \toprule",
        f"    {' & '.join(header)} \\\\",
        r"    \midrule",
        *(f"    {' & '.join(map(_cell, row, formats))} \\\\" for row in table.rows),
        r"    \bottomrule",
        r"  \end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _units(text: str) -> str:
    """Return text in brackets as LaTeX: units by siunitx, one by one, or other text."""
    units = text.split(", ")
    if all(unit in UNITS for unit in units):
        return ", ".join(f"\\unit{{{UNITS[unit]}}}" for unit in units)
    return _escaped(text)


def _escaped(text: str) -> str:
    """Return text as LaTeX, sign by sign; accents above letters are those of mathematics."""
    found: list[str] = []
    for sign in text:
        if sign in ACCENTS and found:
            found[-1] = f"$\\{ACCENTS[sign]}{{{found[-1].strip('$')}}}$"
        else:
            found.append(_sign(sign))
    return "".join(found)


def _sign(sign: str) -> str:
    """Return a sign as LaTeX."""
    if sign in SIGNS:
        return SIGNS[sign]
    kind, *parts = unicodedata.decomposition(sign).split() or [""]
    if kind in RAISED:
        return f"{RAISED[kind]}{{{''.join(_sign(chr(int(part, 16))) for part in parts)}}}"
    if " " <= sign <= "~" or (sign.isalpha() and ord(sign) <= LATIN):
        return sign
    name = unicodedata.name(sign, "")
    if greek := re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", name):
        return f"$\\{greek[2].lower() if greek[1] == 'SMALL' else greek[2].capitalize()}$"
    return f"U+{ord(sign):04X}"


def _number_format(column: Sequence[Cell]) -> str:
    """Return siunitx's options of a column of numbers; empty for other columns."""
    texts = [cell.text for cell in column if cell.text not in NO_NUMBER]
    matches = [NUMBER.fullmatch(text) for text in texts]
    parts = [match.groups(default="") for match in matches if match]
    if not parts or len(parts) < len(texts):
        return ""
    sign, whole, part, error, error_part = (
        max(len(digits.replace(",", "")) for digits in place) for place in zip(*parts, strict=True)
    )
    value = f"table-format={'-' * sign}{whole}.{part}"
    plus = ", retain-explicit-plus" if any("+" in text for text in texts) else ""
    return value + (f" +- {error}.{error_part}" if error else "") + plus


def _cell(cell: Cell, number: str) -> str:
    """Return a cell as LaTeX, in braces if it is not a number in a column of numbers."""
    bold = "\\bfseries " if cell.mark == "lowest" else ""
    if not number:
        return bold + tex(cell.text)
    if cell.text in NO_NUMBER:
        return f"{{{tex(cell.text)}}}"
    plain = cell.text.replace(",", "").replace("−", "-").replace("±", "+-")
    return bold + plain
