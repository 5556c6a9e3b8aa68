"""What the site has beyond the documents as they lie here: `make docs` runs it on their copy.

    python site/pages.py <folder>
    python site/pages.py --home

The notebook becomes a page with what its cells print and draw, and links to it lead there. Reports
that are built, of recordings that may be shown, are copied to reports/<study> with all that they
link, and the gallery links them: where it has the comment `<!-- report: <study> -->`. The words for
a picture are shown below it, unless the text there says what it shows. Numbers of data/ that a page
links are a table that opens there. `--home` prints the address of the project's source, empty where
CITATION.cff states none.
"""

import base64
import csv
import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import yaml

PROJECT = Path(__file__).parents[1]
REPORT = re.compile(r"<!-- report: ([\w-]+) -->")
PICTURE = re.compile(r"^!\[([^\]]+)\]\([\w/]+\.svg\)$(?!\n\n(?:\*[^*]|- \*\*Shows))", re.MULTILINE)
CAPTION = '{}\n\n*{}*{{aria-hidden="true"}}'  # who hears the page has heard these words
NUMBERS = re.compile(r"\[The numbers\]\((data/\w+\.csv)\)")
LINK = re.compile(r'(?:href|src)="([^"#:]+)["#]')  # to a file beside a page


def main(folder: Path) -> None:
    """Complete the copy of the documents."""
    docs = folder / "docs"
    notebook = json.loads((docs / "notebook.ipynb").read_text(encoding="utf-8"))
    (docs / "notebook.md").write_text(as_markdown(notebook, docs), encoding="utf-8")
    for page in [*folder.glob("*.md"), *docs.glob("*.md")]:
        text = page.read_text(encoding="utf-8").replace("notebook.ipynb)", "notebook.md)")
        text = NUMBERS.sub(lambda found: table(docs / found[1]), text)
        text = REPORT.sub(lambda found: link(found[1], folder), text)
        text = PICTURE.sub(lambda found: CAPTION.format(found[0], found[1]), text)
        page.write_text(text, encoding="utf-8")


def table(file: Path) -> str:
    """Return a file of numbers as a table that a reader opens, with a link to the file."""
    with file.open(encoding="utf-8", newline="") as rows:
        head, *cells = csv.reader(rows)
    lines = [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *cells)]
    told = f"<details markdown><summary>The numbers</summary>\n\n[As CSV](data/{file.name})"
    return "\n".join([f"{told}\n", *lines, "\n</details>"])


def as_markdown(notebook: dict[str, Any], folder: Path) -> str:
    """Return a notebook as a page in Markdown; its pictures become files in the folder."""
    parts = []
    for number, cell in enumerate(notebook["cells"], 1):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        parts += [shown(output, folder / f"notebook_{number}.png") for output in cell["outputs"]]
    return "\n\n".join(parts) + "\n"


def shown(output: dict[str, Any], picture: Path) -> str:
    """Return what a cell printed, or its picture, which is written."""
    data = output.get("data", {})
    if "image/png" in data:
        picture.write_bytes(base64.b64decode(data["image/png"]))
        return f"![What the cell above draws]({picture.name})"
    text = "".join(output.get("text") or data["text/plain"])
    return f"```text\n{text.rstrip()}\n```"


def link(study: str, folder: Path) -> str:
    """Return a link to a study's report, which is copied; nothing where it is not built."""
    results = PROJECT / "results" / study
    if not (results / "report.html").exists():
        return ""
    for name in linked(results, "report.html", set()):
        copy = folder / "reports" / study / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(results / name, copy)
    return f"[Open its report](../reports/{study}/report.html)"


def linked(folder: Path, page: str, known: set[str]) -> set[str]:
    """Return a page's name, those of all files that it links, and what these link in turn."""
    known.add(page)
    if page.endswith(".html"):
        for name in {*LINK.findall((folder / page).read_text(encoding="utf-8"))} - known:
            linked(folder, name, known)
    return known


def home() -> str:
    """Return the address of the project's source, empty where none is stated."""
    cited = yaml.safe_load((PROJECT / "CITATION.cff").read_text(encoding="utf-8"))
    return str(cited.get("repository-code", ""))


if __name__ == "__main__":
    if sys.argv[1] == "--home":
        print(home())
    else:
        main(Path(sys.argv[1]))
