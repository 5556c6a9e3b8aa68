"""The default study: what the workflow made of simulated recordings, beside the truth."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from lxml.html import fromstring

from benchmarks import stand_and_arms
from benchmarks.harness.markdown import read_page, table_in
from benchmarks.pictures import DRAWN, FIGURES, PICTURES
from tests import notebook
from tests.artefacts.documents import (
    check_brief,
    check_captions,
    check_digits,
    check_in_browser,
    check_links,
    check_pdf,
    check_results,
    check_structure,
    check_valid,
    page_texts,
    shown_texts,
)
from tests.artefacts.drawn_arm import check_arm
from tests.compensated import check_formula
from tests.conftest import PROJECT, Workflow, table_of_topic
from tests.drawn_numbers import check_drawn_numbers
from tests.examples import examples
from tests.house.test_benchmarks import run_benchmark
from tests.in_memory import assert_as_in_study, assert_draws_as_in_report
from tests.rigid import check_rigid
from ur5lib.commands.convert import write_recordings
from ur5lib.commands.exported import exported
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.force.sensed_contact import in_contact
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.records.codes import Found
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.friction import without_totals
from ur5lib.records.verdicts import Verdict
from ur5lib.report.figures.house_style import save
from ur5lib.tables import read_csv, read_json, write_rows
from ur5lib.timeseries.metrics import interval_score

FRICTION = ["torque_constant", "offset", "coulomb", "viscous", "load"]
NOTICE = "Simulated: all recordings of this study are of the virtual test stand"


@pytest.fixture(scope="module")
def results(demo: Workflow) -> Path:
    return demo.folder / "results" / "demo"


@pytest.fixture(scope="module")
def truth(results: Path) -> pd.DataFrame:
    return table_of_topic(results, "truth")


def errors(truth: pd.DataFrame, quantity: str) -> pd.Series:
    rows = truth[truth["quantity"] == quantity]
    assert len(rows)
    return (rows["estimate"] - rows["truth"]).abs()


def test_figures_draw_what_their_tables_state(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = check_drawn_numbers(results, monkeypatch)
    assert {*compared} == {"currents", "torques", "forces", "accelerations", "friction"}


@pytest.mark.parametrize("page", ["report.html", "details.html"])
def test_captions_name_what_is_drawn(results: Path, page: str) -> None:
    check_captions(results / page)


OF_THE_DEMO = [name for name, figure in FIGURES.items() if figure.startswith("demo/")]
DRAWN_OF_IT = [name for name, (study, _) in DRAWN.items() if study == "demo"]


def labels(picture: Path) -> set[str]:
    """The words of a picture, without its numbers."""
    return {*re.findall(r"<!-- (?![\d−.]+ -->)(.*?) -->", picture.read_text())}


@pytest.mark.parametrize("name", OF_THE_DEMO)
def test_pictures_of_documents_show_what_the_study_draws(results: Path, name: str) -> None:
    """By their labels; `make pictures` draws them anew."""
    drawn = results / FIGURES[name].removeprefix("demo/")
    assert labels(PICTURES / f"{name}.svg") == labels(drawn.with_suffix(".svg"))


@pytest.mark.parametrize("name", DRAWN_OF_IT)
def test_pictures_of_documents_are_those_of_the_study(
    results: Path, name: str, tmp_path: Path
) -> None:
    save(DRAWN[name][1](results), tmp_path / "drawn.svg")
    assert labels(PICTURES / f"{name}.svg") == labels(tmp_path / "drawn.svg")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "given", "texts"),
    [
        ("counterbalance", ["demo"], ["| demo | ur5 | 3 |", "| none |"]),
        ("expected", ["demo"], ["| ur5, simulated | currents | force sensor | 3 paths, 1 date |"]),
        ("leave_out", [], ["alarms a minute", "friction differs by"]),
        ("live_efforts", ["demo"], ["identified by", "right", "wrong", "undecided"]),
        ("worth", [], ["| nothing |", "| cross-fitting |"]),
        ("paths", [], ["| ur5 | 0 |", "| ur5 | 1 |", "error of currents"]),
        ("rollout", ["demo"], ["demo, ur5: 6 windows", "our simulation of", "urdf, rotors"]),
        ("stand_and_arms", ["demo"], ["| the stand |"]),
        (
            "slow_presses",
            ["--study", "demo"],
            ["demo: no recording without contact", "rests for 8 s"],
        ),
    ],
)
def test_what_was_built_is_measured(
    demo: Workflow, name: str, given: list[str], texts: list[str]
) -> None:
    printed = run_benchmark(name, demo.folder, *given)
    assert all(text in printed for text in texts)


def test_the_stand_is_as_hard_as_an_arm(results: Path) -> None:
    """Its residual torque without contact lies among those of real arms, line by line."""
    page = read_page(PROJECT / "docs" / "world.md")
    rows = table_in(page, stand_and_arms.TITLE).set_index("arm").replace("–", np.nan).astype(float)
    arms = rows.drop(index=stand_and_arms.STAND)
    found = np.array(stand_and_arms.row_of(results))
    assert (arms.min().to_numpy() <= found).all()
    assert (found <= arms.max().to_numpy()).all()


def test_a_second_run_has_nothing_to_do(demo: Workflow) -> None:
    assert demo.plan() == {}


def test_clocks_come_back_within_5_ms(truth: pd.DataFrame) -> None:
    assert errors(truth, "clock_offset").max() < 0.005
    assert errors(truth, "clock_drift").max() < 100
    assert set(truth.query("quantity == 'clock_drift'")["recording"]) == {
        "excitation", "excitation_2", "excitation_slow", "way_points",
    }  # fmt: skip


def test_what_is_fitted_comes_back(truth: pd.DataFrame) -> None:
    assert errors(truth, "rotor_inertia").max() < 1e-6
    assert errors(truth, "base_parameter").max() < 1e-5
    assert errors(truth, "imu_mounting").max() < 3e-4
    assert errors(truth, "imu_tilt").max() < 3e-4
    assert errors(truth, "imu_gyroscope_bias").max() < 4e-4


def test_torque_constants_and_friction_come_back(truth: pd.DataFrame) -> None:
    """Those of joints 2 and 3, which carry the arm, within 5 %; all within what is stated."""
    rows = truth[truth["quantity"] == "torque_constant"].set_index("index")
    error = (rows["estimate"] / rows["truth"] - 1).abs()
    assert len(error) == 6
    assert error.loc[rows.index.astype(int).isin([2, 3])].max() < 0.05
    stated = truth[truth["quantity"].isin(FRICTION)]
    assert len(stated) == 5 * 6
    assert (stated["within95"] == "yes").mean() >= 0.9


def test_stated_intervals_hold_the_truth(truth: pd.DataFrame) -> None:
    """Clocks, rotors and IMU; base parameters err by rounding, which no interval knows."""
    others = ["base_parameter", *FRICTION]
    stated = truth[truth["within95"].notna() & ~truth["quantity"].isin(others)]
    assert (stated["within95"] == "yes").mean() >= 0.9


def test_the_wrench_is_within_its_band(truth: pd.DataFrame) -> None:
    """Nine tenths of each recording, each axis; with contact, better than an estimate of zero."""
    rows = truth[truth["method"] == "Fmap"]
    share = rows[rows["quantity"] == "wrench_coverage95"]
    assert set(share["recording"]) == set(truth["recording"].dropna())
    assert share["estimate"].min() >= 0.9
    off = rows[(rows["quantity"] == "wrench_rmse") & (rows["zero"] > 2.0)]
    assert len(off) >= 7
    assert (off["estimate"] < 0.55 * off["zero"]).all()


def test_the_identified_model_is_the_simulated_one(truth: pd.DataFrame) -> None:
    rows = truth[(truth["quantity"] == "torque_rmse") & (truth["method"] == "Model identified")]
    assert set(rows["recording"]) == set(truth["recording"].dropna())
    assert rows["estimate"].max() < 1e-4


def test_accelerations_are_near_the_truth_and_inside_their_bands(truth: pd.DataFrame) -> None:
    moving = truth[~truth["recording"].isin(["standstill_pushed", "pressed", "pressed_tared"])]
    rows = moving[moving["quantity"] == "joint_acceleration_rmse"]
    assert (rows["estimate"] < 0.35 * rows["zero"]).all()
    inside = truth[truth["quantity"] == "joint_acceleration_inside_2_std"]["estimate"]
    assert inside.min() > 0.9
    end = moving[moving["quantity"] == "end_effector_acceleration_rmse"]
    ours = end[end["method"] != "filterpy"]
    assert (ours["estimate"] < 0.07 * ours["zero"]).all()  # in a slow motion with pauses
    by_method = end.pivot_table("estimate", ["recording", "index"], "method").dropna()
    assert len(by_method) >= 6
    assert (by_method["encoders"] < by_method["filterpy"]).all()


def test_an_imu_improves_the_joints_accelerations(truth: pd.DataFrame) -> None:
    """In each recording to fit, over the joints."""
    rows = truth[truth["quantity"] == "joint_acceleration_rmse"]
    mean = rows.pivot_table("estimate", "recording", "method")
    both = mean.dropna()
    assert len(both) == 4
    assert (both["encoders+imu"] < both["encoders"]).all()


def test_every_fault_is_found(results: Path) -> None:
    quality = read_csv(results / "tables" / "quality.csv").query("recording == 'every_fault'")
    assert {
        Found.DAMAGED_LINES, Found.BYTES_SKIPPED, Found.TORN_LAST_LINE, Found.STALE_STAMPS,
        Found.STALE_DATA, Found.LOST_FRAMES, Found.STALE_COPY, Found.SATURATION,
    } <= set(quality["code"])  # fmt: skip
    assert not (quality["severity"] == "error").any()


@pytest.mark.parametrize(
    ("name", "contact", "whole"),
    [("way_points_pushed", 20.0, 16.0), ("standstill_pushed", 38.0, 34.0), ("pressed", 27.0, 25.0)],
)
def test_a_change_that_doubles_a_band_fails(
    results: Path, name: str, contact: float, whole: float
) -> None:
    """Largest interval scores [N], in contact and in the whole recording, mean of the axes."""
    at = results / "recordings" / name
    sensor = SensorWrenches.read(at / "sensor.parquet").wrench["compensated"]
    forces = Forces.read(at / "forces.parquet")
    touched = in_contact(np.linalg.norm(sensor[:, :3], axis=1))
    given = forces.wrench["Fmap"], forces.std["Fmap"], sensor
    for of, rows in ((contact, touched), (whole, slice(None))):
        estimate, std, true = (values[rows, :3] for values in given)
        assert interval_score(estimate, std, true).mean() < of
        assert interval_score(estimate, 2 * std, true).mean() > of


def test_a_saturated_sensor_judges_no_peak(results: Path) -> None:
    """It reads at most 30 N of 50 N along x, and judges the rest of that contact."""
    errors = read_csv(results / "tables" / "contact_errors.csv")
    rows = errors.query("recording == 'every_fault' and estimate == 'Fmap'")
    assert rows["peak_error"].isna().all()
    assert rows["mae"].notna().any()
    others = errors.query("recording != 'every_fault' and estimate == 'Fmap'")
    assert others["peak_error"].notna().all()


def test_every_page_says_that_it_is_simulated(results: Path) -> None:
    pages = page_texts(results / "report.pdf")
    assert len(pages) > 5
    assert all(NOTICE in page for page in pages)
    html = (results / "report.html").read_text()
    assert f'<aside class="notice" aria-label="notice">{NOTICE}' in html
    assert "<title>A UR5 on the virtual test stand (simulated)</title>" in html
    assert "Provenance" in html


def test_the_report_is_fit_to_be_read(results: Path, tmp_path: Path) -> None:
    check_results(results)
    check_links(results)
    check_brief(results / "report.html")
    for page in ("report.html", "details.html"):
        check_valid(results / page)
        check_structure(results / page)
        check_digits(shown_texts(results / page))
        (tmp_path / page).mkdir()
        check_in_browser(results / page, tmp_path / page)
    check_pdf(results)


def test_the_report_is_short_and_leaves_the_rest_to_the_details(results: Path) -> None:
    """No table is in both; `check_links` follows the links from each to the other."""
    assert len(page_texts(results / "report.pdf")) <= 15
    pages = [fromstring((results / f"{page}.html").read_text()) for page in ("report", "details")]
    shown = [{*page.xpath("//*[@class='scroll']/@id")} for page in pages]
    assert all(shown)
    assert shown[0] & shown[1] == set()
    assert pages[0].xpath("//a[starts-with(@href, 'details.html#')]")
    assert pages[1].xpath("//a[starts-with(@href, 'report.html')]")


def test_the_arm_is_drawn_as_its_tables_say(results: Path) -> None:
    check_arm(results, "way_points_pushed")


Shown = list[tuple[notebook.Cell, list[str]]]


@pytest.fixture(scope="module")
def played(demo: Workflow) -> Iterator[tuple[Shown, dict[str, Any]]]:
    """What the cells of the notebook show, and what they know at the end, in the folder in which
    the study was built.
    """
    known = dict[str, Any]()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(demo.folder)
        cells = notebook.code_cells(read_json(notebook.NOTEBOOK))
        yield [(cell, [*map(notebook.as_text, notebook.run(cell, known))]) for cell in cells], known


def test_the_notebook_shows_what_it_says(played: tuple[Shown, dict[str, Any]]) -> None:
    """Cell by cell; `python -m tests.notebook` keeps the outputs anew."""
    for cell, shown in played[0]:
        assert shown == [notebook.as_text(output) for output in cell["outputs"]], cell["source"]
        assert shown or cell["source"][-1].startswith(("import", "model.save"))


def test_in_memory_all_is_as_in_the_report(
    played: tuple[Shown, dict[str, Any]], results: Path
) -> None:
    """By the recordings and the model of the notebook, which estimates forces, too."""
    _, known = played
    assert_as_in_study(known["runs"], known["model"], results, "way_points")
    pd.testing.assert_frame_equal(
        known["forces"], FinishedStudy(results).forces("way_points_pushed"), check_exact=True
    )
    shown = repr(known["study"])
    assert "way_points_pushed" in shown
    assert len(shown.splitlines()) < 24


@pytest.mark.thorough
def test_its_model_draws_what_the_report_shows(results: Path, tmp_path: Path) -> None:
    assert_draws_as_in_report(results, tmp_path)


def test_identified_links_can_exist(results: Path) -> None:
    check_rigid("ur5", None, results)


def test_the_script_of_the_documents_says_what_may_be_used(
    results: Path, capsys: pytest.CaptureFixture
) -> None:
    """A line for each card, each parameter of a joint, and each recording and purpose."""
    [script] = [
        example.text
        for example in examples(PROJECT / "docs" / "api.md")
        if example.text.startswith("from ur5lib import load")
    ]
    exec(script.replace('"mine"', f'"{results}"').replace("ur5e", "ur5"), {})
    said, study = capsys.readouterr().out.splitlines(), FinishedStudy(results)
    cards = study.verdicts.dropna(subset="state").query("rank == 1")
    assert len(said) == len(cards) + len(study.table("friction")) + len(study.uses)
    assert "force: good." in "\n".join(said)


def test_all_that_is_known_of_the_arm_is_exported(results: Path) -> None:
    known = json.loads(exported("ur5", None, "json", results, ""))
    friction = without_totals(read_csv(results / "tables" / "friction.csv"))
    rotors = read_csv(results / "tables" / "rotor_inertia.csv")
    parameters = read_csv(results / "tables" / "parameters.csv")
    for part, table, columns in (
        ("currents", friction, ["joint", "value", "std_error", "low", "high", "prior_share"]),
        ("rotor_inertia", rotors, ["joint", "value", "std_error"]),
        ("base_parameters", parameters, ["value", "std_error"]),
    ):
        found = pd.DataFrame(known[part])
        assert (found["low"] < found["value"]).all()
        np.testing.assert_allclose(found[columns], table[columns], rtol=1e-7)
    grouped = {"m c_x of link 2": 1.0} | {f"m of link {k}": -0.425 for k in range(3, 7)}
    assert known["base_parameters"][1]["sum_of"] == pytest.approx(grouped)
    constants = friction[friction["parameter"] == "torque_constant"]
    np.testing.assert_allclose(known["known_constants"]["value"], constants["known"], rtol=1e-7)
    assert known["link_model"]["name"] == "identified"
    assert len(known["torque_noise"]) == len(known["current_model"]) == 6
    quality = read_json(results / "recordings" / "excitation" / "quality.json")
    assert known["files"]["excitation"] == quality["read"]


def test_what_verdicts_say_not_to_use_is_exported_for_a_reason_alone(
    results: Path, tmp_path: Path
) -> None:
    """Links as described need none."""
    for part in ("parameters", "recordings", "configuration.yaml"):
        (tmp_path / part).symlink_to(results / part)
    row = Verdict(question="links", arm="ur5", state="do not use", reason="worse_than_zero")
    write_rows(Verdict, [row], tmp_path / "tables" / "verdicts.csv")
    with pytest.raises(InputError, match="links: do not use"):
        exported("ur5", None, "urdf", tmp_path, "")
    assert exported("ur5", "C", "urdf", tmp_path, "").startswith("<robot")


@pytest.mark.parametrize("name", ["way_points_pushed", "standstill_pushed"])
def test_the_sensor_is_exported_with_its_formula(results: Path, name: str) -> None:
    """At rest, weight is a part of the bias."""
    text = exported("ur5", None, "sensor", results, "")
    known = check_formula(text, results, name)
    assert FinishedStudy(results).model("ur5").export("sensor") == f"{text}\n"
    assert (known["mass"] is None) == (name == "standstill_pushed")
    center = known["center_of_mass"]
    if name == "standstill_pushed":
        assert center == dict.fromkeys("xyz")  # of no mass
    else:  # from the sensor, of a tool of 8 cm from the flange
        assert center["z"]["low"] < 0.08 - 0.0286 < center["z"]["high"]
    assert known["reading"] == "ft"
    alone = yaml.safe_load(exported("ur5", None, "sensor", results, name))
    assert [one["recording"] for one in alone["recordings"]] == [name]
    assert alone["spread"] is None
    together = yaml.safe_load(text)["spread"]
    assert together["recordings"] == ["way_points_pushed", "every_fault"]
    assert together["bias"]["Fx"]["highest"] == pytest.approx(-5, abs=0.01)  # as simulated


@pytest.mark.parametrize(
    ("to", "file"), [("mat", "way_points.mat"), ("csv", "way_points/signals.csv")]
)
def test_an_exported_recording_is_imported(
    results: Path, tmp_path: Path, to: str, file: str
) -> None:
    (_,) = write_recordings(results, ["way_points"], to, tmp_path)
    (found,) = import_files([tmp_path / file], UserStatement("ur5"))
    assert not found.entry.keys() & {"joints", "units"}
    assert any(row.taken_for == "actual_current" for row in found.account)
