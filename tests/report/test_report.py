"""The report: one content, two documents, safe from what stands in the data."""

import math
import re
import zipfile
from dataclasses import asdict
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest
from lxml import etree
from lxml.html import fromstring

from tests.artefacts.documents import check_digits, stated
from tests.made_tables import empty, table
from ur5lib.errors import remark
from ur5lib.records.dynamics import Torques
from ur5lib.records.signals import Signals
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.traces import TORQUE_PANELS, Traces, draw_traces
from ur5lib.report.page.compose import shown_table
from ur5lib.report.page.document import (
    Cell,
    Code,
    Document,
    Heading,
    Items,
    Mention,
    Paragraph,
    Picture,
    Section,
    TableBlock,
)
from ur5lib.report.page.render import html_page, pdf_document
from ur5lib.report.page.sentences import cell
from ur5lib.report.page.tabulated import extremes
from ur5lib.report.results import Results
from ur5lib.report.views.contacts import (
    counted,
    elsewhere,
    undetermined_moments,
)
from ur5lib.report.views.currents import loaded, remarks
from ur5lib.report.views.first_screen import _each, left_out_fits
from ur5lib.steps.write_report import archived
from ur5lib.tables import write_bytes, write_text
from ur5lib.tidy import forces, friction, models

HOSTILE = '<script>alert("x")</script> & #set page(width: 1mm) $x$ *y* \\ `z` {{ 7 * 7 }}'


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    time = np.linspace(0, 1, 50)
    values = np.outer(np.sin(time), np.ones(6))
    series = {"a": (values, "measured"), "b": (2 * values, "joint")}
    save(draw_traces(Traces(time, series), TORQUE_PANELS), tmp_path / "figure.svg")
    return tmp_path / "figure.svg"


@pytest.fixture
def document(picture: Path) -> Document:
    rows = [[Cell(HOSTILE), Cell("0.5", "lowest")]]
    blocks = [
        Paragraph([HOSTILE, Mention("later")]),
        Heading(HOSTILE),
        Items([HOSTILE], numbered=True),
        TableBlock(HOSTILE, ["joint", "mae"], rows, "first"),
        Picture(HOSTILE, picture, HOSTILE, "picture", "figures/a.csv", "draw_figures"),
        TableBlock(HOSTILE, ["joint", "mae"], rows, "later", "tables/a.csv"),
        Code(HOSTILE),
    ]
    return Document(HOSTILE, HOSTILE, [Section(HOSTILE, blocks)], HOSTILE).numbered()


def test_tables_and_figures_are_counted_and_mentioned_by_their_number(document: Document) -> None:
    first, *blocks = document.blocks()
    assert isinstance(first, Paragraph)
    assert first.spans[1] == Mention("later", "Table 2")
    assert [block.number for block in blocks if isinstance(block, TableBlock | Picture)] == [
        1,
        1,
        2,
    ]


def test_a_mention_of_nothing_is_an_error() -> None:
    lost = Document("", "", [Section("", [Paragraph([Mention("lost")])])])
    with pytest.raises(KeyError, match="lost"):
        lost.numbered()


def test_html_shows_text_from_outside_as_text(document: Document, tmp_path: Path) -> None:
    write_text(html_page(document), tmp_path / "report.html")
    page = fromstring((tmp_path / "report.html").read_text())
    scripts = [element.attrib for element in page.iter("script")]
    assert scripts == [{"type": "text/plain"}, {}, {}]  # the figure's lines, uPlot, what uses it
    # title, notice, 3 headings, subtitle, 2 contents, paragraph, item, 3 captions, 2 cells, code
    assert page.text_content().count(HOSTILE) == 16
    (image,) = page.iter("img")
    assert image.get("alt") == HOSTILE
    assert image.get("src").startswith("data:image/svg+xml,<?xml")
    assert "▼ 0.5" in page.text_content()  # a mark is more than a colour


def test_a_figure_in_the_page_is_its_file_without_what_nobody_sees(
    document: Document, picture: Path
) -> None:
    """Smaller, with all drawn parts, and what these refer to."""
    (image,) = fromstring(html_page(document)).iter("img")
    shown = etree.fromstring(unquote(image.get("src").split(",", 1)[1]).encode())
    file = etree.parse(picture).getroot()
    drawn = [[*one.iter("{*}path", "{*}use", "{*}image")] for one in (file, shown)]
    assert len(drawn[0]) == len(drawn[1]) > 10
    text = etree.tostring(shown).decode()
    assert len(text) < 0.9 * picture.stat().st_size
    names = {one.get("id") for one in shown.iter("{*}*")}
    assert {*re.findall(r"(?:url\(|href=\")#([\w-]+)", text)} <= names


def test_no_line_breaks_within_a_number() -> None:
    words = "10.3 ± 0.7 Nm, 4 % of 3 A"
    rows = [[Cell("joint 1"), Cell("8.19 ± 0.60 (prior)")]]
    blocks = [Paragraph([words]), Items([words]), TableBlock("", ["joint", "k"], rows), Code(words)]
    page = fromstring(html_page(Document("t", "", [Section("First", blocks)])))
    check_digits(one.text_content() for one in page.iter("p", "li", "td"))
    assert words in page.text_content()  # as typed, to be copied


def test_pdf_is_made_from_text_from_outside(document: Document, tmp_path: Path) -> None:
    write_bytes(pdf_document(document), tmp_path / "report.pdf")
    pdf = (tmp_path / "report.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    write_bytes(pdf_document(document), tmp_path / "again.pdf")
    assert (tmp_path / "again.pdf").read_bytes() == pdf


def test_extremes_are_marked_where_values_differ() -> None:
    low, middle, high = ("A",), ("B",), ("C",)
    marks = {low: "lowest", middle: None, high: "highest"}
    values = {low: (1.0, "1.0"), middle: (2.0, "2.0"), high: (3.0, "3.0")}
    assert extremes(values) == extremes(values, zero=1.1) == marks
    assert extremes(values, zero=0.9) == marks | {low: None}
    assert extremes({low: (1.0, "1.0"), middle: (1.01, "1.0")}) == {low: None, middle: None}
    assert extremes(values | {middle: (1.01, "1.0")}) == marks | {low: None}


@pytest.mark.parametrize(
    ("template", "value", "text"),
    [
        ("value | fixed(3)", 1.23456, "1.235"),
        ("value | fixed(1)", -1.5, "−1.5"),
        ("value | fixed(3)", math.nan, "–"),
        ("value | with_error(value)", math.nan, "–"),
        ("value | signed(1, ' %')", -0.5, "−0.5 %"),
        ("value | signed(2)", 0.5, "+0.50"),
        ("value | signed(1)", -0.04, "0.0"),
        ("{{ value }} of 2", 1, "1 of 2"),
        ("value if value is known else none", math.nan, None),
        ("value | significant(2)", 46771.7, "47000"),
        ("value | significant(2)", 99.6, "100"),
        ("value | significant(2)", 0.00134, "0.0013"),
        ("value | joints", [2], "joint 2"),
        ("value | joints", [4, 5], "joints 4, 5"),
        ("value | joints", [1, 2, 3, 4, 5, 6], "joints 1 to 6"),
    ],
)
def test_cells_show_sign_absence_and_no_exponent(template: str, value: Any, text: str) -> None:
    assert cell(template, {"value": value}) == text


def test_columns_of_numbers_stand_right() -> None:
    rows = [[Cell("Fx [N]"), Cell("−1.5"), Cell("–")], [Cell("Fy [N]"), Cell("2"), Cell("3 %")]]
    assert TableBlock("", ["", "", ""], rows).alignment() == ["left", "right", "right"]


# Tables of results


def torque_tables() -> tuple[Signals, Torques]:
    """Target moments of 1 Nm; Model A is right, Model B 0.5 Nm too high; one invented frame."""
    ones = np.ones((10, 6))
    off = {"A": ones, "B": ones + 0.5}
    moment = ones.copy()
    moment[3] = 99.0
    grid = {"time": 0.008 * np.arange(10), "segment": np.zeros(10, np.int64)}
    flags = grid | {"interpolated": np.arange(10) == 3}
    return (
        Signals(**flags, actual_q=ones, target_moment=moment),
        Torques(**flags, target=off, measured=off, payload_torque=0 * ones),
    )


def torque_errors() -> pd.DataFrame:
    return table(models.torque_mae, {"run": torque_tables()})


def test_torque_errors_leave_out_invented_frames() -> None:
    rows = torque_errors()
    mae = rows.groupby("model")["mae"]
    assert mae.max().to_dict() == {"A": 0.0, "B": 0.5}
    assert rows["zero_mae"].eq(1.0).all()


def shown(name: str, results: Results, of: str = "") -> list[dict[str, str]]:
    """The lines of a table of the report: the text of each cell by its header."""
    header, rows = shown_table(name, results, of)
    return [dict(zip(header, (cell.text for cell in row), strict=True)) for row in rows]


# Contacts


def searched(name: str, contacts: pd.DataFrame) -> Results:
    """One contact recording without a force sensor, and the contacts found on it."""
    tables = {
        "contacts": contacts,
        "force_mae": pd.DataFrame({"recording": []}),
        "detection": pd.DataFrame([{"recording": name, "estimate": "Fmap"}]),
    }
    return Results({"recordings": [{"name": name, "role": "contact"}]}, tables, Path())


def contact_rows(name: str, alarms: list) -> pd.DataFrame:
    return table(forces.contacts, {name: {"Fmap": {"raised": alarms}}})


def test_a_recording_without_contacts_is_told_too() -> None:
    results = searched("quiet", empty("contacts"))
    (told,) = counted(results)
    assert "quiet" in told
    assert stated(told) == []


def alarm(start: float, force: list[float], **more: Any) -> dict[str, Any]:
    """An alarm of 1 s, its largest force in the middle."""
    times = {"start": start, "end": start + 1, "peak": start + 0.5}
    return times | {"force": force, "force_std": [1, 2, 3], "q": [0.0, 1.0]} | more


def test_contacts_without_a_sensor_are_told_with_their_force() -> None:
    rows = contact_rows("pushed", [alarm(1.0, [3.0, 0.0, -4.04]), alarm(7.0, [1.0, 0.0, 0.0])])
    results = searched("pushed", rows)
    assert [*map(stated, counted(results))] == [[2]]
    first, second = shown("contacts", results, "pushed")
    assert [*first.values()][:3] == ["1.00\u00a0to\u00a02.00", "1.50", "3.0 ± 1.0"]
    assert second["Fx [N]"] == "1.0 ± 1.0"


def test_contacts_off_the_flange_are_marked_and_counted() -> None:
    rows = [alarm(float(k), [5.0 + k, 0, 0], off_flange=k == 1) for k in range(2)]
    results = searched("pushed", contact_rows("pushed", rows))
    lines = shown("contacts", results, "pushed")
    assert [line["not at the flange"] for line in lines] == ["–", "×"]
    (told,) = elsewhere(results)
    assert "1 of 2" in told
    assert [*elsewhere(searched("held", contact_rows("held", rows[:1])))] == []


def test_a_load_taken_up_is_no_contact() -> None:
    lifted = {"kind": "load", "load_mass": 2.04, "load_mass_std": 0.05}
    down = [0.0, 0.0, -20.0]
    rows = contact_rows("grasp", [alarm(4.0, down), alarm(4.0, down, **lifted)])
    results = searched("grasp", rows)
    assert [*map(stated, counted(results))] == [[1]]
    taken_up = results.rows("contacts", kind="load")
    assert [*map(stated, _each("findings.load taken up", taken_up))] == [[2.04, 0.05]]
    lines = shown("contacts", results, "grasp")
    assert [line["load [kg]"] for line in lines] == ["–", "2.040 ± 0.050"]


# Forces beside the sensor

WRENCH = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]


def force_summary() -> dict:
    """Errors of 4 N in contact and 0.1 N free; of moments, only nx is told."""

    def figures(mae: float, mean: float, **more: float) -> dict:
        same = {"mae": mae, "zero_mae": mean, "mean_force": mean, "slope": 0.9, "skill": 0.6}
        same |= {"coverage95": 0.9, "interval_score95": 30.0, "zero_interval_score95": 50.0}
        return {name: dict.fromkeys(WRENCH, value) for name, value in (same | more).items()}

    contact = figures(4.0, 10.0, mae_low=3.0, mae_high=5.0, skill_low=0.5)
    contact["skill_low"] |= {"ny": -0.1, "nz": 0.0}
    during = {"all": figures(1.0, 2.5), "contact": contact, "free": figures(0.1, 0.1)}
    kinds = {
        "compensated": {"Fmap": during, "Fu": {"all": figures(9.0, 2.5)}},
        "printed": {"Fu": during},
    }
    return {"errors": kinds}


def force_results() -> Results:
    rows = table(forces.force_mae, {"run": force_summary()})
    study = {"recordings": [{"name": "run", "robot": "ur5"}]}
    return Results(study, {"force_mae": rows}, Path())


def test_what_is_not_certainly_better_than_none_is_undetermined() -> None:
    results = force_results()
    rows = results.rows("force_mae", kind="compensated").set_index("estimate")
    known = rows.loc["Fmap"].groupby("component")["determined"].unique().map(list)
    assert {name for name, told in known.items() if told == ["no"]} == {"ny", "nz"}
    assert rows.loc["Fu", "determined"].isna().all()
    told = {line["component"]: line["F̂ᵐᵃᵖ"] for line in shown("force_mae.summary", results)}
    assert told["ny [Nm]"] == told["nz [Nm]"] == "undetermined"
    assert told["Fx [N]"] == told["nx [Nm]"] == "4.00"
    (undetermined,) = undetermined_moments(results)
    assert "ny, nz" in undetermined


def test_contacts_are_counted_by_their_force() -> None:
    part = {"contacts": 4, "found": 3, "recall": 0.75, "median_delay": 0.1}
    found = {"raised": [], "alarms_per_min": 1.0, "time_in_alarm": 0.5, "extra": 2}
    found |= {"threshold": 8.5}
    found |= {"false_per_min": 0.5, "free_time_in_alarm": 0.25}
    found |= {"classes": [{"force": 3.0, **part}, {"force": 15.0, **part, "found": 4}]}
    late = {"alarms_per_min": 4.0, "false_per_min": 2.0, "unknown": 0.25}
    late |= {"classes": [{"force": 3.0, **part, "found": 1}, {"force": 15.0, **part, "found": 0}]}
    rows = table(forces.detection, {"run": {"Fmap": found | {"causal": late}, "Fu": found}})
    assert rows["causal_found"].tolist()[:2] == [1, 0]
    assert rows["causal_false_alarms_per_min"].tolist()[:2] == [2, 2]
    assert rows["causal_unknown"].tolist()[:2] == [0.25, 0.25]
    assert rows["causal_delay_s"].isna().tolist() == [False, False, True, True]
    assert rows["force_class_n"].tolist() == [3, 15] * 2
    assert rows["extra_alarms"].eq(2).all()
    lines = shown("detection.classes", Results({}, {"detection": rows}, Path()))
    cells = lines[0]
    assert (cells["≥ 3 N"], cells["≥ 15 N"]) == ("3 of 4", "4 of 4")
    assert (cells["delay [s]"], cells["causal"]) == ("0.10", "1 of 4, 0.10 s")
    assert [line["from [N]"] for line in lines] == ["–", "8.5"]  # odds, N


def test_the_fixed_threshold_shows_time_above_and_pushes_found() -> None:
    axes = {"z": {"force": 10.0, "time_above": 0.25, "pushes": 4, "found": 3}}
    free = {"z": {"force": 10.0, "time_above": 0.0}}
    found = {"run": {"F*": {"axes": axes}, "Fmap": {"axes": axes}}, "free": {"F*": {"axes": free}}}
    rows = table(forces.fixed_threshold, found)
    study = {"recordings": [{"name": "run", "role": "contact"}, {"name": "free", "role": "fit"}]}
    results = Results(study, {"fixed_threshold": rows}, Path())
    most = "25 %; 3 of 4"
    assert shown("fixed_threshold", results) == [
        {"recording": "run", "role": "contact", "F̂*": most, "F̂ᵐᵃᵖ": most},
        {"recording": "free", "role": "fit", "F̂*": "0 %", "F̂ᵐᵃᵖ": "–"},
    ]
    without = Results(study, {"fixed_threshold": rows[rows["estimate"] != "F*"]}, Path())
    assert shown("fixed_threshold", without) == []


def payloads() -> pd.DataFrame:
    loads = [load_of("free", 0.02, taken=False), load_of("heavy", 2.75, taken=True)]
    return table(friction.payload, dict(loads))


def load_of(name: str, mass: float, taken: bool) -> tuple[str, dict]:
    """A recording's name and what currents.json says of its load."""
    load = {
        "mass": mass,
        "std_error": 0.03,
        "interval": (mass - 0.06, mass + 0.06),
        "certain": taken,
        "configured": 0.5,
        "carried": 0.5 + mass,
        "taken": taken,
        "center_of_mass": [0.0, 0.01, 0.05] if taken else [None] * 3,
        "center_of_mass_std": [0.01] * 3 if taken else [None] * 3,
    }
    return name, {"load": load}


def test_what_a_run_carries_stands_in_a_table() -> None:
    cells = shown("payload", Results({}, {"payload": payloads()}, Path()))
    assert [own["used in prediction"] for own in cells] == ["no", "yes"]
    assert cells[1]["additional [kg]"] == "2.750 ± 0.030"
    assert cells[1]["declared [kg]"] == "0.50"
    heavy = payloads().set_index("recording").loc["heavy"]
    assert heavy["low"] < heavy["mass"] < heavy["high"]
    assert heavy["center_of_mass_z"] == 0.05
    assert table(friction.payload, {"at rest": {"load": None}, "no currents": {}}).empty


def test_a_load_that_the_model_lacks_is_told() -> None:
    results = Results({}, {"payload": payloads()}, Path())
    (told,) = _each("findings.load", loaded(results))
    assert "heavy" in told
    assert stated(told) == [2.75, 95, 2.69, 2.81]


def test_remarks_of_fits_are_told_and_why_one_made_nothing() -> None:
    odd, little = (asdict(remark("other reason", reason=why)) for why in ("odd", "too little"))
    fitted = {"fit": {"joints": [{"remarks": [odd]}, {"remarks": []}, {"remarks": [odd]}]}}
    rows = table(models.remarks, {"ur5": ({"refused": little}, fitted, None)})
    results = Results({}, {"remarks": rows}, Path())
    assert [*remarks(results)] == ["ur5, joints 1, 3: odd."]
    assert left_out_fits(results) == ["Identification of ur5: too little."]


def test_files_that_a_text_names_are_links_where_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = Paragraph(["See tables.zip and docs/methods.md."])
    page = Document("t", "", [Section("First", [words])], home="../")
    monkeypatch.chdir(tmp_path)
    assert links(page) >= {"../tables.zip"}
    write_text("methods", tmp_path / "docs" / "methods.md")
    assert links(page) >= {"../tables.zip", "../../../docs/methods.md"}


def links(document: Document) -> set[str]:
    return {one.get("href") for one in fromstring(html_page(document)).iter("a")}


def test_the_archive_has_every_table_and_is_the_same_again(tmp_path: Path) -> None:
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for file in files:
        write_text(file.stem, file)
    archive = zipfile.ZipFile(BytesIO(archived(files)))
    assert {name: archive.read(name) for name in archive.namelist()} == {
        "tables/a.csv": b"a",
        "tables/b.csv": b"b",
    }
    assert archived(files) == archived(files)
