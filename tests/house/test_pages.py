"""One thing has one value: numbers in prose are cells of docs/data, and tables agree."""

import csv
import re

import pytest

from benchmarks.harness.cells import CELL, DATA, cell, with_cells
from benchmarks.pages import PAGES, PARTS, STAMPS
from tests.conftest import PROJECT


def test_each_marked_number_is_that_of_its_cell() -> None:
    texts = {page.name: page.read_text(encoding="utf-8") for page in PAGES}
    assert all(CELL.search(texts[name]) for name in ("live.md", "paper.md"))
    assert [name for name, text in texts.items() if with_cells(text) != text] == []


def test_another_number_is_replaced_and_a_lost_cell_told() -> None:
    live = (PROJECT / "docs" / "live.md").read_text(encoding="utf-8")
    marked = CELL.search(live)
    assert marked
    other = live.replace(marked[0], marked[0].replace(marked[1], "99.9", 1))
    assert other != live
    assert with_cells(other) == live
    with pytest.raises(ValueError, match="0 rows 'nobody'"):
        with_cells("1.0<!-- leaderboard: nobody | latency -->")


def test_every_command_that_writes_a_page_is_a_part() -> None:
    texts = {path.stem: path.read_text() for path in (PROJECT / "benchmarks").glob("*.py")}
    writers = {name for name, text in texts.items() if '"--page"' in text}
    commands = [part.command.split() for part in PARTS.values()]
    assert writers == {
        words[0].removeprefix("benchmarks.") for words in commands if "--page" in words
    }


def test_stamps_are_of_parts() -> None:
    with STAMPS.open(encoding="utf-8", newline="") as lines:
        rows = [*csv.DictReader(lines)]
    for row in rows:
        assert row["command"] == f"python -m {PARTS[row['part']].command}"
        assert re.fullmatch(r"[0-9a-f]{8}( \+ changes)?", row["commit"])


def test_found_contacts_are_as_many_on_both_pages() -> None:
    with (DATA / "contacts_found.csv").open(encoding="utf-8", newline="") as lines:
        own = [row["≥ 5 N"] for row in csv.DictReader(lines) if row["estimate"] == "F̂ᵐᵃᵖ"]
    found, whole = (sum(int(one.split(" of ")[end]) for one in own) for end in (0, 1))
    expected = cell(
        DATA / "what_to_expect.csv", "ur5, currents", "contacts of 5 N found; none missed from"
    )
    assert expected.startswith(f"{found} of {whole}, ")
