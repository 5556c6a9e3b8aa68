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
from markupsafe import Markup, escape

from ur5lib.report.page import closer
from ur5lib.report.page.document import Document

TEMPLATE_FOLDER = Path(__file__).parent / "templates"
NAMED_FILES = re.compile(r"\b(docs/[\w-]+\.md|tables\.zip|configuration\.yaml)")
DOCUMENTS = Path("docs")  # of a clone, two folders above the results of a study
BREAK = re.compile(r"(?<=\d) (?=±)|(?<=±) (?=\d)|(?<=\d) (?=%|(?:[mk]?[msgN]|A|Nm|Hz|min|rad)\b)")
REFERENCE = re.compile(r"(?<=[\"(])#([\w-]+)(?=[\")])")  # from one part of an SVG to another
STYLE = re.compile(r'style="([^"]*)"')
TYPED = re.compile(r"`(\w[^`]+)`")  # keys, names and commands in a sentence
UNESCAPED_CHARACTERS = " '!$()*+,-./:;<=?@[]_~"  # characters that a data URI need not escape


def html_page(document: Document) -> str:
    """Return a self-contained page, with styles, figures and the scripts of *Replay*."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
        finalize=_unbroken,
    )
    environment.filters |= {"data_uri": _data_uri, "packed_lines": closer.packed_lines}
    environment.filters |= {"packed_scenes": closer.packed_scenes}
    environment.filters |= {"breakable": _breakable, "with_links": _with_links}
    environment.globals["closer"] = closer
    return environment.get_template("report.html.jinja").render(document=document.as_data())


def pdf_document(document: Document) -> bytes:
    """Return the same document as PDF; typst reads only a temporary folder."""
    data = document.as_data()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copy(TEMPLATE_FOLDER / "report.typ", root)
        for block in _blocks(data, "picture"):
            picture = f"figure_{block['number']}.svg"
            shutil.copy(block["path"], root / picture)
            block["path"] = picture
        (root / "report.json").write_text(_unbroken(json.dumps(data, ensure_ascii=False)), "utf-8")
        compiled: bytes = typst.compile(root / "report.typ", root=root, timestamp=0)
        return compiled


def _blocks(data: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [b for section in data["sections"] for b in section["blocks"] if b["kind"] == kind]


def _unbroken(text: Any) -> Any:
    """Return a text in which no line breaks between a number and its error or its unit."""
    return BREAK.sub("\u00a0", text) if type(text) is str else text


def _with_links(text: str, home: str) -> Markup:
    """Return a text in which the files that it names are links; home: from its page to the results.

    Documents are there in a clone alone.
    """

    def link(named: re.Match[str]) -> str:
        name, up = named[0], "../../" if named[0].startswith(f"{DOCUMENTS}/") else ""
        known = not up or Path(name).is_file()
        return f'<a href="{home}{up}{name}">{name}</a>' if known else name

    return Markup(NAMED_FILES.sub(link, _coded(text)))


def _breakable(text: str) -> Markup:
    """Return the text of a cell, in which a line may break within long names, not after < or >."""
    whole = re.sub(r"(?<=&[lg]t;) (?=\d)", "\u00a0", _coded(text))
    return Markup(re.sub(r"(?<=\w{9}[_/.-])(?=[\w-]{9})", "<wbr>", whole))


def _coded(text: str) -> str:
    """Return a text as HTML, with what is typed as code."""
    return TYPED.sub(r"<code>\1</code>", str(escape(_unbroken(text))))


def _data_uri(path: str) -> Markup:
    """Return a figure as a data URI, as text: base64 would be a third larger, and line breaks and
    double quotes cost three characters each. Neither these nor ampersands are left in it, so that
    it stands as it is in double quotes.
    """
    text = " ".join(Path(path).read_text(encoding="utf-8").split())
    return Markup("data:image/svg+xml," + quote(_compact(text), safe=UNESCAPED_CHARACTERS))


def _compact(svg: str) -> str:
    """Return an SVG of matplotlib's without what nobody sees: metadata, names that nothing refers
    to, groups of one, spaces, and digits beyond a tenth of a point; other names and styles that
    repeat are short.
    """
    names = {name: f"n{i}" for i, name in enumerate(dict.fromkeys(REFERENCE.findall(svg)))}
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg)
    svg = re.sub(r' id="([^"]*)"', lambda m: f' id="{names[m[1]]}"' if m[1] in names else "", svg)
    svg = REFERENCE.sub(lambda found: f"#{names[found[1]]}", svg)
    svg = re.sub(r"\d{2,}\.\d{3,}", lambda found: f"{float(found[0]):.1f}", svg)
    svg = re.sub(r"(\.\d{3})\d+", r"\1", svg)
    svg = re.sub(r"(?<=[:;>]) +| (?=[MLQCz] )|(?<=>) (?=<)", "", svg)
    for _ in range(2):
        svg = re.sub(r"<g>(<[^>]*/>)</g>", r"\1", svg)
    styles = {style: f"s{i}" for i, style in enumerate(dict.fromkeys(STYLE.findall(svg)))}
    svg = STYLE.sub(lambda found: f'class="{styles[found[1]]}"', svg)
    sheet = "".join(f".{name}{{{style}}}" for style, name in styles.items())
    svg = svg.replace("<defs>", f"<defs><style>{sheet}</style>", 1)
    return svg.replace('"', "'").replace("xlink:href", "href")
