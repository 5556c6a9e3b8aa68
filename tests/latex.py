"""LaTeX, where it is installed, and what every LaTeX file must keep to where it is not."""

import re
import shutil
import subprocess
from itertools import accumulate
from pathlib import Path

import pytest

ERRORS = re.compile(r"^!.*|Undefined control sequence|multiply defined|Missing character.*", re.M)


def compile_latex(document: Path) -> str:
    """Return the log of pdflatex, run twice with bibtex between; skip where it is missing."""
    if shutil.which("pdflatex") is None:
        pytest.skip("LaTeX is not installed (Debian: texlive-science): nothing was compiled")
    latex = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", document.name]
    for command in (latex, ["bibtex", document.stem], latex, latex):
        if command[0] == "bibtex" and "\\bibliography" not in document.read_text():
            continue
        done = subprocess.run(command, cwd=document.parent, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-2000:]
    return document.with_suffix(".log").read_text(errors="replace")


def check_latex(text: str) -> None:
    """Braces are balanced, rows have the cells of their table, and all is ASCII or Latin."""
    bare = re.sub(r"\\[\\{}&%$#_]", lambda sign: "\n" if sign[0] == r"\\" else "", text)
    depths = [*accumulate((sign == "{") - (sign == "}") for sign in bare)]
    assert min(depths, default=0) >= 0
    assert not depths or depths[-1] == 0
    assert bare.count("$") % 2 == 0
    assert max(map(ord, text), default=0) <= 0x17F
    for columns, body in re.findall(r"\\begin{tabular}{(.*?)}\n(.*?)\\end{tabular}", bare, re.S):
        width = len(re.sub(r"\[.*?\]", "", columns).split())
        rows = [row for row in body.split("\n") if "&" in row]
        assert {row.count("&") + 1 for row in rows} <= {width}
