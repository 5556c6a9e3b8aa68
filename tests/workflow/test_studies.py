"""Studies of other sizes than the usual: their reports make sense too."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from lxml.html import fromstring
from pypdf import PdfReader

from tests.artefacts.documents import (
    MOST_BYTES,
    check_brief,
    check_pdf,
    check_results,
    check_structure,
)
from tests.conftest import Workflow, copy_project
from tests.in_memory import assert_draws_as_in_report
from tests.made_study import judged_anew
from tests.typeset_page import built as results_of
from tests.typeset_page import plain, sources
from ur5lib.report.page.typeset import html_page, pdf_document
from ur5lib.report.results import Results
from ur5lib.robots.description import joint_sizes, load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import read_csv

STUDY = """\
study: alone
title: One short recording
recordings:
  - name: only
    robot: ur5
    format: realtime-stream
    role: fit
    simulate: {seconds: 6, trajectory: {kind: fourier, draw: 3, period_s: 6}, seed: 1}
settings: {pushes: {per_arm: 90}}
"""
STANDSTILL = """\
study: standstill
title: An arm at rest, and one pressed beside a force sensor, of which there is nothing to fit
recordings:
  - name: rest
    robot: ur5
    format: thesis-csv
    role: fit
    simulate: {seconds: 4, trajectory: {kind: standstill}, seed: 1}
  - name: pressed
    robot: rebuilt
    format: thesis-csv
    role: contact
    simulate:
      trajectory: {kind: standstill}
      seconds: 11
      seed: 6
      force_sensor: {}
      contacts:
        - {kind: push, start_s: 2, seconds: 2, force: [-30, 30, -60]}
        - {kind: push, start_s: 5, seconds: 2, force: [0, -90, 0]}
        - {kind: push, start_s: 8, seconds: 2, force: [60, 0, 30]}
settings: {pushes: {per_arm: 90}}
"""
AT_REST = """\
study: postures
title: Postures at rest
robot: ur16e
recordings:
  - name: postures
    format: table-csv
    folder: raw
    file: log.csv
    columns: [actual_q, actual_current]
    still: true
    role: fit
"""
MANY = 200


def built(folder: Path, study: str, **arms: str) -> Workflow:
    """A study in a copy of the project, with its results; arms: descriptions of its own."""
    workflow = Workflow(copy_project(folder / "project"))
    (workflow.folder / "config.yaml").write_text(study)
    (workflow.folder / "robots").mkdir(exist_ok=True)
    for name, description in arms.items():
        (workflow.folder / "robots" / f"{name}.yaml").write_text(description)
    workflow.build()
    return workflow


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """A study of one recording of 6 s, without a sensor."""
    return built(tmp_path_factory.mktemp("alone"), STUDY)


def checked(workflow: Workflow, least: int = 30) -> tuple[Path, str]:
    """The results' folder, and the text of the report, without data and configuration; it has more
    numbers than `least`.
    """
    (folder,) = (workflow.folder / "results").iterdir()
    check_structure(folder / "report.html")
    check_results(folder, least)
    check_brief(folder / "report.html")
    [main] = fromstring((folder / "report.html").read_text()).iter("main")
    for data in main.xpath(".//pre | .//script"):
        data.drop_tree()
    text = plain(main.text_content())
    assert not re.search(r"\b(nan|None(?! is fitted))\b", text)
    return folder, text


def test_one_recording_without_sensors_is_a_report(alone: Workflow) -> None:
    folder, text = checked(alone)
    check_pdf(folder)
    page = fromstring((folder / "report.html").read_text())
    [folded] = page.xpath("//details[summary='Not possible with these data']")
    told = [plain(item.text_content()) for item in folded.iter("li")]
    for title, reason in (
        ("Motion", "no recording has an IMU whose clock"),
        ("Prediction of currents", "no recording has the role validate"),
        ("Errors of the force", "no recording has a working force sensor"),
    ):
        assert any(one.startswith(f"{title}: {reason}") for one in told), told
    sections = {own.get("id") for own in page.xpath("//section[@id]")}
    assert {"constants", "provenance"} <= sections
    assert sections.isdisjoint({"motion", "currents"})
    assert "thesis" not in text


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The results and the report of a study of two arms at rest; one has motors of its own."""
    described = yaml.safe_load(robot_path("ur5").read_text()) | {"name": "rebuilt"}
    own = {f"own {size}": joint_sizes()[size] for size in ("big", "small")}
    described |= {"joints": [f"own {size}" for size in described["joints"]], "motors": own}
    folder = tmp_path_factory.mktemp("at_rest")
    return checked(built(folder, STANDSTILL, rebuilt=yaml.safe_dump(described)))


def test_a_standstill_tells_no_models_apart_and_no_friction(
    at_rest: tuple[Path, str], tmp_path: Path
) -> None:
    folder, text = at_rest
    assert_draws_as_in_report(folder, tmp_path)
    page = fromstring((folder / "report.html").read_text())
    [links] = page.xpath("//section[@id='links']")
    assert "closest" not in links.text_content()
    assert page.xpath("//*[@id='links-by-joint']") == []
    assert "did not move" in text


def test_contacts_beside_a_sensor_are_shown_without_a_fit(at_rest: tuple[Path, str]) -> None:
    """The sensor's numbers, and the force from known torque constants, inside its wide band.

    There is no recording to fit, and the friction of its motors is not known from others.
    """
    folder, _ = at_rest
    (sensed,) = read_csv(folder / "tables" / "sensed.csv").itertuples()
    assert sensed.contacts == 3
    assert sensed.largest_force_n == pytest.approx(90, rel=0.1)
    rows = read_csv(folder / "tables" / "force_mae.csv")
    rows = rows[(rows["kind"] == "compensated") & (rows["estimate"] == "static")]
    contact = rows[(rows["during"] == "contact") & rows["component"].isin(["Fx", "Fy", "Fz"])]
    assert (contact["coverage95"] >= 0.95).all()
    assert (contact["mae"] < contact["mean_force"]).all()
    assert read_csv(folder / "tables" / "friction.csv").query("robot == 'rebuilt'").empty
    figure = folder / "figures" / "pressed" / "forces_estimated.csv"
    drawn = {*read_csv(figure)}
    assert {"force sensor, Fy [N]", "uncalibrated static estimate, Fy [N]"} <= drawn


def test_postures_without_time_are_a_report_on_constants(tmp_path: Path) -> None:
    """No friction and no force is stated; what comes in beside them is computed as ever."""
    workflow = Workflow(copy_project(tmp_path / "project"))
    arm = load_robot(robot_path("ur16e"))
    random = np.random.default_rng(4)
    q = random.uniform(-2.5, 2.5, (200, 6))
    friction = 0.05 * np.array(arm.torque_limits()) * random.uniform(-1, 1, q.shape)
    torque = gravity_torque(arm, arm.chosen_model, q) + friction
    constants = np.array(arm.maker_torque_constants())
    log = workflow.folder / "raw" / "log.csv"
    log.parent.mkdir(exist_ok=True)
    np.savetxt(log, np.column_stack([q, torque / constants]), delimiter=",", fmt="%.6f")
    (workflow.folder / "config.yaml").write_text(AT_REST)
    workflow.build()
    folder, text = checked(workflow, least=20)
    assert_draws_as_in_report(folder, workflow.folder)
    rows = read_csv(folder / "tables" / "friction.csv").query("parameter == 'torque_constant'")
    own = rows.set_index("joint")
    assert [*own.index[own["determined"] == "yes"]] == [2, 3, 4]
    assert (np.abs(own["value"] - constants) < 4 * own["std_error"]).all()
    assert "did not move" in text
    assert "3 of 6 joints whose constant may be used" in text
    for table in ("force_mae", "current_rmse", "contacts"):
        assert read_csv(folder / "tables" / f"{table}.csv").empty
    (recording,) = read_csv(folder / "tables" / "recordings.csv").itertuples()
    assert (recording.recording, recording.frames) == ("postures", 200)
    assert workflow.plan() == {}


def multiplied(results: Results, count: int, figures: Path) -> Results:
    """The same study with its only recording many times over, half of them to validate on."""
    names = [f"recording_{i:03}" for i in range(count)]
    (recording,) = results.study["recordings"]
    for name in names:
        (figures / name).symlink_to(results.figures / recording["name"])
    for path in results.figures.iterdir():
        if path.name != recording["name"]:
            (figures / path.name).symlink_to(path)
    entries = [
        recording | {"name": name, "role": ("fit", "validate")[i % 2]}
        for i, name in enumerate(names)
    ]

    def each(table: pd.DataFrame) -> pd.DataFrame:
        if "recording" not in table:
            return table
        return pd.concat(
            [table.replace({"recording": {recording["name"]: name}}) for name in names],
            ignore_index=True,
        )

    study: dict[str, Any] = {**results.study, "recordings": entries}
    tables = {name: each(table) for name, table in results.tables.items()}
    own = replace(results, drawn=frozenset(names) | results.drawn)
    return judged_anew(own, study=study, tables=tables, figures=figures)


def test_two_hundred_recordings_are_a_report(alone: Workflow, tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    whole = results_of(alone.folder / "results" / "alone")
    with sources(multiplied(whole, MANY, tmp_path / "figures")) as root:
        (tmp_path / "report.html").write_text(html_page(root))
        (tmp_path / "report.pdf").write_bytes(pdf_document(root))
    assert (tmp_path / "report.html").stat().st_size < MOST_BYTES
    check_structure(tmp_path / "report.html")
    check_brief(tmp_path / "report.html")
    check_pdf(tmp_path)
    reader = PdfReader(tmp_path / "report.pdf")
    [first, *_] = (entry for entry in reader.outline if not isinstance(entry, list))
    start = reader.get_destination_page_number(first)
    assert start is not None
    assert start <= 2, "the first screen is longer than two pages"
