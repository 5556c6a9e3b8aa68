"""Findings about recordings, as files hold them."""

from pathlib import Path

from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Finding, Log, Quality, contradiction
from ur5lib.tables import read_record, write_json

SIGN = contradiction(CauseCode.EXCHANGED_JOINTS, "order", "joints 2 and 3 are exchanged", [2, 3])
SATURATED = Finding("force", Found.SATURATION, "warning", 9, "ft_fx stays", channels=("ft_fx",))


def test_findings_come_back(tmp_path: Path) -> None:
    quality, path = Quality(findings=[SIGN, SATURATED]), tmp_path / "quality.json"
    write_json(quality, path)
    read = read_record(Quality, path)
    assert read.findings == quality.findings
    assert read.saturated_channels() == ["ft_fx"]


def test_a_finding_about_a_file_begins_with_its_place() -> None:
    log = Log(Path("raw/a.csv"), "robot", [])
    log.add(Found.TORN_LAST_LINE, "note", 1, "skipped", "7")
    log.add(Found.MISSING_TIMES, "warning", 3, "rows without a time are discarded")
    log.add(Found.MISSING_TIMES, "warning", 0, "none")
    assert [one.place for one in log.findings] == ["a.csv, line 7", "a.csv"]
    assert [one.detail for one in log.findings] == [
        "a.csv, line 7: skipped",
        "a.csv: rows without a time are discarded",
    ]
