"""The page on bad reports says what a report says; `make pictures` writes it anew."""

import shutil
from pathlib import Path

import pytest

from benchmarks.pictures import cards, first_screen, steps
from tests.conftest import PROJECT, build_once, shared_folder

STUDY = "ur5e-demonstrations"


@pytest.mark.thorough
def test_its_cards_and_steps_are_those_of_the_report(common_folder: Path) -> None:
    raw = shared_folder("ur5e", f"`ur5 fetch {STUDY}` fetches them")

    def prepare(folder: Path) -> None:
        shutil.copytree(raw, folder / "raw" / STUDY)

    options = "--configfile", f"workflow/studies/{STUDY}.yaml"
    workflow = build_once(common_folder / STUDY, prepare, *options)
    told = first_screen(workflow.folder / "results" / STUDY)
    page = (PROJECT / "docs" / "bad_report.md").read_text()
    assert f"{cards(told)}\n\n{steps(told)}" in page
