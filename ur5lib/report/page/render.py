"""A document as one HTML file and as PDF, from the same data.

The HTML file holds the lines of figures over time, too, packed into few bytes for the script of
*Look closer*.
"""

import json
import re
import shutil
import tempfile
import zlib
from base64 import b64encode
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2
import numpy as np
import pandas as pd
import typst
from markupsafe import Markup

from ur5lib.report.figures.house_style import LINE_STYLES
from ur5lib.report.figures.traces import BAND_EDGES, column_name
from ur5lib.report.page.document import Document
from ur5lib.tables import read_csv
from ur5lib.timeseries.arrays import Array

TEMPLATE_FOLDER = Path(__file__).parent / "templates"
EQUATION_PAGES = "#set page(width: auto, height: auto, margin: 1pt, fill: none)\n"
UNESCAPED_CHARACTERS = " '!$()*+,-./:;=?@[]_~"  # characters that a data URI need not escape
LINE_LEVELS = 511  # to which a line's values are rounded: two for each dot of a panel on the screen
LINE_COLUMN = re.compile(r"(.*), (.*) \[(.*)\]")


def html_page(document: Document) -> str:
    """Return a self-contained page, with styles, figures and a script that zooms into them."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"data_uri": _data_uri, "packed_lines": packed_lines}
    data = document.as_data()
    equations = _blocks(data, "equation")
    for block, drawn in zip(equations, _drawn([e["equation"] for e in equations]), strict=True):
        block["drawn"] = drawn
    return environment.get_template("report.html.jinja").render(document=data)


def pdf_document(document: Document) -> bytes:
    """Return the same document as PDF; typst reads only a temporary folder."""
    data = document.as_data()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copy(TEMPLATE_FOLDER / "report.typ", root)
        verdicts = [verdict for block in _blocks(data, "verdicts") for verdict in block["verdicts"]]
        for i, verdict in enumerate(verdicts):
            verdict["path"] = f"verdict_{i}.svg" if verdict["drawing"] else ""
            if verdict["path"]:
                (root / verdict["path"]).write_text(verdict["drawing"], encoding="utf-8")
        for block in _blocks(data, "picture"):
            picture = f"figure_{block['number']}.svg"
            shutil.copy(block["path"], root / picture)
            block["path"] = picture
        (root / "report.json").write_text(json.dumps(data), encoding="utf-8")
        compiled: bytes = typst.compile(root / "report.typ", root=root, timestamp=0)
        return compiled


def _blocks(data: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [b for section in data["sections"] for b in section["blocks"] if b["kind"] == kind]


def _drawn(equations: list[str]) -> list[Markup]:
    """Render equations as SVG with unique names, in the colour of the surrounding text."""
    if not equations:
        return []
    pages = "\n#pagebreak()\n".join(f"$ {equation} $" for equation in equations)
    drawn = typst.compile((EQUATION_PAGES + pages).encode(), format="svg")
    images = [drawn] if isinstance(drawn, bytes) else drawn
    coloured = []
    for i, image in enumerate(images):
        svg = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>equation{i}-", image.decode())
        for part in ("fill", "stroke"):
            svg = svg.replace(f'{part}="#000000"', f'{part}="currentColor"')
        coloured.append(Markup(svg))
    return coloured


def _data_uri(path: str) -> str:
    """Return a figure as a data URI, as text: base64 would be a third larger, and line breaks cost
    three characters each.
    """
    text = " ".join(Path(path).read_text(encoding="utf-8").split())
    return "data:image/svg+xml," + quote(text, safe=UNESCAPED_CHARACTERS)


def packed_lines(path: str | Path) -> str:
    """Return the lines of a figure over time [s] as Base64 text; empty for other figures.

    path: an SVG that `save` wrote, with its numbers as CSV beside it.

    The decoded and decompressed (zlib) text is one line of JSON, followed by the values. The JSON
    holds panels, lines, the range (smallest and largest value) of each column, and the steps of
    time in ms, null in gaps. Each value is a level from 1 to LINE_LEVELS within the range of its
    column, or 0 if it is missing. Stored are the steps from each level to the next, column by
    column, as two-byte numbers: 2 n for n levels up, 2 n − 1 for n down; all low bytes come before
    all high ones.
    """
    figure = Path(path)
    styles = re.findall(r"<rdf:li>(\w+)</rdf:li>", figure.read_text(encoding="utf-8"))
    if not styles:
        return ""
    data = read_csv(figure.with_suffix(".csv"))
    panels, labels = _panels_and_labels(data.columns[1:], len(styles))
    edges = [edge for edge in BAND_EDGES if column_name(edge, *panels[0]) in data]
    columns = [column_name(line, *panel) for line in [*labels, *edges] for panel in panels]
    values = data[columns].to_numpy(float).T
    head = {
        "panels": panels,
        "lines": [
            {
                "label": label,
                "colours": LINE_STYLES[style].colours[: len(panels)],
                "dashes": LINE_STYLES[style].dashes,
            }
            for label, style in zip(labels, styles, strict=True)
        ],
        "band": len(edges) > 0,
        "ranges": [[float(f"{end:.6g}") for end in _range(column)] for column in values],
        "levels": LINE_LEVELS,
        "steps": _time_steps(data.iloc[:, 0]),
    }
    content = json.dumps(head, separators=(",", ":")).encode() + b"\n" + _packed(values)
    return b64encode(zlib.compress(content, 9)).decode()


def _panels_and_labels(columns: pd.Index, lines: int) -> tuple[list[tuple[str, str]], list[str]]:
    """Return name and unit of each panel, and the labels of the first `lines` lines."""
    parts = [match.groups() for match in map(LINE_COLUMN.fullmatch, columns) if match]
    panels = [*dict.fromkeys((name, unit) for _, name, unit in parts)]
    return panels, [*dict.fromkeys(label for label, *_ in parts)][:lines]


def _range(column: Array) -> tuple[float, float]:
    """Return the smallest and the largest value of a column (N,); zeros if it has none."""
    finite = column[np.isfinite(column)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


def _time_steps(time: pd.Series) -> list[int | None]:
    """Return the steps of time [ms] from 0 on; None where a line is broken."""
    milliseconds = (1000 * time.dropna()).round().astype(int)
    steps = milliseconds.diff().fillna(milliseconds).astype(int).reindex(time.index)
    return [None if pd.isna(step) else int(step) for step in steps]


def _packed(columns: Array) -> bytes:
    """Return the steps of columns (M, N) from level to level, as bytes; see `packed_lines`."""
    ends = np.array([_range(column) for column in columns])
    low, width = ends[:, :1], np.diff(ends, axis=1)
    shares = (columns - low) / np.where(width > 0, width, 1.0)
    levels = np.where(np.isfinite(shares), 1 + np.round(shares * (LINE_LEVELS - 1)), 0)
    steps = np.diff(levels, prepend=0, axis=1)
    codes = np.where(steps < 0, -2 * steps - 1, 2 * steps).astype("<u2")
    return codes.view(np.uint8).reshape(-1, 2).T.tobytes()
