"""The documents' pictures, and what reports say in lesson and gallery, from built studies.

    python -m benchmarks.pictures

Copies figures of results/demo and results/ur10-bag into docs/, photographs the first screen of the
lesson's report by Chromium, and writes what cards say into docs/lesson.md and, of the studies that
are built, docs/gallery.md; the columns of tables go into docs/report.md. `make pictures` builds the
first two studies before, `make gallery` all. `--quick` leaves out the photograph.
"""

import ast
import re
import shutil
from pathlib import Path
from typing import Any

from benchmarks.harness.markdown import markdown, replaced, section
from benchmarks.harness.options import built, options_of
from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.errors import InputError
from ur5lib.records.verdicts import REASONS
from ur5lib.report.page.sentences import names, speaking_of, spoken
from ur5lib.report.views.cards import number
from ur5lib.tables import read_json, write_text
from ur5lib.tidy import columns

RESULTS_FOLDER = Path("results")
LIBRARY = Path(__file__).parents[1] / "ur5lib"
DOCUMENTS = Path(__file__).parents[1] / "docs"
LESSON = "ur10-bag"
PUSHED, MOTION, ARM = "way_points_pushed", "ur10_exciting_trajectory", "ur10"
FIGURES = {  # picture: the figure of a study
    "example": f"demo/figures/{PUSHED}/forces_estimated",
    "lesson_constants": f"{LESSON}/figures/{ARM}/current_torque",
    "lesson_friction": f"{LESSON}/figures/{ARM}/friction",
    "lesson_knowledge": f"{LESSON}/figures/{ARM}/knowledge",
    "lesson_currents": f"{LESSON}/figures/{MOTION}/currents",
    "lesson_force": f"{LESSON}/figures/{MOTION}/forces_estimated",
}
GALLERY = {  # section of the page: the study
    "A simulated UR5": "demo",
    "The thesis's UR5": "thesis",
    "A UR10 in a ROS bag": LESSON,
    "A UR3 without rotors": "ur3-cb",
    "A KUKA KR300 by its motors' torques": "kuka-kr300",
}
FIRST_SCREEN = {"width": 1000, "height": 620}  # pixels


def main() -> None:
    """Copy, write and photograph."""
    given = options_of(__doc__).parse_args()
    built(RESULTS_FOLDER / study for study in ("demo", LESSON))
    for name, figure in FIGURES.items():
        shutil.copy(RESULTS_FOLDER / f"{figure}.svg", DOCUMENTS / f"{name}.svg")
    report = DOCUMENTS / "report.md"
    write_text(with_columns(report.read_text()), report)
    lesson, gallery = DOCUMENTS / "lesson.md", DOCUMENTS / "gallery.md"
    write_text(with_verdicts(lesson.read_text(), results(LESSON)), lesson)
    text = gallery.read_text()
    for title, study in GALLERY.items():
        if (RESULTS_FOLDER / study / "results.json").exists():
            text = replaced(text, title, cards(results(study), first=True))
    write_text(text, gallery)
    if not given.quick:
        photograph(RESULTS_FOLDER / LESSON / "report.html", DOCUMENTS / "lesson_report.png")


def with_columns(page: str) -> str:
    """Return the report's page with the columns of each table."""
    rows = [[f"`{name}`", ", ".join(own)] for name, own in sorted((columns() | declared()).items())]
    return replaced(page, "Columns of the tables", markdown(["table", "columns"], rows))


def declared() -> dict[str, list[str]]:
    """Return the fields of each class of the library that is `A row of <table>.csv`."""
    found = {}
    for path in sorted(LIBRARY.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ClassDef):
                continue
            if table := re.match(r"A row of (\w+)\.csv", ast.get_docstring(node) or ""):
                fields = [part.target for part in node.body if isinstance(part, ast.AnnAssign)]
                found[table[1]] = ["…", *map(ast.unparse, fields)]
    return found


def results(study: str) -> dict[str, Any]:
    """Return the first screen of a study's report."""
    return read_json(RESULTS_FOLDER / study / "results.json")


def cards(found: dict[str, Any], first: bool = False) -> str:
    """Return a table of what the cards of a report say: state, number that decides, and reason;
    first: the reason alone.
    """
    with speaking_of(effort_of(found)):
        return markdown(
            ["card", "state", *([] if first else ["number"]), "why"], lines(found, first)
        )


def effort_of(found: dict[str, Any]) -> Effort:
    """Return what a study's arms measure: torques, where their errors are of torques."""
    units = {row["unit"] for row in found["verdicts"] if row["question"] == "currents"}
    return TORQUE if "Nm" in units and CURRENT.unit not in units else CURRENT


def lines(found: dict[str, Any], first: bool) -> list[list[str]]:
    """Return a line for each card."""
    rows = []
    for row in found["verdicts"]:
        if row["state"] and row["rank"] == 1 and not (row["arm"] and of_study(row, found)):
            known = {name: value for name, value in row.items() if value not in (None, "")}
            one, why = number(known), spoken(REASONS.get(row["reason"], ""))
            told = [why] if first else [f"{one.text} {one.name}".strip(), why]
            title = spoken(names("question").get(row["question"], row["question"]))
            rows.append([title, row["state"], *told])
    return rows


def of_study(row: dict[str, Any], found: dict[str, Any]) -> bool:
    """Return whether a verdict on an arm has one on the whole study."""
    same = [one for one in found["verdicts"] if one["question"] == row["question"]]
    return any(not one["arm"] and one["state"] for one in same)


def with_verdicts(page: str, found: dict[str, Any]) -> str:
    """Return the lesson with the cards and the next steps of a study's results.json."""
    title = "Read the first screen"
    following = section(page, title).partition("\n\nSo a report")[2].partition("| next |")[0]
    steps = next(own for own in found["lists"] if own["heading"] == "What to do next")
    next_steps = markdown(["next"], [[step] for step in steps["sentences"]])
    return replaced(page, title, f"{cards(found)}\n\nSo a report{following}{next_steps}")


def photograph(report: Path, picture: Path) -> None:
    """Write a report's first screen as PNG. Raises InputError without Chromium."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        raise InputError("Chromium is not installed, which photographs the report; install it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page(viewport=FIRST_SCREEN)
        page.goto(report.absolute().as_uri())
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main()
