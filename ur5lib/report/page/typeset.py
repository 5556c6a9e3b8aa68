"""The pages of a study, typeset by Typst from what `handed_over` provides."""

import json
import re
from base64 import b64encode
from collections.abc import Iterator
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import matplotlib as mpl
import typst

from ur5lib.errors import InputError
from ur5lib.report.page import closer
from ur5lib.report.page.handed import of_no_study, sources

FONTS = [Path(str(find_spec("font_source_sans_pro").origin)).parent / "files"]  # type: ignore[union-attr]
FONTS += [Path(mpl.get_data_path()) / "fonts" / "ttf"]
EXPERIMENTAL = "html export is under active development"  # the one warning that is expected
LINES = re.compile(r'<script type="text/plain" data-lines="([^"]+)"></script>')
SCENE = re.compile(r'<script type="text/plain" data-scene="([^"]+)"></script>')
IMAGE = re.compile(r'src="(figures/[^"]+\.svg)"')
REFERENCE = re.compile(r"(?<=[\"(])#([\w-]+)(?=[\")])")  # from one part of an SVG to another
STYLE = re.compile(r'style="([^"]*)"')
# These are escaped in a data URI in double quotes.
IN_ADDRESS = str.maketrans({"%": "%25", "#": "%23", "&": "%26"})
SCRIPTS = '<script type="text/plain" id="scripts"></script>'
MAINS = {"several": "several.typ"}  # pages with a source of their own
TABLES = Path(__file__).with_name("kit") / "tables.js"
SECTION = re.compile(r'<section [^>]*\bid="([^"]+)"')
SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def html_page(root: Path, page: str = "report") -> str:
    """Return a self-contained page (report, details, run, or of a topic), with figures and the
    scripts of *Replay*. Raises InputError with file, line and column of an error in its sources.
    """
    text = _compiled(root, page, "html").decode()
    text = IMAGE.sub(lambda found: f'src="{_data_uri(root / found[1])}"', text)
    text = LINES.sub(lambda found: _with_lines(root, found[1]), text)
    text = SCENE.sub(lambda found: _with_scene(root, text, found[1]), text)
    text = text.replace(SCRIPTS, "".join(f"<script>{own}</script>" for own in _scripts(text)), 1)
    return text.replace("script-src SCRIPTS", f"script-src {' '.join(_hashes(text))}", 1)


def report_and_details(root: Path) -> tuple[str, str]:
    """Return the report and its supplement as HTML; the report has links to the sections of the
    supplement.
    """
    details = html_page(root, "details")
    known = json.dumps(SECTION.findall(details))
    (root / "data" / "supplement.json").write_text(known, encoding="utf-8")
    return html_page(root), details


def check_sources() -> None:
    """Typeset the page of an empty study, which is fast. Raises InputError as `html_page` does."""
    with sources(of_no_study()) as root:
        _compiled(root, "report", "html")


def _with_lines(root: Path, path: str) -> str:
    """Return a script element that contains the packed lines of a figure over time, "" for other
    figures.
    """
    packed = closer.packed_lines(root / "figures" / f"{path}.svg")
    return f'<script type="text/plain">{packed}</script>' if packed else ""


def _with_scene(root: Path, text: str, name: str) -> str:
    """Return a script element that contains the packed scene of a recording's arm, "" if no figure
    of the page shows it.
    """
    if f'data-recording="{name}"' not in text:
        return ""
    packed = closer.packed_scene(root / "figures" / name / "scene.json")
    return f'<script type="text/plain" data-scene="{name}">{packed}</script>'


def _data_uri(path: Path) -> str:
    """Return a figure as a data URI, as text: base64 would be a third larger."""
    text = " ".join(path.read_text(encoding="utf-8").split())
    return f"data:image/svg+xml;charset=utf-8,{_compact(text).translate(IN_ADDRESS)}"


def _compact(svg: str) -> str:
    """Return a matplotlib SVG without invisible parts: metadata, unused names, groups of one
    element, spaces, and digits beyond a tenth of a point. Used names and repeated styles become
    short.
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


def _scripts(text: str) -> Iterator[str]:
    """Yield the scripts that a page needs: of *Replay*, and for sorting and copying tables."""
    if "data-recording=" in text:
        yield from closer.scripts()
    yield TABLES.read_text(encoding="utf-8")


def _hashes(text: str) -> list[str]:
    """Return the hashes of a page's scripts in the notation of its security policy."""
    digests = (b64encode(sha256(own.encode()).digest()).decode() for own in SCRIPT.findall(text))
    return [f"'sha256-{digest}'" for digest in digests]


def pdf_document(root: Path) -> bytes:
    """Return the report as PDF/UA-1: title, contents and `first-screen` of `report.typ` first."""
    return _compiled(root, "report", "pdf", pdf_standards=["ua-1"])


def said(root: Path, selector: str, page: str = "report") -> list[Any]:
    """Return the values that a page attaches to a label, such as <card> or <table>; selector: that
    label. Typst can query only the PDF.
    """
    options = _options(root, page, "pdf")
    return list(json.loads(typst.query(root / "report.typ", selector, field="value", **options)))


def _options(root: Path, page: str, target: str) -> dict[str, Any]:
    inputs = {"page": page, "target": target}
    fonts = {"font_paths": FONTS, "ignore_system_fonts": True}
    return {"root": root, "sys_inputs": inputs, **fonts}


def _compiled(root: Path, page: str, target: str, **further: Any) -> bytes:
    """Return a page in a format, target: html or pdf. Raises InputError for an error in the
    sources, and for a warning: Typst drops layout that HTML lacks, with its content.
    """
    options = _options(root, page, target) | {"format": target, "timestamp": 0} | further
    try:
        made, warnings = typst.compile_with_warnings(
            root / MAINS.get(page, "report.typ"), **options
        )
    except typst.TypstError as error:
        raise _failed(root, error.diagnostic[error.diagnostic.index("error: ") :]) from None
    for warning in warnings:
        if EXPERIMENTAL not in warning.message:
            raise _failed(root, warning.diagnostic)
    return bytes(made)


def _failed(root: Path, diagnostic: str) -> InputError:
    """Return an error in the sources, with its file, line and column."""
    own = re.sub(rf"\S*{root.name}/topics", "ur5lib/topics", diagnostic)
    own = re.sub(rf"\S*{root.name}/", "ur5lib/report/page/", own)
    return InputError(f"the page cannot be typeset\n{own}")
