"""What a paper takes over: figures as wide as a column, tables and methods as LaTeX."""

import re
import shutil
import subprocess
from itertools import accumulate
from pathlib import Path

import numpy as np
import pandas as pd
import pypdfium2
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pypdf import PdfReader

from tests.conftest import PROJECT
from ur5lib import __version__
from ur5lib.report.charts import calibration_panels, residual_panels, scatter_panels
from ur5lib.report.document import Cell, Document, Picture, Section, Table
from ur5lib.report.house_style import Drawing, save
from ur5lib.report.paper import methods, paper, references, tex, tex_table, write_tables
from ur5lib.report.results import Results
from ur5lib.report.traces import CURRENT, WRENCH, Traces, draw_traces
from ur5lib.study.reading import parse_study

COLUMN = 88.0  # mm
SMALLEST = 6.0  # points
HOSTILE = (
    r"\input{/etc/passwd} $x_1^2$ & 100 % #1 {~} \\ \end{document} “é” F̂ᵐᵃᵖ q̈ τ ≥ 中 <b> [N] [x]"
)
ERRORS = re.compile(r"^!.*|Undefined control sequence|multiply defined|Missing character.*", re.M)


def drawing(name: str) -> Drawing:
    """A figure of one of several kinds, one with more vertices than the report keeps as lines."""
    time = np.linspace(0, 60, 20_000)
    waves = np.outer(np.sin(time), np.arange(1.0, 7.0))
    thin = waves[::40]
    series = {"force sensor": (waves, "measured"), "F̂ᵐᵃᵖ": (0.9 * waves, "third")}
    errors = {"F̂ᵐᵃᵖ": (0.1 * waves, "third")}
    shares = {"in contact": np.full((3, 3), 80.0), "free": np.full((3, 3), 90.0)}
    match name:
        case "forces":
            return draw_traces(Traces(time, series, errors, (waves - 1, waves + 1)), WRENCH)
        case "residuals":
            return residual_panels(thin, {"q̇ [rad/s]": thin, "τ [Nm]": thin}, "A")
        case "friction":
            return scatter_panels(thin, thin, ("velocity of joint {} [rad/s]", "τ of {} [Nm]"))
        case "calibration":
            return calibration_panels([50, 80, 95], {"F̂ᵐᵃᵖ": shares}, ["Fx", "Fy", "Fz"])
    return draw_traces(Traces(time, {"a": (waves, "joint")}), CURRENT)


@pytest.mark.parametrize("name", ["forces", "currents", "residuals", "friction", "calibration"])
def test_figures_fit_a_column_with_their_fonts(name: str, tmp_path: Path) -> None:
    for copy in ("a", "b"):
        save(drawing(name), tmp_path / f"{copy}.pdf")
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    assert not (tmp_path / "a.csv").exists()
    (page,) = PdfReader(tmp_path / "a.pdf").pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(COLUMN, abs=0.1)
    assert len(page.images) == 0
    text = pypdfium2.PdfDocument(tmp_path / "a.pdf")[0].get_textpage()
    boxes = np.array([text.get_rect(i) for i in range(text.count_rects())])
    assert boxes.min() >= 0, "no text is cut"
    assert (boxes.max(axis=0)[2:] <= page.mediabox.upper_right).all()
    fonts = [font.get_object() for font in page["/Resources"]["/Font"].values()]
    assert fonts
    for font in fonts:
        described = font["/DescendantFonts"][0].get_object()["/FontDescriptor"].get_object()
        assert "/FontFile2" in described, "TrueType, embedded"
    sizes: list[float] = []
    page.extract_text(visitor_text=lambda *told: sizes.append(told[-1]))
    assert min(size for size in sizes if size) >= 0.7 * SMALLEST  # indices are smaller


# LaTeX


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


def table() -> Table:
    rows = [
        [Cell("joint 1"), Cell("−1.5"), Cell("0.12 ± 0.03", "lowest"), Cell("1 to 2")],
        [Cell("joint_2"), Cell("1,234.25"), Cell("–"), Cell("F̂ᵐᵃᵖ")],
        [Cell("joint 3"), Cell("+0.5"), Cell("12.00 ± 1.50", "highest"), Cell("5 %")],
    ]
    return Table(
        "Errors [Nm, N] of 5 %.", ["joint", "Fx [N]", "c [kg m²]", "words"], rows, "a.b-c_1"
    )


def test_columns_of_numbers_stand_at_the_point() -> None:
    text = tex_table(table())
    check_latex(text)
    assert "{l S[table-format=-4.2, retain-explicit-plus] S[table-format=2.2 +- 1.2] l}" in text
    assert r"joint & {Fx [\unit{N}]} & {c [\unit{kg.m^2}]} & words \\" in text
    assert r"joint 1 & -1.5 & \bfseries 0.12 +- 0.03 & 1 to 2 \\" in text
    assert r"joint\_2 & 1234.25 & {--} & $\hat{F}$\textsuperscript{m}" in text
    assert r"\caption{Errors [\unit{N.m}, \unit{N}] of 5 \%.}" in text
    assert r"\label{tab:a-b-c_1}" in text


@given(st.text())
def test_any_text_is_harmless(text: str) -> None:
    check_latex(tex(text))
    known = r"text\w+|(?:hat|tilde|bar|dot|ddot)|pm|times|cdot|leq|geq|to|ldots|unit|[A-Za-z]{2,7}"
    assert all(re.fullmatch(known, name) for name in re.findall(r"\\([A-Za-z]+)", tex(text)))


def test_every_sign_stands_for_itself() -> None:
    assert tex("a_b & 5 % {x} #1 $y$") == r"a\_b \& 5 \% \{x\} \#1 \$y\$"
    assert tex("\\input") == r"\textbackslash{}input"
    assert tex("q̈ in rad/s² [rad/s²]") == r"$\ddot{q}$ in rad/s\textsuperscript{2} [\unit{rad/s^2}]"
    assert tex("中 Δτ [x_1]") == r"U+4E2D $\Delta$$\tau$ [x\_1]"


def results(folder: Path, **tables: pd.DataFrame) -> Results:
    """Those of a study of one recording, with settings of its own; most tables are empty."""
    recording = {"name": "still", "robot": "ur5", "format": "thesis-csv", "role": "fit"}
    given = {
        "study": "small",
        "title": HOSTILE,
        "recordings": [recording | {"folder": str(folder)}],
        "settings": {"lowpass": {"motion": {"order": 3, "cutoff_hz": 12.5}}},
    }
    study = parse_study(given, "config.yaml").model_dump(mode="json", exclude_none=True)
    empty = ("parameters", "friction", "detection", "force_mae")
    return Results(study, dict.fromkeys(empty, pd.DataFrame()) | tables, folder, commit="1a2b")


def test_methods_name_the_settings_in_use(tmp_path: Path) -> None:
    text = methods(results(tmp_path))
    check_latex(text)
    assert r"order 3 and \qty{12.5}{Hz} for torques in the identification" in text
    assert r"\qty{0.1}{s}" in text
    assert "1 without contact for the fits." in text
    assert "friction" not in text  # of which the study has none
    fitted = methods(results(tmp_path, friction=pd.DataFrame({"joint": [1]})))
    assert "Coulomb, viscous and load-dependent friction" in fitted


def test_what_is_cited_can_be_found(tmp_path: Path) -> None:
    rows = dict.fromkeys(("parameters", "friction", "detection", "force_mae"), pd.DataFrame([1]))
    cited = re.findall(r"\\cite\{(.*?)\}", methods(results(tmp_path, **rows)))
    listed = re.findall(r"^@\w+\{(.*),$", references(), re.MULTILINE)
    # the study of the thesis cites the one, the paper about this project the other
    assert {*cited} == {*listed} - {"kufieta2014", "deluca2003"}
    check_latex(references())


def test_the_references_are_those_of_the_citation_file() -> None:
    known = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
    bare = re.sub(r"[{}]", "", references())
    for title in (known["title"], known["references"][0]["title"], __version__):
        assert title in bare


def test_everything_compiles(tmp_path: Path) -> None:
    figures = tmp_path / "figures"
    save(drawing("currents"), figures / "still" / "currents.svg")
    save(drawing("currents"), figures / "still" / "currents.pdf")
    picture = Picture(HOSTILE, figures / "still" / "currents.svg", HOSTILE, "currents")
    row = [Cell(HOSTILE), Cell("1")]
    many = [Table(HOSTILE, [HOSTILE, "a"], [row], f"t.{i}") for i in range(40)]
    document = Document(HOSTILE, HOSTILE, [Section("", [picture, table(), *many])]).numbered()
    known = results(figures)
    write_tables(document, tmp_path / "tables")
    for name, text in (
        ("methods.tex", methods(known)),
        ("references.bib", references()),
        ("paper.tex", paper(document, known)),
    ):
        check_latex(text)
        (tmp_path / name).write_text(text)
    log = compile_latex(tmp_path / "paper.tex")
    assert ERRORS.findall(log) == []
    assert "undefined" not in log
    text = "\n".join(page.extract_text() for page in PdfReader(tmp_path / "paper.pdf").pages)
    assert "U+4E2D" in text
    assert "1234.25" in text.replace(" ", "").replace("\u202f", "")
