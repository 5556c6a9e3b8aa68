"""The documents' pictures, and what reports say in lesson and gallery, from built studies.

    python -m benchmarks.pictures

Draws docs/pictures from the studies that are built, and from tables of the pages; photographs the
first screen of the lesson's report by Chromium; writes what cards say into docs/lesson.md,
docs/gallery.md and docs/bad_report.md; columns and rules go into docs/report.md. `make pictures`
builds the first two studies before, `make studies` all. `--quick` leaves out the photograph.
"""

import re
import shutil
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import ur5lib
from benchmarks.harness import series_pictures as series
from benchmarks.harness import table_pictures as tables
from benchmarks.harness.markdown import markdown, read_page, replaced, section, write_page
from benchmarks.harness.options import built, options_of
from benchmarks.harness.rules import with_evidence, with_rules
from ur5lib.errors import InputError
from ur5lib.jobs import files
from ur5lib.records.verdicts import NO_DOUBT, STATES, reason_in_words, state_in_words
from ur5lib.report.figures.house_style import Drawing, save
from ur5lib.report.page.handed import handed_over
from ur5lib.report.page.typeset import said
from ur5lib.report.results import Results
from ur5lib.report.summary import page_data
from ur5lib.robots.description import Robot
from ur5lib.steps.make_tables import OF_ARMS, OF_MOTION, OF_RECORDINGS
from ur5lib.tables import write_text

RESULTS_FOLDER = Path("results")
LIBRARY = Path(__file__).parents[1] / "ur5lib"
DOCUMENTS = Path(__file__).parents[1] / "docs"
PICTURES = DOCUMENTS / "pictures"
LESSON = "ur10-bag"
PUSHED, MOTION, ARM = "way_points_pushed", "ur10_exciting_trajectory", "ur10"
THESIS_PUSHED = "Movement_No9_Singularity_Free_ForceSensor"
FIGURES = {  # by picture: the figure of a study
    "example": f"demo/figures/{PUSHED}/forces_estimated",
    "lesson_constants": f"{LESSON}/figures/{ARM}/current_torque",
    "lesson_friction": f"{LESSON}/figures/{ARM}/friction",
    "lesson_knowledge": f"{LESSON}/figures/{ARM}/knowledge",
    "lesson_currents": f"{LESSON}/figures/{MOTION}/currents",
    "lesson_force": f"{LESSON}/figures/{MOTION}/forces_estimated",
    "filters": "demo/figures/filters",
    "torques": "demo/figures/excitation/torques",
    "imu": "demo/figures/excitation/accelerations",
    "tracking": "thesis/figures/Movement_No5_Acc_slow_no_disturbance/positions",
    "models": "demo/figures/ur5/models",
    "frames": "demo/figures/ur5/frames",
    "calibration": "demo/figures/calibration",
    "thesis_force": f"thesis/figures/{THESIS_PUSHED}/forces_estimated",
    "ur3_constants": "ur3-cb/figures/ur3/current_torque",
    "ur10e_dates": "ur10e/figures/ur10e/health",
    "six_seconds": "ur5e-rtde/figures/ur5e/knowledge",
    "designed": "excited/excitation",
}
DRAWN: dict[str, tuple[str, Callable[[Path], Drawing]]] = {  # by picture: study, function
    "frame_repair": ("demo", lambda of: series.packets(of, "every_fault")),
    "clock": ("demo", lambda of: series.start_stamps_against_joints(of, "excitation", (16, 19))),
    "low_pass": ("demo", lambda of: series.low_passes(of, PUSHED, (0, 4))),
    "smoothing": ("demo", lambda of: series.accelerations(of, "excitation", (4, 7))),
    "first_motion": ("demo", lambda of: series.first_motion(of, "way_points", (0, 4), (1, 2, 3))),
    "gate": ("demo", lambda of: series.gate(of, PUSHED, (0, 20))),
    "live": ("demo", lambda of: series.live_force(of, PUSHED, (0, 20))),
    "tare": ("demo", lambda of: series.tare(of, "pressed", "pressed_tared")),
    "sensor_bias": ("demo", lambda of: series.sensor_bias(of, PUSHED)),
    "thresholds": ("demo", lambda of: series.thresholds(of, "ur5")),
    "friction_of_a_joint": ("demo", lambda of: series.friction_alone(of, "ur5", 3)),
    "paper": ("demo", lambda of: series.of_a_paper(of, PUSHED)),
    "friction_terms": ("demo", tables.friction_terms),
    "friction_to_type_in": ("demo", tables.friction_to_type_in),
    "constants": ("demo", tables.constants),
    "pushes_by_direction": ("demo", tables.pushes_by_direction),
    "share_found": ("demo", tables.share_found),
    "thesis_errors": ("thesis", lambda of: tables.by_axis(of, tables.ESTIMATES)),
    "touched_links": ("demo", tables.touched_links),
    "truths": ("demo", tables.truths),
    "next_recordings": ("demo", tables.worth_of_next),
    "led_by_hand": ("ur5e-demonstrations", tables.constants),
}
OF_PAGES = {  # by picture: page with the drawn table, function
    "what_to_expect": ("expect", tables.what_to_expect),
    "live_pushes": ("live", tables.live_pushes),
    "world": ("world", tables.world),
    "simulated_arms": ("benchmark", tables.simulated_arms),
    "torque_from_motion": ("benchmark", tables.torque_from_motion),
    "published_friction": ("benchmark", tables.published_friction),
    "parts_of_estimate": ("benchmark", tables.parts_of_estimate),
    "states_a_second": ("benchmark", tables.states_a_second),
}
GALLERY = {  # section of the page: the study
    "A simulated UR5": "demo",
    "The thesis's UR5": "thesis",
    "A UR10 in a ROS bag": LESSON,
    "A UR3 without rotors": "ur3-cb",
    "A KUKA KR300 by its motors' torques": "kuka-kr300",
    "A UR10e over two months": "ur10e",
    "A UR5e led by hand": "ur5e-demonstrations",
    "A UR5e at 500 Hz": "ur5e-rtde",
}
BAD = {  # section of the page on bad reports: the study
    "A UR5e led by hand": "ur5e-demonstrations",
    "A KR300 without links": "kuka-kr300",
}
WIDTH, SCREEN, CARDS = 1280, 900, 600  # pixels: of a screen, its height, and that of the cards


BADGE = """<svg xmlns="http://www.w3.org/2000/svg" width="104" height="20">
<rect width="104" height="20" rx="3" fill="#555"/>
<rect x="56" width="48" height="20" rx="3" fill="#00695c"/>
<g fill="#fff" text-anchor="middle" font-family="sans-serif" font-size="11">
<text x="28" y="14">version</text>
<text x="80" y="14">{}</text>
</g>
</svg>
"""  # of the README


class Card(NamedTuple):
    """A card of a report, "" for a missing state, number or reason."""

    title: str
    state: str
    number: str
    why: str


class FirstScreen(NamedTuple):
    """The first screen of a report: its cards, and the next steps (sentence and command)."""

    cards: list[Card]
    steps: list[list[str]]


def main() -> None:
    """Copy, write and photograph."""
    given = options_of(__doc__).parse_args()
    built(RESULTS_FOLDER / study for study in ("demo", LESSON))
    draw_pictures()
    write_text(BADGE.format(ur5lib.__version__), PICTURES / "version.svg")
    report = DOCUMENTS / "report.md"
    write_page(with_rules(with_columns(read_page(report))), report)
    recordings = DOCUMENTS / "recordings.md"
    write_page(with_evidence(read_page(recordings)), recordings)
    lesson = DOCUMENTS / "lesson.md"
    write_text(with_verdicts(lesson.read_text(), first_screen(RESULTS_FOLDER / LESSON)), lesson)
    write_screens(DOCUMENTS / "gallery.md", GALLERY, lambda told: states(told.cards))
    write_screens(DOCUMENTS / "bad_report.md", BAD, lambda told: f"{cards(told)}\n\n{steps(told)}")
    if not given.quick:
        photograph(RESULTS_FOLDER / LESSON / "report.html", PICTURES / "lesson_report.png", SCREEN)
        led = RESULTS_FOLDER / "ur5e-demonstrations" / "report.html"
        if led.exists():  # the recordings have no licence: only the cards are shown
            photograph(led, PICTURES / "bad_report.png", CARDS)


def draw_pictures() -> None:
    """Draw the pictures of all studies that are built, and those of tables in pages."""
    for name, figure in FIGURES.items():
        if (drawn := RESULTS_FOLDER / f"{figure}.svg").exists():
            shutil.copy(drawn, PICTURES / f"{name}.svg")
    for name, (study, drawing) in DRAWN.items():
        if (RESULTS_FOLDER / study / "results.json").exists():
            draw(drawing(RESULTS_FOLDER / study), name)
    for name, (page, of_table) in OF_PAGES.items():
        draw(of_table(DOCUMENTS / f"{page}.md"), name)


def draw(drawing: Drawing, name: str) -> None:
    """Write a picture of the documents, without its numbers."""
    with TemporaryDirectory() as folder:
        save(drawing, Path(folder) / f"{name}.svg")
        shutil.copy(Path(folder) / f"{name}.svg", PICTURES)


def write_screens(
    page: Path, studies: dict[str, str], text_of: Callable[[FirstScreen], str]
) -> None:
    """Write the reports of built studies' first screens into the sections of a page."""
    text = page.read_text()
    for title, study in studies.items():
        if (RESULTS_FOLDER / study / "results.json").exists():
            text = replaced(text, title, text_of(first_screen(RESULTS_FOLDER / study)))
    write_text(f"{text.rstrip()}\n", page)


def with_columns(page: str) -> str:
    """Return the report's page with the columns of each table, and what their class says."""
    rows = [[name, ", ".join(own), said] for name, (own, said) in sorted(declared().items())]
    return replaced(page, "Columns of the tables", markdown(["table", "columns", "means"], rows))


def declared() -> dict[str, tuple[list[str], str]]:
    """Return the columns of each table, and the rest of its class's docstring: the recording or
    arm, or … if its step names the owner, and the fields of the class with the docstring `A row of
    <table>.csv`.
    """
    owners = dict.fromkeys(OF_RECORDINGS | OF_MOTION, "recording") | dict.fromkeys(OF_ARMS, "robot")
    found = {}
    for path in sorted(LIBRARY.rglob("*.py")):
        if "A row of" not in path.read_text():
            continue
        module = import_module(".".join(path.relative_to(LIBRARY.parent).with_suffix("").parts))
        for kind in filter(is_dataclass, vars(module).values()):
            if told := re.match(r"A row of (\w+)\.csv[:.](.*)", kind.__doc__ or "", re.DOTALL):
                names = [field.name for field in fields(kind)]
                found[told[1]] = [owners.get(told[1], "…"), *names], " ".join(told[2].split())
    return found


def first_screen(folder: Path) -> FirstScreen:
    """Return the first screen of a built study's report."""
    results = read_results(folder)
    found = page_data(results)
    with handed_over(results, found) as root:
        every = [card(own, results) for own in said(root, "<card>")]
    following = [[own["sentence"], typed(own["command"])] for own in found["found"]["next"]]
    return FirstScreen(every, following)


def typed(command: str) -> str:
    """Return a command as code in Markdown, empty if there is none."""
    return f"`{command}`" if command else ""


def read_results(folder: Path) -> Results:
    """Read the results of a built study."""
    arms = [files.read_file(Robot, path) for path in folder.glob("parameters/*/described.yaml")]
    rows, figures = folder.glob("tables/*.csv"), (folder / "figures").rglob("*.svg")
    study = (folder / "configuration.yaml").read_text(encoding="utf-8")
    return Results.read(study, sorted(rows), sorted(figures), arms)


def card(own: dict[str, Any], results: Results) -> Card:
    """Return a card with its reason; own: the card's data on the page."""
    rows = results.tables["verdicts"].query("question == @own['question']")
    first = rows[rows["rank"] == rows["rank"].min()]
    deciding = first[first["arm"].isna() if own["arm"] is None else first["arm"] == own["arm"]]
    number = "" if own["number"] == "–" else f"{own['number']} {own['unit'] or ''}".strip()
    # a card of measured numbers alone is judged by none
    why = "" if deciding.empty else reason_in_words(deciding["reason"].iloc[0], results.effort)
    state = state_in_words(own["state"], own["question"]) if own["state"] else ""
    return Card(own["title"], state, number.replace("\u00a0", " "), why)


def states(cards: list[Card]) -> str:
    """Return a table of the states that cards have, with their titles."""
    titles = {
        one: [own.title for own in cards if own.state == one]
        for one in (*STATES.values(), NO_DOUBT)
    }
    rows = [[state, ", ".join(having)] for state, having in titles.items() if having]
    return markdown(["state", "cards"], rows)


def with_verdicts(page: str, told: FirstScreen) -> str:
    """Return the lesson with the cards and the next steps of a report."""
    title = "Read the first screen"
    following = section(page, title).partition("\n\nSo a report")[2].partition("| next |")[0]
    return replaced(page, title, f"{cards(told)}\n\nSo a report{following}{steps(told)}")


def cards(told: FirstScreen) -> str:
    """Return a table of all cards."""
    return markdown(["card", "state", "number", "why"], told.cards)


def steps(told: FirstScreen) -> str:
    """Return a table of the next steps."""
    return markdown(["next", "command"], told.steps)


def photograph(report: Path, picture: Path, height: int) -> None:
    """Write the top of a report as PNG; height: [pixels]. Raises InputError without Chromium."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        raise InputError("Chromium is not installed, which photographs the report; install it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": height})
        page.goto(report.absolute().as_uri())
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main()
