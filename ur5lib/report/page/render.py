"""A document as one HTML file and as PDF, from the same data."""

import json
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2
import typst
from markupsafe import Markup

from ur5lib.report.page import closer
from ur5lib.report.page.document import Document

TEMPLATE_FOLDER = Path(__file__).parent / "templates"
UNESCAPED_CHARACTERS = " '!$()*+,-./:;=?@[]_~"  # characters that a data URI need not escape


def html_page(document: Document) -> str:
    """Return a self-contained page, with styles, figures and the scripts of *Look closer*."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"data_uri": _data_uri, "packed_lines": closer.packed_lines}
    environment.filters["packed_scenes"] = closer.packed_scenes
    environment.globals["closer"] = closer
    return environment.get_template("report.html.jinja").render(document=document.as_data())


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


def _data_uri(path: str) -> Markup:
    """Return a figure as a data URI, as text: base64 would be a third larger, and line breaks and
    double quotes cost three characters each. Neither these nor ampersands are left in it, so that
    it stands as it is in double quotes.
    """
    text = " ".join(Path(path).read_text(encoding="utf-8").split())
    return Markup("data:image/svg+xml," + quote(_compact(text), safe=UNESCAPED_CHARACTERS))


def _compact(svg: str) -> str:
    """Return an SVG of matplotlib's without what nobody sees: metadata, names that nothing refers
    to, spaces, and digits beyond a hundredth of a point.
    """
    used = {*re.findall(r"#([\w-]+)", svg)}
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg)
    svg = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", svg)
    svg = re.sub(r"\d{2,}\.\d{3,}", lambda found: f"{float(found[0]):.2f}", svg)
    svg = re.sub(r"(?<=[:;>]) +| (?=[MLQCz] )", "", svg)
    return svg.replace('"', "'").replace("xlink:href", "href")
