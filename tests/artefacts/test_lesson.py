"""The lesson says and draws what its study says and draws; `make pictures` writes both anew."""

import re
import shutil
from pathlib import Path

import pytest

from benchmarks.pictures import FIGURES, LESSON, first_screen, with_verdicts
from tests.conftest import PROJECT, build_once, shared_folder
from tests.drawn_numbers import check_drawn_numbers
from tests.in_memory import assert_draws_as_in_report

DOCUMENTS = PROJECT / "docs"
LABEL = re.compile(r"<!-- (?![\d−.]+ -->)(.*?) -->")  # of an axis or a line, not a number
PICTURES = {name: path for name, path in FIGURES.items() if path.startswith(LESSON)}

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(common_folder: Path) -> Path:
    bag = shared_folder(LESSON, f"`ur5 fetch {LESSON}` fetches them")
    workflow = build_once(
        common_folder / LESSON,
        lambda folder: shutil.copytree(bag, folder / "raw" / LESSON),
        "--configfile",
        f"workflow/studies/{LESSON}.yaml",
    )
    return workflow.folder / "results"


def test_its_cards_are_those_of_the_report(results: Path) -> None:
    page = (DOCUMENTS / "lesson.md").read_text()
    assert with_verdicts(page, first_screen(results / LESSON)) == page


@pytest.mark.thorough
def test_its_model_draws_what_the_report_shows(results: Path, tmp_path: Path) -> None:
    assert_draws_as_in_report(results / LESSON, tmp_path)


@pytest.mark.thorough
def test_its_figures_draw_what_their_tables_state(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = check_drawn_numbers(results / LESSON, monkeypatch)
    assert {*compared} == {"currents", "friction"}


@pytest.mark.parametrize("name", PICTURES)
def test_its_pictures_show_what_the_report_draws(results: Path, name: str) -> None:
    drawn = (results / f"{FIGURES[name]}.svg").read_text()
    shown = (DOCUMENTS / "pictures" / f"{name}.svg").read_text()
    assert {*LABEL.findall(shown)} == {*LABEL.findall(drawn)}
