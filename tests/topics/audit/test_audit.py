"""The audit of a wrist's sensor: verdicts on its values, in the report and by `ur5 audit`."""

from dataclasses import replace
from pathlib import Path

from tests.made_study import study
from tests.topics.pages import shown
from ur5lib.report.results import Results
from ur5lib.tables import read_csv, write_rows
from ur5lib.topics.audit import report
from ur5lib.topics.audit.audit_sensor import row
from ur5lib.topics.audit.rows import AuditRow

FREE = AuditRow("free_time", "", 20.0, None, None, None, "s", None, "")


def test_a_verdict_needs_an_interval_narrower_than_what_matters() -> None:
    told = {row("scale", "x", v, s, "1", 1.0, 0.05).verdict for v, s in [(1.01, 0.1)]}
    assert told == {"unknown"}
    assert row("scale", "x", 1.2, 0.01, "1", 1.0, 0.05).verdict == "wrong"
    assert row("scale", "x", 1.02, 0.01, "1", 1.0, 0.05).verdict == "right"
    assert row("scale", "x", 1.2, 0.2, "1", 1.0, 0.05).verdict == "unknown"
    assert row("bias", "Fx", 5.0, 0.1, "N", None, None).verdict == ""


def results(*rows: AuditRow, folder: Path) -> Results:
    """A study of one recording with these rows."""
    write_rows(AuditRow, rows, folder / "audit.csv")
    table = read_csv(folder / "audit.csv").assign(recording="pushed")
    made = study()
    return replace(made, tables={**made.tables, "audit": table})


def test_its_section_is_filled_where_a_wrist_has_a_sensor(tmp_path: Path) -> None:
    turned = [row("turn", axis, 5.0, 0.1, "°", 0.0, 2.0) for axis in "xyz"]
    mass = row("mass", "", 1.0, 0.01, "kg", 1.2, 0.1)
    center = [row("center_of_mass", axis, 0.0, 0.001, "m", 0.0, 0.01) for axis in "xyz"]
    found = results(FREE, *turned, mass, *center, folder=tmp_path)
    assert shown("audit", found) == ["Heading", "Items", "Heading", "TableBlock"]
    wrong = " ".join(report.findings(found))
    assert "pushed" in wrong
    assert wrong.count("wrong") == 2
    assert any("turned by 8.7°" in one for one in report.sentences(found, "pushed"))


def test_its_section_is_empty_without_one(tmp_path: Path) -> None:
    none = results(folder=tmp_path)
    assert shown("audit", none) == [*report.findings(none)] == []
    tables = {name: own for name, own in none.tables.items() if name != "audit"}
    assert shown("audit", replace(none, tables=tables)) == []
