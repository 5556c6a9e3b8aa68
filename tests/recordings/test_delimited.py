"""Delimited tables: damage is located, whatever the size of the blocks."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import time_limit
from tests.conftest import said
from ur5lib.recordings import text_blocks
from ur5lib.recordings.delimited import TextTable, read_numbers
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log


def both_lines(path: Path) -> tuple[list[str], list[str]]:
    """The cells of a table's first line, and of the line under it."""
    table = TextTable(Log(path, "robot", []))
    return table.cells, table.below


@pytest.mark.parametrize("size", [1 << 7, 1 << 9, 1 << 25])
def test_damaged_lines_are_numbered_through_all_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", size)
    monkeypatch.setattr(text_blocks, "MIN_BLOCK_BYTES", 16)
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


@pytest.mark.parametrize(("cells", "header"), [(1, True), (2, True), (3, False)])
def test_lines_above_a_header_have_less_than_half_its_cells(
    tmp_path: Path, cells: int, header: bool
) -> None:
    path, names = tmp_path / "some.csv", ["time", *"abcde"]
    lines = ["Some arm", ",".join(["5"] * cells), ",".join(names), *[",".join("123456")] * 9]
    path.write_text("\n".join(lines))
    assert (both_lines(path)[0] == names) is header


# Text files in blocks of whole lines


def blocks(path: Path, content: bytes) -> tuple[list[bytes], list[Finding]]:
    path.write_bytes(content)
    findings: list[Finding] = []
    return [*text_blocks.text_blocks(Log(path, "robot", findings))], findings


@pytest.mark.parametrize(("size", "count"), [(2 << 20, 3), (5 << 20, 1), (8 << 20, 1)])
@pytest.mark.parametrize("end", [b"\n", b""])
def test_blocks_of_whole_lines_are_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int, count: int, end: bytes
) -> None:
    """Of 5.6 MiB; a rest of less than one joins the block before it."""
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", size)
    content = b"\n".join(b"%d,0.25" % number for number in range(500_000)) + end
    found, _ = blocks(tmp_path / "long.csv", content)
    assert b"".join(found) == content
    assert len(found) == count
    assert all(block.endswith(b"\n") for block in found[:-1])


LISTS = {  # a row's lists as they are printed; what separates the cells
    "as NumPy": ("[0.5 -1.5e-3  2. ]", ","),
    "as NumPy, on two lines": ('"[ 0.5 -1.5e-3\n  2.]"', ","),
    "as an array": ('"array([0.5, -1.5e-3, 2.0])"', ","),
    "as Python": ('"[0.5, -0.0015, 2]"', ","),
    "as Python, without quotes": ("[0.5, -0.0015, 2]", ","),
    "as a tuple": ('"(0.5, -0.0015, 2)"', ","),
    "between semicolons": ("[0.5, -0.0015, 2]", ";"),
    "between tabs": ("[0.5, -0.0015, 2]", "\t"),
}


SIZES = {
    kind: [1 << 25] if "\n" in cell else [1 << 9, 1 << 25] for kind, (cell, _) in LISTS.items()
}


@pytest.mark.parametrize(("kind", "size"), [(kind, size) for kind in LISTS for size in SIZES[kind]])
@pytest.mark.parametrize("has_names", [True, False])
def test_lists_in_cells_are_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, has_names: bool, size: int
) -> None:
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", size)
    monkeypatch.setattr(text_blocks, "MIN_BLOCK_BYTES", 16)
    cell, mark = LISTS[kind]
    head = mark.join(["time", "q", "qd[0]"]) + "\n" if has_names else ""
    rows = [mark.join([f"{0.1 * k:.1f}", cell, f"[{k}]"]) for k in range(60)]
    path = tmp_path / "some.csv"
    path.write_text(head + "\n".join(rows) + "\n")
    expected = ["time", "q_0", "q_1", "q_2", "qd[0]"]
    if has_names:
        assert both_lines(path)[0] == expected
    findings: list[Finding] = []
    table = read_numbers(Log(path, "robot", findings), None if has_names else expected)
    assert [*table] == expected
    assert table.iloc[-1].tolist() == pytest.approx([5.9, 0.5, -0.0015, 2.0, 59.0])
    assert len(table) == 60
    assert [one.code for one in findings] in ([], [Found.DECIMAL_COMMAS])


def test_lists_of_different_lengths_are_damaged_lines(tmp_path: Path) -> None:
    path = tmp_path / "some.csv"
    rows = [f"{k},[0.5 0.25{' 1.0' * (k % 9 == 5)}]" for k in range(60)]
    path.write_text("time,q\n" + "\n".join(rows) + "\n")
    findings: list[Finding] = []
    assert len(read_numbers(Log(path, "robot", findings), None)) == 60 - 7
    assert said(findings[0]).startswith("some.csv, line 7, 16, 25, 34, 43")


WORDS = "[INFO] run (3 axes),0.5\n"


def test_words_in_brackets_are_no_lists(tmp_path: Path) -> None:
    path = tmp_path / "some.csv"
    path.write_text("note,q\n" + WORDS * 9)
    assert both_lines(path) == (["note", "q"], WORDS.strip().split(","))


def test_a_turned_table_may_have_dates(tmp_path: Path) -> None:
    rows = pd.DataFrame(np.random.default_rng(0).normal(size=(6, 2_000)))
    dates = pd.date_range("2026-01-01", periods=2_000, freq="8ms").astype(str)
    path = tmp_path / "some.csv"
    path.write_text("t," + ",".join(dates) + "\n" + rows.to_csv(header=False))
    assert both_lines(path)[0] == ["t", *map(str, range(6))]


def test_a_row_that_begins_with_a_date_has_no_names(tmp_path: Path) -> None:
    path = tmp_path / "some.txt"
    path.write_text("2026-01-01 08:00:00.004;-0,5;1,5\n" * 9)
    assert not TextTable(Log(path, "robot", [])).has_names()


def test_a_nameless_index_stays_where_last_cells_are_empty(tmp_path: Path) -> None:
    path = tmp_path / "some.txt"
    path.write_text(" a b c\n0 1.0 2.0 \n1 1.5 2.5 3.5\n")
    assert both_lines(path)[0] == ["", "a", "b", "c"]


@pytest.mark.parametrize(
    ("numbered", "labelled", "ending", "mark"),
    [(False, False, ".csv", ","), (False, True, ".csv.gz", ";"), (True, True, ".txt", "\t")],
)
def test_a_table_with_a_row_a_joint_is_turned(
    tmp_path: Path, numbered: bool, labelled: bool, ending: str, mark: str
) -> None:
    path, findings = tmp_path / f"some{ending}", list[Finding]()
    rows = pd.DataFrame(np.random.default_rng(0).normal(size=(18, 12_000)))
    names = rows.index = [f"q{k}" for k in range(18)]
    rows.to_csv(path, header=numbered, index=labelled, sep=mark)
    names = [""] * numbered + names if labelled else [f"c{k}" for k in range(18)]
    with time_limit(5):
        table = read_numbers(Log(path, "robot", findings), names)
    assert table.shape == (12_000, 18)
    np.testing.assert_allclose(table.iloc[:, -1], rows.iloc[-1])
    assert Found.TURNED_TABLE in [finding.code for finding in findings]
    assert both_lines(path)[0][-1] == ("q17" if labelled else f"{rows.iloc[-1, 0]!s}")


@pytest.mark.parametrize("mark", [" ", "\t"])
def test_a_blank_or_a_tab_behind_an_index_without_a_name(tmp_path: Path, mark: str) -> None:
    path = tmp_path / "some.txt"
    rows = pd.DataFrame(np.random.default_rng(0).normal(size=(9, 3)), columns=["a", "b", "c"])
    rows.to_csv(path, sep=mark)
    assert both_lines(path)[0] == ["", "a", "b", "c"]
    for names in (None, ["-", "a", "b", "c"]):
        table = read_numbers(Log(path, "robot", []), names)
        np.testing.assert_allclose(table[["a", "b", "c"]], rows)


def test_a_short_table_of_many_channels_is_upright(tmp_path: Path) -> None:
    path = tmp_path / "some.csv"
    names = [f"actual_{k}" for k in range(400)]
    pd.DataFrame(np.ones((3, 400)), columns=names).to_csv(path, index=False)
    assert both_lines(path)[0] == names


def test_an_empty_file_is_one_empty_block(tmp_path: Path) -> None:
    assert blocks(tmp_path / "empty.csv", b"") == ([b""], [])


@pytest.mark.parametrize(
    ("content", "plain", "finding"),
    [
        (gzip.compress(b"1,2\n", mtime=0), b"1,2\n", Found.COMPRESSED_FILE),
        (b"\xef\xbb\xbf1,2\n", b"1,2\n", Found.BYTE_ORDER_MARK),
        (b'"1","2"\r\n3,4\r', b"1,2\n3,4\n", None),
        (b"[1, 2], (3e-1)\n[4, 5], (6)\n", b"1, 2, 3e-1\n4, 5, 6\n", None),
        (b"q[0],q(1)\n1,2\n", b"q[0],q(1)\n1,2\n", None),  # names
        (b"(1),2\n[3],4\n", b"(1),2\n[3],4\n", None),
    ],
)
def test_text_is_plain(tmp_path: Path, content: bytes, plain: bytes, finding: str | None) -> None:
    found, findings = blocks(tmp_path / "some.csv", content)
    assert found == [plain]
    assert [(one.code, one.severity, one.count) for one in findings] == (
        [(finding, "note", 1)] if finding else []
    )


ROW = ",".join(["{0}", *["0.25"] * 6])
NAMES = "time,a,b,c,d,e,f"


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("Robot,UR5e\nSerial,20205500123\n\n" + NAMES, ROW),
        (NAMES, ROW + ","),
        ("LabVIEW\t\n" + NAMES.replace(",", "\t"), ROW.replace(",", "\t").replace(".", ",")),
        ("# of a lab\n# " + NAMES, ROW),
        (NAMES, ",".join(['"{0}"', *['"0,25"'] * 6])),
        (NAMES + ",mode", ROW + ",RUNNING"),
        ('time,"a","b",c,d,e,f,joints', ROW + ",\"['elbow', 'base']\""),
    ],
)
def test_what_loggers_write_around_numbers(tmp_path: Path, head: str, row: str) -> None:
    path = tmp_path / "some.csv"
    path.write_text("\n".join([head, *(row.format(k) for k in range(40))]) + "\n")
    table = read_numbers(Log(path, "robot", []), None)
    assert [*table] == NAMES.split(",")
    assert table["time"].tolist() == [*range(40)]
    assert (table[["a", "f"]] == 0.25).all(axis=None)


@pytest.mark.parametrize(
    ("mark", "names"),
    [
        (" ", ["Joint_1_Position", "Joint_2_Position"]),
        (",", ["Joint 1 Position", "Joint 2 Position"]),
    ],
)
def test_a_quoted_name_of_several_words_is_one_name(
    tmp_path: Path, mark: str, names: list[str]
) -> None:
    path = tmp_path / "some.csv"
    head = mark.join(["time", '"Joint 1 Position"', '"Joint 2 Position"'])
    path.write_text(
        "\n".join([head, *(mark.join([f"{k}", "0.25", "0.5"]) for k in range(9))]) + "\n"
    )
    table = read_numbers(Log(path, "robot", []), None)
    assert [*table] == ["time", *names]
    assert table["time"].tolist() == [*range(9)]
