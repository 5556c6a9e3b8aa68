"""A document as one HTML file and as PDF, from the same data."""

import base64
import json
import shutil
import tempfile
from pathlib import Path

import jinja2
import typst

from ur5lib.report.document import Document
from ur5lib.tables import write_bytes, write_text

TEMPLATES = Path(__file__).parent / "templates"


def write_html(document: Document, path: str | Path) -> None:
    """One self-contained HTML file: styles and figures inside, nothing fetched, no script."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["data_uri"] = _data_uri
    page = environment.get_template("report.html.jinja").render(document=document.as_data())
    write_text(page, path)


def write_pdf(document: Document, path: str | Path) -> None:
    """The same document as PDF; typst reads nothing outside a temporary folder."""
    data = document.as_data()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copy(TEMPLATES / "report.typ", root)
        for picture, block in zip(document.pictures(), _pictures(data), strict=True):
            block["path"] = f"figure_{picture.number}.svg"
            shutil.copy(picture.path, root / block["path"])
        (root / "report.json").write_text(json.dumps(data), encoding="utf-8")
        write_bytes(typst.compile(root / "report.typ", root=root, timestamp=0), path)


def _pictures(data: dict) -> list[dict]:
    return [b for section in data["sections"] for b in section["blocks"] if b["kind"] == "picture"]


def _data_uri(path: str) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(Path(path).read_bytes()).decode()
