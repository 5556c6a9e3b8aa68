"""Delimited tables: damage is located, whatever the size of the blocks."""

from pathlib import Path

import pytest

from tests.conftest import said
from ur5lib.errors import InputError
from ur5lib.recordings import text_blocks
from ur5lib.recordings.delimited import read_numbers
from ur5lib.recordings.quality import Finding, Log


@pytest.mark.parametrize("size", [1 << 7, 1 << 9, 1 << 25])
def test_damaged_lines_are_numbered_through_all_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    monkeypatch.setattr(text_blocks, "SIZE", size)
    monkeypatch.setattr(text_blocks, "SHORT", 16)
    lines = [f"{number},0.25" for number in range(1, 301)]
    for number in (20, 150, 290):
        lines[number - 1] = f"{number}"
    path = tmp_path / "some.csv"
    path.write_text("\n".join(lines) + "\n")
    findings: list[Finding] = []
    table = read_numbers(Log(path, "robot", findings), ["time", "value"])
    assert table["time"].tolist() == [n for n in range(1, 301) if n not in (20, 150, 290)]
    (finding,) = findings
    assert said(finding).startswith("some.csv, line 20, 150, 290 (it has 1 cells)")
    assert finding.count == 3


def test_blank_lines_above_a_table_count(tmp_path: Path) -> None:
    path = tmp_path / "some.csv"
    path.write_text("\n1,2\n3\n5,6\n")
    findings: list[Finding] = []
    read_numbers(Log(path, "robot", findings), ["time", "value"])
    assert said(findings[0]).startswith("some.csv, line 3 (")


def test_a_name_that_appears_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "some.csv"
    path.write_text("time,q,q\n1,2,3\n")
    with pytest.raises(InputError, match="column 'q' appears twice"):
        read_numbers(Log(path, "robot", []), None)


@pytest.mark.parametrize(("other", "whole"), [(5, True), (25, False)])
def test_a_last_line_without_end_is_whole_if_it_is_like_the_twenty_before_it(
    tmp_path: Path, other: int, whole: bool
) -> None:
    """Of thirty lines, one has fewer decimals."""
    lines = [f"{number},0.25" for number in range(1, 31)]
    lines[other - 1] = f"{other},0.5"
    path = tmp_path / "some.csv"
    path.write_text("\n".join(lines))
    findings: list[Finding] = []
    assert len(read_numbers(Log(path, "robot", findings), ["time", "value"])) == 29 + whole
    assert [one.finding for one in findings] == ([] if whole else ["torn last line"])
