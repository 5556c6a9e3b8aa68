"""Tables and text of a report as LaTeX, which needs `booktabs` and `siunitx` (3)."""

import re
import unicodedata
from collections.abc import Sequence

from ur5lib.report.document import UNDETERMINED, Cell, Table

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
    "A": "A",
    "Hz": "Hz",
    "MB": "MB",
    "N": "N",
    "N s": "N.s",
    "Nm": "N.m",
    "Nm s/rad": "N.m.s/rad",
    "Nm/A": "N.m/A",
    "kg": "kg",
    "kg m²": "kg.m^2",
    "m": "m",
    "m/s²": "m/s^2",
    "ms": "ms",
    "rad": "rad",
    "rad/s": "rad/s",
    "rad/s²": "rad/s^2",
    "s": "s",
}
NUMBER = re.compile(r"([+−]?)(\d[\d,]*)(?:\.(\d+))?(?: ± (\d+)(?:\.(\d+))?)?")
NO_NUMBER = {"", "–", UNDETERMINED}


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
