"""The report: safe from what its data contain, right in the tables that mislead most easily."""

import json
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
import typst
from lxml import etree
from lxml.html import HtmlElement, fromstring

from tests.artefacts.documents import check_digits
from tests.made_study import finding, judged_anew, study
from tests.made_tables import record, table
from tests.report.illustrated import EVERY, illustrated
from tests.typeset_page import page_of, plain, sources, tables_of
from ur5lib.errors import InputError, Remark
from ur5lib.force.alarms import Alarm, Matched
from ur5lib.force.contact_figures import force_errors
from ur5lib.force.fates import contact_rows
from ur5lib.force.residual_model import Residuals
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.contacts import Contact, Detection
from ur5lib.records.dynamics import Torques
from ur5lib.records.fits import RemarkRow
from ur5lib.records.force_errors import ForceError
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import LoadRow, TorqueError
from ur5lib.records.models import Identification
from ur5lib.records.prediction import JudgedLoad
from ur5lib.records.signals import Signals
from ur5lib.records.verdicts import REASONS
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.traces import TORQUE_PANELS, Traces, draw_traces
from ur5lib.report.page.typeset import html_page, pdf_document
from ur5lib.report.results import Results
from ur5lib.steps.judge_recording import joint_paths, load_row, torque_errors
from ur5lib.steps.make_tables import remarks
from ur5lib.steps.write_report import archived
from ur5lib.tables import write_text

HOSTILE = '<script>alert("x")</script> & #set page(width: 1mm) $x$ *y* \\ {{ 7 * 7 }} </table> <b>'
TEXTS = ["p", "li", "td", "th", "figcaption", "caption", "h2", "h3"]


# Text from outside


def hostile() -> Results:
    """A study whose files, findings, remarks and columns are named to do harm."""
    where = {"recording": "seen"}
    made = study(
        **EVERY,
        quality=[
            finding("stop", Found.CONTRADICTION, detail=HOSTILE, place=""),
            finding("note", Found.OTHER, finding=HOSTILE),
        ],
        remarks=[
            {"robot": "ur5", "step": "friction", "joint": 2, "code": "x", "remark": HOSTILE},
            {"robot": "ur5", "step": HOSTILE, "code": "x", "remark": HOSTILE},
        ],
        account=[where | dict.fromkeys(("subject", "taken_for", "reason", "evidence"), HOSTILE)],
        files=[where | {"file": HOSTILE, "sha256": "0" * 64}],
        clocks=[where | {"device": HOSTILE, "method": HOSTILE}],
    )
    return judged_anew(made, study={**made.study, "title": HOSTILE}, commit=HOSTILE)


@pytest.fixture(scope="module")
def attacked() -> dict[str, HtmlElement]:
    pages = ("report", "details")
    with sources(hostile()) as root:
        return {page: fromstring(html_page(root, page)) for page in pages}


@pytest.mark.parametrize(("page", "least"), [("report", 7), ("details", 7)])
def test_html_shows_text_from_outside_as_text(
    attacked: dict[str, HtmlElement], page: str, least: int
) -> None:
    shown = attacked[page]
    own = page_of(study(**EVERY), page)
    assert plain(shown.text_content()).count(HOSTILE) >= least
    for tag in ("script", "em", "style", "meta"):
        assert len([*shown.iter(tag)]) == len([*own.iter(tag)]), tag
    assert not [one for one in shown.iter("b") if one.getparent().get("class") != "number"]
    assert shown.find(".//title").text == HOSTILE


def test_pdf_is_made_from_text_from_outside() -> None:
    with sources(hostile()) as root:
        assert pdf_document(root).startswith(b"%PDF")


def test_a_mention_of_nothing_is_an_error() -> None:
    with sources(study()) as root:
        (root / "sections").unlink()
        write_text(
            '#import "/kit/page.typ": *\n#let (id, title, order) = ("lost", "Lost", 1)\n'
            '#let report() = [#see("lost-table") has it.]\n',
            root / "sections" / "recordings.typ",
        )
        listed = json.loads((root / "data" / "study.json").read_text())
        listed["sections"] = ["/sections/recordings.typ"]
        write_text(json.dumps(listed), root / "data" / "study.json")
        with pytest.raises(InputError, match="empty"):
            html_page(root)


# Figures and tables as such


def test_a_figure_in_the_page_is_its_file_without_what_nobody_sees(tmp_path: Path) -> None:
    """Smaller, with all drawn parts, and what these refer to."""
    results = illustrated(tmp_path)
    time = np.linspace(0, 1, 50)
    values = np.outer(np.sin(time), np.ones(6))
    picture = tmp_path / "seen" / "currents.svg"
    series = {"a": (values, "measured"), "b": (2 * values, "joint")}
    save(draw_traces(Traces(time, series), TORQUE_PANELS), picture)
    figure = page_of(results, "details").get_element_by_id("seen-currents")
    (image,) = figure.iter("img")
    shown = etree.fromstring(unquote(image.get("src").split(",", 1)[1]).encode())
    file = etree.parse(picture).getroot()
    drawn = [[*one.iter("{*}path", "{*}use", "{*}image")] for one in (file, shown)]
    assert len(drawn[0]) == len(drawn[1]) > 10
    text = etree.tostring(shown).decode()
    assert len(text) < 0.9 * picture.stat().st_size
    names = {one.get("id") for one in shown.iter("{*}*")}
    assert {*re.findall(r"(?:url\(|href=\")#([\w-]+)", text)} <= names


def test_numbers_have_a_meaning_and_no_line_breaks_within_one() -> None:
    for page in ("report", "details"):
        texts = [one.text_content() for one in page_of(study(**EVERY), page).iter(*TEXTS)]
        assert len(texts) > 100
        check_digits(texts)


def test_columns_of_numbers_stand_right() -> None:
    page = page_of(study(**EVERY))
    (shown,) = page.xpath("//div[@id='force-decided']/table")
    classes = {plain(one.text_content()): one.get("class") for one in shown.iter("th")}
    assert classes["recording"] != "right"
    assert classes["error"] == classes["95 %"] == "right"
    assert {one.get("class") for one in shown.xpath(".//tr/td[2]")} == {"right"}


CASES = {
    '(1.0, 2.0, 3.0), ("1.0", "2.0", "3.0")': "▼ |-|▲ ",
    '(1.0, 2.0, 3.0), ("1.0", "2.0", "3.0"), zero: 1.1': "▼ |-|▲ ",
    '(1.0, 2.0, 3.0), ("1.0", "2.0", "3.0"), zero: 0.9': "-|-|▲ ",
    '(1.0, 1.01), ("1.0", "1.0")': "-|-",
    '(1.0, 1.01, 3.0), ("1.0", "1.0", "3.0")': "-|-|▲ ",
    '(none, 2.0, 3.0), (none, "2.0", "3.0")': "-|▼ |▲ ",
}


def worded(module: str, *values: str) -> list[Any]:
    """What a module of the page's sources makes of values."""
    with sources(study()) as root:
        lines = [f"#metadata({value}) <value>" for value in values]
        write_text("\n".join([f'#import "/kit/{module}.typ": *', *lines]), root / "values.typ")
        found = typst.query(root / "values.typ", "<value>", field="value", root=root)
    return list(json.loads(found))


def test_extremes_are_marked_where_values_differ() -> None:
    """No smallest error that an estimate of zero beats, and none of equal texts."""
    found = worded("page", *(f"marks({case})" for case in CASES))
    shown = ["|".join(one or "-" for one in marks).replace("\u00a0", " ") for marks in found]
    assert shown == [*CASES.values()]


def test_each_reason_against_a_state_has_its_words() -> None:
    (codes,) = worded("words", "why.keys()")
    assert {*codes} == {*REASONS}


# Torques


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


def test_torque_errors_leave_out_invented_frames() -> None:
    rows = table(TorqueError, {"seen": torque_errors(*torque_tables())})
    mae = rows.groupby("model")["mae"]
    assert mae.max().to_dict() == {"A": 0.0, "B": 0.5}
    assert rows["zero_mae"].eq(1.0).all()


# Contacts


def with_rows(**tables: pd.DataFrame) -> Results:
    """A judged study with tables of steps."""
    made = study()
    whole = {name: own.reindex(columns=made.tables[name].columns) for name, own in tables.items()}
    return judged_anew(made, tables={**made.tables, **whole})


def alarm(start: float, force: list[float], **more: Any) -> Alarm:
    """An alarm of 1 s, its largest force in the middle."""
    at_peak = np.array(force), np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0])
    return Alarm(start, start + 1, start + 0.5, *at_peak, **more)


def contacts_of(alarms: list[Alarm]) -> list[dict[str, str]]:
    """The table of contacts on a recording without a force sensor."""
    found = table(Contact, {"pushed": contact_rows("Fmap", alarms, is_free=False)})
    detection = pd.DataFrame([{"recording": "pushed", "estimate": "Fmap"}])
    shown = tables_of(with_rows(contacts=found, detection=detection), "details")
    return shown["contacts-pushed"]


def test_contacts_without_a_sensor_have_their_force_with_its_error() -> None:
    first, second = contacts_of([alarm(1.0, [3.0, 0.0, -4.04]), alarm(7.0, [1.0, 0.0, 0.0])])
    assert [*first.values()][:3] == ["1.00 to 2.00", "1.50", "3.0 ± 2.0"]
    assert (first["Fy [N]"], first["Fz [N]"]) == ("0.0 ± 3.9", "−4.0 ± 5.9")
    assert second["Fx [N]"] == "1.0 ± 2.0"


def test_contacts_off_the_flange_are_marked() -> None:
    rows = [alarm(float(k), [5.0 + k, 0, 0], off_flange=k == 1) for k in range(2)]
    assert [line["remark"] for line in contacts_of(rows)] == ["", "not at the flange"]


def test_a_load_taken_up_is_no_contact() -> None:
    lifted = {"kind": "load", "load_mass": 2.04, "load_mass_std": 0.05}
    down = [0.0, 0.0, -20.0]
    lines = contacts_of([alarm(4.0, down), alarm(4.0, down, **lifted)])
    assert [line["load [kg]"] for line in lines] == ["–", "2.040 ± 0.098"]


# Forces next to the sensor

WRENCH = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]


def force_summary() -> list[ForceError]:
    """Errors of 4 N in contact and 0.1 N free; of moments, only nx is told."""

    def figures(mae: float, mean: float, **more: float) -> dict[str, np.ndarray]:
        same = {"mae": mae, "zero_mae": mean, "mean_force": mean, "slope": 0.9, "skill": 0.6}
        same |= {"coverage95": 0.9, "interval_score95": 30.0, "zero_interval_score95": 50.0}
        return {name: np.full(6, value) for name, value in (same | more).items()}

    contact = figures(4.0, 10.0, mae_low=3.0, mae_high=5.0, skill_low=0.5)
    contact["skill_low"][4:] = -0.1, 0.0
    during = {"all": figures(1.0, 2.5), "contact": contact, "free": figures(0.1, 0.1)}
    return [
        *force_errors("compensated", "Fmap", during),
        *force_errors("compensated", "Fu", {"all": figures(9.0, 2.5)}),
        *force_errors("printed", "Fu", during),
    ]


def test_what_is_not_certainly_better_than_none_is_undetermined() -> None:
    results = with_rows(force_mae=table(ForceError, {"pushed": force_summary()}))
    rows = results.rows("force_mae", kind="compensated").set_index("estimate")
    known = rows.loc["Fmap"].groupby("component")["determined"].unique().map(list)
    assert {name for name, told in known.items() if told == ["no"]} == {"ny", "nz"}
    assert rows.loc["Fu", "determined"].isna().all()
    lines = tables_of(results, "details")["force-summary"]
    told = {line["component"]: line["F̂ᵐᵃᵖ"] for line in lines}
    assert told["ny [Nm]"] == told["nz [Nm]"] == "undetermined"
    assert told["Fx [N]"] == told["nx [Nm]"] == "4.00"


def test_contacts_are_counted_by_their_force() -> None:
    part = {"contacts": 4, "found": 3, "recall": 0.75, "median_delay_s": 0.1}
    classes = [{"force_class_n": 3.0, **part}, {"force_class_n": 15.0, **part, "found": 4}]
    found = Matched(1.0, false_alarms_per_min=0.5, extra_alarms=2, classes=classes).rows()
    same: dict[str, Any] = {"threshold": 8.5, "alarms": 0, "time_in_alarm": 0.5}
    same |= {"free_time_in_alarm": 0.25}
    own = [Detection(estimate=name, **same, **row) for name in ("Fmap", "Fu") for row in found]
    rows = table(Detection, {"pushed": own})
    assert rows["force_class_n"].tolist() == [3, 15] * 2
    assert rows["extra_alarms"].eq(2).all()
    first, _ = tables_of(with_rows(detection=rows), "details")["detections"]
    assert (first["≥ 3 N"], first["≥ 15 N"]) == ("3 of 4", "4 of 4")
    assert first["delay [s]"] == "0.10"
    assert (first["false [1/min]"], first["extra"]) == ("0.5", "2")


# Loads and fits


def payloads() -> pd.DataFrame:
    loads = {"fitted": load_of(0.02, taken=False), "seen": load_of(2.75, taken=True)}
    return table(LoadRow, {name: [load_row(own)] for name, own in loads.items()})


def load_of(mass: float, taken: bool) -> JudgedLoad:
    """What currents.json says of a load."""
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
    made: JudgedLoad = record(JudgedLoad, load)
    return made


def test_what_a_run_carries_is_in_a_table() -> None:
    cells = tables_of(with_rows(payload=payloads()), "details")["payload"]
    assert [own["used in prediction"] for own in cells] == ["no", "yes"]
    assert cells[1]["additional [kg]"] == "2.750 ± 0.059"
    assert cells[1]["declared [kg]"] == "0.50"
    heavy = payloads().set_index("recording").loc["seen"]
    assert heavy["low"] < heavy["mass"] < heavy["high"]
    assert heavy["center_of_mass_z"] == 0.05


def test_remarks_of_fits_are_on_the_page_and_why_one_made_nothing() -> None:
    odd, little = (asdict(Remark(CauseCode.OTHER_REASON, why)) for why in ("odd", "too little"))
    fitted = {"fit": {"joints": [{"remarks": [odd]}, {"remarks": []}, {"remarks": [odd]}]}}
    whole = record(Identification, {"refused": little}), record(Friction, fitted), Residuals()
    rows = table(RemarkRow, {"ur5": remarks(*whole)})
    made = study(**EVERY)
    page = page_of(judged_anew(made, tables={**made.tables, "remarks": rows}))
    told = plain(page.get_element_by_id("constants").text_content())
    assert "Joints 1 and 3: odd." in told
    first = plain(page.xpath("//section[@class='first']")[0].text_content())
    assert "Identification of ur5: too little." in first


# The archive


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


def test_a_path_has_each_joints_angles_from_first_to_last() -> None:
    q = np.column_stack([np.linspace(0, 1, 100), np.full(100, -2.0)])
    q[[0, 50]] = np.nan
    first, second = joint_paths(q)
    assert first.angles.startswith("0.01 0.04 ")
    assert first.angles.endswith(" 1.00")
    assert {*second.angles.split()} == {"-2.00"}
    assert [*joint_paths(q[:1])] == []
