"""The audit of a wrist's sensor: verdicts on its values, in the report and by `ur5 audit`."""

from dataclasses import replace
from pathlib import Path

from tests.made_study import study
from tests.topics.pages import section, shown
from ur5lib.report.results import Results
from ur5lib.tables import read_csv, write_rows
from ur5lib.topics.audit.audit_sensor import row
from ur5lib.topics.audit.command import audit_answers
from ur5lib.topics.audit.report import is_to_declare
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


def turned_sensor(folder: Path) -> Results:
    """A sensor whose axes are turned by 8.7°, with a mass and a centre that nobody declared."""
    turned = [row("turn", axis, 5.0, 0.1, "°", 0.0, 2.0) for axis in "xyz"]
    mass = row("mass", "", 1.0, 0.01, "kg", 1.2, 0.1)
    center = [row("center_of_mass", axis, 0.02, 0.001, "m", 0.0, 0.01) for axis in "xyz"]
    return results(FREE, *turned, mass, *center, folder=folder)


def test_its_section_says_what_is_wrong_and_what_to_type(tmp_path: Path) -> None:
    found = turned_sensor(tmp_path)
    told = section("audit", found)
    assert "Wrong on R3 pushed: turn of the axes, mass on the sensor and its centre of" in told.text
    assert "On R3 pushed, the axes are turned by 8.7° against frame 6" in told.text
    assert "override: {mounting: {force_sensor_turn_deg: [5.0, 5.0, 5.0]}}" in told.text
    assert "set_payload(1.000, [0.020, 0.020, 0.020])" in told.text
    verdicts = told.tables["wrist-sensor"]
    assert [row["verdict"] for row in verdicts] == ["wrong"] * 3
    assert verdicts[1]["x, or mass"] == "1.000 ± 0.020"
    assert verdicts[1]["should be"] == "1.2"
    every = section("audit", found, "details").tables["wrist-sensor-values"]
    assert len(every) == 7
    assert every[0]["95 %"] == "4.80 to 5.20"
    assert len(section("audit", found, "run").tables["wrist-sensor-values"]) == 7


def test_too_little_time_without_contact_is_told(tmp_path: Path) -> None:
    told = section("audit", results(replace(FREE, value=3.2), folder=tmp_path))
    assert "On R3 pushed, at most 3.2 s without contact" in told.text
    assert "Record ten or more in which nothing touches the tool" in told.text


def test_what_is_typed_has_no_minus_that_only_print_has(tmp_path: Path) -> None:
    turned = [row("turn", axis, -5.0, 0.1, "°", 0.0, 2.0) for axis in "xyz"]
    told = section("audit", results(FREE, *turned, folder=tmp_path)).text
    assert "force_sensor_turn_deg: [-5.0, -5.0, -5.0]" in told


def test_its_section_is_absent_without_one(tmp_path: Path) -> None:
    none = results(folder=tmp_path)
    tables = {name: own for name, own in none.tables.items() if name != "audit"}
    for page in ("report", "details", "run"):
        assert shown("audit", none, page) is None
        assert shown("audit", replace(none, tables=tables), page) is None


def test_the_command_says_the_same_in_sentences(tmp_path: Path) -> None:
    rows = turned_sensor(tmp_path).tables["audit"]
    name, *told = audit_answers(rows)
    assert name == "pushed:"
    assert any("its axes are turned by 8.7°" in one for one in told)
    assert any("force_sensor_turn_deg: [5.0, 5.0, 5.0]" in one for one in told)
    assert (
        "  the sensor carries 1.00 ± 0.02 kg; 1.2 kg are declared: "
        "set_payload(1.000, [0.020, 0.020, 0.020])"
    ) in told
    scaled = rows.assign(quantity=rows["quantity"].replace("turn", "scale"))
    assert not is_to_declare(dict([*scaled.assign(verdict="right").groupby("quantity")]))
    (_, short) = audit_answers(results(replace(FREE, value=3.2), folder=tmp_path).tables["audit"])
    assert "3.2 s without contact" in short
