"""The notebook of the documents: run cell by cell, with what it shows.

`python -m tests.notebook <folder>` runs it where the study `demo` is built, and keeps its outputs.
"""

import ast
import base64
import contextlib
import io
import json
import os
import sys
from typing import Any

from matplotlib.figure import Figure

from tests.conftest import PROJECT

NOTEBOOK = PROJECT / "docs" / "notebook.ipynb"
Cell = dict[str, Any]


def code_cells(notebook: dict[str, Any]) -> list[Cell]:
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def run(cell: Cell, known: dict[str, Any]) -> list[Cell]:
    """What a cell prints, and the value of its last line, as Jupyter keeps them."""
    tree = ast.parse("".join(cell["source"]))
    last = tree.body[-1]
    if isinstance(last, ast.Expr):
        tree.body.pop()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), known)
        value = None
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), known)
    outputs: list[Cell] = []
    if text := printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": text.splitlines(True)})
    if value is not None:
        result = {"output_type": "execute_result", "metadata": {}, "data": shown(value)}
        outputs.append(result | {"execution_count": cell["execution_count"]})
    return outputs


def shown(value: Any) -> dict[str, Any]:
    """A value by its types of media."""
    data: dict[str, Any] = {"text/plain": repr(value).splitlines(True)}
    if hasattr(value, "_repr_html_") and (html := value._repr_html_()):
        data["text/html"] = html.splitlines(True)
    if hasattr(value, "_repr_png_"):
        data["image/png"] = base64.b64encode(value._repr_png_()).decode()
    elif isinstance(value, Figure):
        value.savefig(png := io.BytesIO(), format="png")
        data["image/png"] = base64.b64encode(png.getvalue()).decode()
    return data


def as_text(output: Cell) -> str:
    """What an output shows as text."""
    return "".join(output.get("text") or output["data"]["text/plain"])


def main(folder: str) -> None:
    notebook, known = json.loads(NOTEBOOK.read_text()), dict[str, Any]()
    os.chdir(folder)
    for number, cell in enumerate(code_cells(notebook), 1):
        cell["execution_count"] = number
        cell["outputs"] = run(cell, known)
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
