"""The thesis, rebuilt: what the workflow made of its real recordings."""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from lxml.html import HtmlElement, fromstring

import ur5lib
from tests.artefacts.documents import (
    VIEWS,
    cells_of,
    check_brief,
    check_captions,
    check_digits,
    check_in_browser,
    check_links,
    check_pdf,
    check_results,
    check_structure,
    check_valid,
    shown_texts,
)
from tests.artefacts.drawn_arm import check_arm
from tests.compensated import check_formula
from tests.conftest import PROJECT
from tests.in_memory import assert_draws_as_in_report
from tests.rigid import check_rigid
from ur5lib.commands.exported import exported
from ur5lib.finished import FinishedStudy
from ur5lib.force.estimators import PUBLISHED
from ur5lib.records.accelerations import ImuComparison
from ur5lib.tables import channel, read_json, read_record, read_table

TABLE_5_6 = "Movement_No5_Acc_slow_no_disturbance"
TABLE_5_7 = "Movement_No9_Singularity_Free_NoDist"
TABLE_6_1 = "Movement_No9_Singularity_Free_ForceSensor"
STANDSTILL = [f"Movement_No10_Standstill_ForceSensor_{name}" for name in ("All", "Fx")]
WITH_SENSOR = [TABLE_6_1, *STANDSTILL]
FORCES = ["Fx", "Fy", "Fz"]

# Rigid models at the target motion, computed independently of this project [Nm].
INDEPENDENT = {
    "A": [0.3213, 1.7938, 1.9526, 0.1889, 0.2378, 0.0334],
    "B": [0.2959, 0.5891, 1.1844, 0.0795, 0.0561, 0.0334],
    "C": [0.2832, 0.5548, 1.1865, 0.0681, 0.0393, 0.0334],
}


@pytest.fixture(scope="module")
def study(thesis_results: Path) -> FinishedStudy:
    return ur5lib.load(thesis_results)


@pytest.fixture(scope="module")
def torque(study: FinishedStudy) -> pd.DataFrame:
    return study.table("torque_mae")


@pytest.fixture(scope="module")
def force(study: FinishedStudy) -> pd.DataFrame:
    table = study.table("force_mae")
    return table[table["recording"] == TABLE_6_1]


@pytest.mark.parametrize("model", ["A", "B", "C"])
def test_torque_errors_agree_with_an_independent_computation(
    torque: pd.DataFrame, model: str
) -> None:
    rows = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == @model")
    assert rows["joint"].tolist() == [1, 2, 3, 4, 5, 6]
    assert np.abs(rows["mae"].to_numpy() - INDEPENDENT[model]).max() < 0.002


ACCELERATION_LIMITS = {
    TABLE_5_7: [0.08, 0.045, 0.03, 0.015, 0.022, 0.025],
    TABLE_5_6: [0.02, 0.02, 0.04],
}


@pytest.mark.parametrize("recording", ACCELERATION_LIMITS)
@pytest.mark.parametrize("estimate", ["encoders", "encoders+imu"])
def test_joints_tell_what_the_imu_feels(
    thesis_results: Path, study: FinishedStudy, recording: str, estimate: str
) -> None:
    """With the IMU's mounting, tilt and gyroscope bias from other recordings."""
    table = study.table("acceleration_mae")
    rows = table.query("recording == @recording and estimate == @estimate")
    limits = ACCELERATION_LIMITS[recording]
    assert (rows["mae"].to_numpy()[: len(limits)] <= limits).all()
    folder = thesis_results / "recordings" / recording
    beside = read_record(ImuComparison, folder / "imu_comparison.json")
    assert recording not in beside.calibrated_on


def test_its_model_draws_what_the_report_shows(thesis_results: Path, tmp_path: Path) -> None:
    assert_draws_as_in_report(thesis_results, tmp_path)


def test_identified_links_can_exist(thesis_results: Path) -> None:
    check_rigid("ur5", None, thesis_results)


def test_the_sensor_is_exported_with_its_formula(
    thesis_results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a real sensor, beyond whose gauges only its own plate weighs."""
    monkeypatch.chdir(thesis_results.parents[1])
    text = exported("ur5", None, "sensor", thesis_results, "")
    known = check_formula(text, thesis_results, TABLE_6_1)
    assert 0.05 < known["mass"]["low"] < known["mass"]["high"] < 0.15
    assert known["start"] == "2013-12-10T15:24:57+00:00"


def test_the_smoother_is_as_near_to_the_imu_as_a_plain_one(study: FinishedStudy) -> None:
    """Nearer in rotation, by the geometric mean over recordings, of each component."""
    table = study.table("acceleration_mae")
    mae = table.pivot_table("mae", ["recording", "component"], "estimate")
    times = np.log(mae["filterpy"] / mae["encoders"]).groupby("component").mean()
    assert len(times) == 6
    least = [1.05, 1.05, 1.05, 0.95, 0.95, 0.95]  # rx, ry, rz, x, y, z
    assert (np.exp(times) > least).all(), times


def test_rotors_are_those_of_the_maker(study: FinishedStudy) -> None:
    rotors = study.table("rotor_inertia")
    known = np.array([1.61, 1.62, 1.89, 0.159, 0.159, 0.160])
    np.testing.assert_allclose(rotors["value"], known, rtol=0.03)
    for term in ("offset", "coulomb", "viscous"):
        assert rotors[term].abs().max() < 0.015


def test_rotors_predict_recordings_they_were_not_fitted_on(torque: pd.DataFrame) -> None:
    rows = torque.query("motion == 'target' and model == 'C+rotors'")
    unseen = rows[rows["recording"].str.contains("No8|No9|No10|w_dist")]
    limit = np.where(unseen["joint"] <= 3, 0.09, 0.005)
    assert (unseen["mae"] <= limit).all()


CURRENT_LIMITS = {  # plain Coulomb + viscous + offset, computed independently [A]
    "Movement_No8_Singularity_Free_1": [0.171, 0.169, 0.102, 0.079, 0.050, 0.106],
    TABLE_5_7: [0.198, 0.450, 0.105, 0.083, 0.063, 0.106],
}


@pytest.mark.parametrize("recording", CURRENT_LIMITS)
@pytest.mark.parametrize("joint", range(1, 7))
def test_no_joint_is_predicted_worse_than_by_a_plain_fit(
    study: FinishedStudy, recording: str, joint: int
) -> None:
    table = study.table("current_rmse")
    rows = table.query("recording == @recording and model == 'fitted' and joint == @joint")
    assert rows["rmse_lowpassed"].item() <= CURRENT_LIMITS[recording][joint - 1]


@pytest.mark.parametrize("recording", CURRENT_LIMITS)
def test_currents_are_predicted_better_than_by_a_plain_fit(
    study: FinishedStudy, recording: str
) -> None:
    table = study.table("current_rmse")
    rows = table.query("recording == @recording and model == 'fitted'")
    assert set(rows["fitted"]) == {"no"}
    assert rows["rmse_lowpassed"].mean() <= 0.75 * np.mean(CURRENT_LIMITS[recording])
    plain = table.query("recording == @recording and model == 'least_squares'")
    assert rows["rmse_lowpassed"].mean() <= 0.75 * plain["rmse_lowpassed"].mean()


FORCE_LIMITS = {  # MAE in x, y, z over the whole run [N]
    ("Fmap", TABLE_6_1): [2.2, 2.5, 2.8],
    ("Fmap", "Movement_No10_Standstill_ForceSensor_All"): [4.3, 5.8, 2.6],
    ("Fmap", "Movement_No10_Standstill_ForceSensor_Fx"): [2.3, 5.5, 1.9],
}


@pytest.mark.parametrize(("estimate", "recording"), FORCE_LIMITS)
@pytest.mark.parametrize("kind", ["corrected", "compensated"])
def test_new_estimates_come_nearer_than_the_controllers_and_than_none(
    study: FinishedStudy, estimate: str, recording: str, kind: str
) -> None:
    rows = study.table("force_mae").query("recording == @recording and kind == @kind")
    rows = rows.query("during == 'all' and component in @FORCES").set_index("estimate")
    ours = rows.loc[estimate]
    assert (ours["mae"] <= FORCE_LIMITS[estimate, recording]).all()
    assert (ours["mae"].to_numpy() < rows.loc["Fu", "mae"].to_numpy()).all()
    # along z, nobody pushed in _Fx: 1.4 N for 1.3 N of zero
    assert ours["mae"].mean() < 0.8 * ours["zero_mae"].mean()


@pytest.fixture(scope="module")
def errors(study: FinishedStudy) -> pd.DataFrame:
    """Errors along x, y, z beside the compensated sensor."""
    rows = study.table("force_mae").query("kind == 'compensated' and component in @FORCES")
    return rows.set_index(["during", "recording", "estimate", "component"]).sort_index()


IN_CONTACT = {  # MAE of F^map in x, y, z [N]
    TABLE_6_1: [3.3, 3.6, 2.1],
    "Movement_No10_Standstill_ForceSensor_All": [4.5, 5.8, 4.0],
    "Movement_No10_Standstill_ForceSensor_Fx": [2.8, 5.8, 1.8],
}
PUSHED = [*product(IN_CONTACT, FORCES)]
SMALL_ALONG_X = pytest.mark.xfail(
    strict=True, reason="too small along x: slope 0.83, that of least squares is 0.85"
)


@pytest.mark.parametrize("recording", IN_CONTACT)
def test_forces_are_right_where_there_is_a_contact(errors: pd.DataFrame, recording: str) -> None:
    """Nearer than least squares without a prior."""
    contact, free = (errors.loc[during, recording] for during in ("contact", "free"))
    ours, plain = contact.loc["Fmap"], contact.loc["least_squares"]
    assert (ours["mae"] <= IN_CONTACT[recording]).all()
    assert ours["mae"].mean() <= 1.05 * plain["mae"].mean()
    # after the last push of _Fx, an alarm is false
    assert (free.loc["Fmap", "mae"] < (1.0 if recording == ACROSS_THE_PUSH[0] else 0.3)).all()
    assert (free.loc["Fmap", "coverage95"] >= 0.97).all()


@pytest.mark.parametrize(("recording", "axis"), PUSHED)
def test_bands_hold_where_there_is_a_contact(
    errors: pd.DataFrame, recording: str, axis: str
) -> None:
    """On all axes together, and on none much less."""
    held = errors.loc[("contact", recording, "Fmap"), "coverage95"]
    assert held.mean() >= 0.90
    assert held[axis] >= 0.89


WIDE_ALONG_Z = pytest.mark.xfail(
    strict=True,
    reason="21.0 N for 19.7 N of zero: the price of a band that holds near singularities",
)
ACROSS_THE_PUSH = "Movement_No10_Standstill_ForceSensor_Fx", "Fz"


@pytest.mark.parametrize(
    ("recording", "axis"),
    [pytest.param(*own, marks=[WIDE_ALONG_Z] * (own == ACROSS_THE_PUSH)) for own in PUSHED],
)
def test_bands_are_worth_their_width(errors: pd.DataFrame, recording: str, axis: str) -> None:
    ours = errors.loc["contact", recording, "Fmap", axis]
    assert ours["interval_score95"] < ours["zero_interval_score95"]


@pytest.mark.parametrize(("recording", "axis"), PUSHED)
def test_a_prior_costs_no_axis_more_than_a_twentieth(
    errors: pd.DataFrame, recording: str, axis: str
) -> None:
    """Beside least squares, which has none; 2.6 N for 2.3 N along x of pushes along y."""
    mae = errors.loc[("contact", recording), "mae"]
    most = 1.2 if (recording, axis) == (ACROSS_THE_PUSH[0], "Fx") else 1.05
    assert mae["Fmap", axis] <= most * mae["least_squares", axis]


@pytest.mark.parametrize("axis", [pytest.param("Fx", marks=SMALL_ALONG_X), "Fz"])
def test_slopes_against_the_sensor_are_near_one(errors: pd.DataFrame, axis: str) -> None:
    assert 0.88 <= errors.loc[("contact", TABLE_6_1, "Fmap", axis), "slope"] <= 1.1


@pytest.mark.parametrize("recording", WITH_SENSOR)
def test_errors_in_contact_stand_apart_from_free_ones(errors: pd.DataFrame, recording: str) -> None:
    """And each in its resampled interval; the whole run lies between."""
    contact, whole, free = (
        errors.loc[during, recording, "Fmap"] for during in ("contact", "all", "free")
    )
    assert (free["mae"] < whole["mae"]).all()
    assert (whole["mae"] < contact["mae"]).all()
    assert (contact["mae_low"] < contact["mae"]).all()
    assert (contact["mae"] < contact["mae_high"]).all()
    assert contact["mean_force"].equals(contact["zero_mae"])
    assert pd.concat([whole, free])["mae_low"].isna().all()


def test_errors_of_contacts_are_of_the_contacts_that_the_sensor_saw(study: FinishedStudy) -> None:
    errors = study.table("contact_errors")
    detection = study.table("detection")
    seen = detection[detection["force_class_n"] == 5].set_index(["recording", "estimate"])
    for key, part in errors.groupby(["recording", "estimate"]):
        if key in seen.index:
            assert part["contact"].nunique() == seen.loc[key, "contacts"]
    whole = errors[errors["component"] == "norm"]
    assert (whole["peak"] >= 5).all()
    assert whole["start_s"].lt(whole["end_s"]).all()


def test_contacts_have_fates_as_they_are_counted(study: FinishedStudy) -> None:
    """By every estimate that raises alarms; by F̂ᵐᵃᵖ, with cause and band where one is found."""
    rows = study.table("contact_errors").query("component == 'norm'").dropna(subset="fate")
    counted = study.table("detection").query("force_class_n == 5")
    counted = counted.set_index(["recording", "estimate"])
    fates = pd.crosstab([rows["recording"], rows["estimate"]], rows["fate"])
    fates = fates.reindex(counted.index).reindex(
        columns=["found", "merged", "missed"], fill_value=0
    )
    assert (fates["found"] == counted["found"]).all()
    assert (fates["merged"] == counted["merged"]).all()
    assert (fates.sum(axis=1) == counted["contacts"]).all()
    ours = rows[rows["estimate"] == "Fmap"]
    assert ours["fate"].value_counts().to_dict() == {"found": 25, "missed": 5}
    found = ours["fate"] == "found"
    assert ours["cause"].notna().eq(found).all()
    assert ours["band"].notna().eq(found).all()


def test_alarms_have_kinds_as_they_are_counted(study: FinishedStudy) -> None:
    """Beside a sensor; without one, all are false where nothing touches the arm."""
    kinds, counted = study.table("contacts"), study.table("detection")
    counted = counted.drop_duplicates(["recording", "estimate"])
    counted = counted.set_index(["recording", "estimate"])
    false = kinds[kinds["kind"] == "false"].value_counts(["recording", "estimate"])
    told = counted.join(false.rename("false")).fillna({"false": 0})
    sensed = told["false_alarms_per_min"].notna()
    rate = told["false"] * told["alarms_per_min"] / told["alarms"].clip(lower=1)
    np.testing.assert_allclose(rate[sensed], told.loc[sensed, "false_alarms_per_min"], atol=1e-6)
    free = [*study.summary().query("role != 'contact'")["recording"]]
    assert {*kinds.loc[kinds["recording"].isin(free), "kind"]} == {"false"}


def test_gains_of_hardly_any_force_are_empty(force: pd.DataFrame) -> None:
    rows = force.reset_index()
    least = np.where(rows["component"].str.startswith("F"), 1.0, 0.1)
    assert (rows["slope"].isna() == (rows["mean_force"] < least)).all()


def test_contacts_are_found_and_none_made_up(study: FinishedStudy) -> None:
    table = study.table("detection")
    sensed = table[table["force_class_n"].notna() & ~table["estimate"].isin(PUBLISHED)]
    assert {*sensed["recording"]} == {*WITH_SENSOR}
    assert (sensed["found"] <= sensed[["contacts", "alarms"]].min(axis=1)).all()
    # one alarm, after the last contact of _Fx, is false
    false = sensed.query("estimate == 'Fmap'").groupby("recording")["false_alarms_per_min"].max()
    assert (false > 0).sum() <= 1
    assert (false <= 3).all()
    assert (sensed["free_time_in_alarm"] <= 0.16).all()
    pushed = sensed.query("recording == @TABLE_6_1 and estimate == 'Fmap'")
    pushed = pushed.set_index("force_class_n").loc[15]
    assert pushed["contacts"] == 10
    assert pushed["found"] >= 8
    assert pushed["median_delay_s"] <= 0.25


@pytest.mark.parametrize(
    ("estimate", "roles"),
    [
        *product(PUBLISHED, [["fit"]]),
        ("Fmap", ["fit", "validate"]),
    ],
)
def test_alarms_are_as_few_as_asked(study: FinishedStudy, estimate: str, roles: list[str]) -> None:
    """At most one a minute: of published estimates on the recordings to fit on, of the new ones on
    all contact-free recordings, each by a fit without its path.
    """
    rows = study.table("detection").query("estimate == @estimate")
    assert {*WITH_SENSOR} <= {*rows["recording"]}
    stated = yaml.safe_load((PROJECT / "workflow/studies/thesis.yaml").read_text())
    free = [own["name"] for own in stated["recordings"] if own["role"] in roles]
    rows = rows[rows["recording"].isin(free)]
    seconds = study.table("recordings").set_index("recording")["duration_s"]
    assert rows["alarms"].sum() <= seconds[rows["recording"]].sum() / 60


def test_the_claimed_threshold_is_counted(study: FinishedStudy) -> None:
    """10 N along z: the thesis calls F̂*_z reliable from there on; it is neither always found nor
    never above it without contact, and F̂ᵐᵃᵖ is nearer to both.
    """
    table = study.table("fixed_threshold")
    along = table[table["component"] == "Fz"].set_index(["recording", "estimate"])
    pushed = along.loc[TABLE_6_1]
    assert pushed["pushes"].min() == pushed["pushes"].max() > 5
    assert pushed.loc["F*", "found"] < pushed.loc["Fmap", "found"] <= pushed.loc["F*", "pushes"]
    free = along.loc["Movement_No9_Singularity_Free_NoDist", "time_above"]
    assert free["F*"] > 0.1
    assert free["Fmap"] == 0


def test_an_arm_without_payload_carries_none(study: FinishedStudy) -> None:
    """Beyond what is declared, in motion."""
    payload = study.table("payload")
    assert len(payload) == 12
    assert (payload["low"] < 0).all()
    assert (payload["high"] > 0).all()
    assert (payload["taken"] == "no").all()


def test_the_controllers_model_is_recovered(torque: pd.DataFrame, study: FinishedStudy) -> None:
    rows = torque.query("motion == 'target' and model == 'identified'")
    assert rows["recording"].nunique() == 15
    assert rows["mae"].max() < 0.001
    parameters = study.table("parameters")
    assert len(parameters) == 40
    assert (parameters["determined"] == "yes").all()


@pytest.mark.parametrize(
    ("kind", "expected"), [("printed", [6.40, 3.31, 4.63]), ("corrected", [2.90, 2.39, 3.51])]
)
def test_errors_of_no_force_are_known(
    force: pd.DataFrame, kind: str, expected: list[float]
) -> None:
    """Against the raw and the bias-free sensor, computed independently [N]."""
    rows = force.query("kind == @kind and estimate == 'Fu' and during == 'all'")
    np.testing.assert_allclose(rows["zero_mae"][:3], expected, atol=0.006)


def test_tool_vector_is_the_origin_of_frame_6(thesis_results: Path) -> None:
    """The controller's own forward kinematics, to its resolution of 0.1 mm."""
    for folder in (thesis_results / "recordings").iterdir():
        robot = read_table(folder / "robot.parquet")
        pose = channel(robot, "actual_TCP_pose")[:, :3]
        origin = channel(read_table(folder / "kinematics.parquet"), "o6", 3)
        received = ~robot["interpolated"].to_numpy()
        assert np.abs(pose - origin)[received].max() < 2e-4


def test_tool_speed_is_the_jacobian_times_the_joint_speed(thesis_results: Path) -> None:
    folder = thesis_results / "recordings" / TABLE_5_6
    robot, kinematics = (read_table(folder / f"{n}.parquet") for n in ("robot", "kinematics"))
    J = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    speed = (J @ channel(robot, "actual_qd")[..., None])[..., 0]
    assert np.abs(speed - channel(robot, "actual_TCP_speed")).mean() < 2e-3


@pytest.fixture(scope="module")
def clocks(study: FinishedStudy) -> pd.DataFrame:
    table = study.table("clocks")
    return table.set_index(["recording", "device"])


CLOCKS = {  # offset [s], drift [ppm]: a fit to linear and angular acceleration, made apart
    "Movement_No4_Acc": (-0.081, -2690),
    TABLE_5_6: (-0.078, -3170),
    "Movement_No6_Acc_slow_Verify_Model": (-0.064, -3270),
    "Movement_No7_Acc_slow_Verify_Model_short": (-0.080, -3040),
    "Movement_No8_Singularity_Free_1": (-0.115, -4310),
    TABLE_5_7: (-0.074, -2940),
}
POORLY = ["Movement_No4_Acc", "Movement_No8_Singularity_Free_1"]  # hardly any turning; 16 s


@pytest.mark.parametrize("name", CLOCKS)
def test_clocks_of_the_imu_are_found(study: FinishedStudy, clocks: pd.DataFrame, name: str) -> None:
    """Within 20 ms of the reference in the middle of the record, where it is known best; and
    throughout, but where the reference leaves more of the accelerometer's reading unexplained.
    """
    own, (offset, drift) = clocks.loc[(name, "imu")], CLOCKS[name]
    recordings = study.table("recordings").set_index("recording")
    middle = recordings.loc[name, "duration_s"] / 2
    off, drift_off = own["offset_s"] - offset, own["drift_ppm"] - drift
    assert own["method"] == "angular rate"
    assert abs(off + 1e-6 * drift_off * middle) < 0.02
    if name not in (*POORLY, TABLE_5_7):
        assert abs(off) < min(0.01, 2 * own["offset_std_s"])
        assert abs(drift_off) < min(300, 2 * own["drift_std_ppm"])


def test_clocks_come_with_their_error(thesis_results: Path, clocks: pd.DataFrame) -> None:
    """Where the arm stood, that of the stamps."""
    force = clocks.loc[(TABLE_6_1, "force")]
    drifts = read_json(thesis_results / "parameters" / "ur5" / "drifts.json")["lab-pc"]
    assert force["offset_s"] == pytest.approx(-0.0056 + drifts["start"], abs=1e-3)
    assert (clocks["offset_std_s"] > 0).all()
    assert (clocks["end_std_s"] >= clocks["offset_std_s"]).all()
    assert "stamps" in clocks.loc[("Movement_No10_Standstill_WDist", "imu"), "method"]
    error = clocks.loc[[(name, "imu") for name in CLOCKS], "drift_std_ppm"].droplevel("device")
    assert {*error.nlargest(2).index} == {*POORLY}


def test_the_force_sensor_drifts_as_its_host_does(
    thesis_results: Path, clocks: pd.DataFrame
) -> None:
    """No motion tells its clock; that of the IMU on the same host does, in other recordings."""
    force = clocks.xs("force", level="device")
    assert len(force) == 3
    assert (force["method"] == "start stamps, start and drift of its host").all()
    assert force["drift_ppm"].to_numpy() == pytest.approx(-3300, abs=50)
    assert force["drift_std_ppm"].between(50, 400).all()
    assert (force["end_std_s"] < 0.04).all()
    drifts = read_json(thesis_results / "parameters" / "ur5" / "drifts.json")["lab-pc"]
    assert len(drifts["recordings"]) == 6
    assert abs(drifts["start"]) < 3 * drifts["start_std_error"]
    assert abs(1e6 * drifts["drift"] + 3300) < 2 * 1e6 * drifts["std_error"]
    told = clocks[clocks["method"] == "angular rate"]
    apart = (told["drift_ppm"] - 1e6 * drifts["drift"]) / told["drift_std_ppm"]
    assert apart.abs().max() < 3


# The report


@pytest.fixture(scope="module")
def page(thesis_results: Path) -> HtmlElement:
    return fromstring((thesis_results / "report.html").read_text())


@pytest.fixture(scope="module")
def details(thesis_results: Path) -> HtmlElement:
    return fromstring((thesis_results / "details.html").read_text())


def test_the_report_needs_no_network_and_links_to_files_that_exist(
    thesis_results: Path, page: HtmlElement
) -> None:
    for element in page.iter("*"):
        assert element.tag not in ("link", "iframe")
        for name in ("src", "href"):
            places = ("data:", "#", "tables", "figures/", "details.html#", "published.html")
            assert element.get(name, "#").startswith((*places, "configuration.yaml"))
    assert "@import" not in (thesis_results / "report.html").read_text()
    check_links(thesis_results)


def test_the_report_is_well_formed_for_readers(thesis_results: Path, page: HtmlElement) -> None:
    check_brief(thesis_results / "report.html")
    check_results(thesis_results)
    for name in ("report.html", "details.html", "published.html"):
        check_valid(thesis_results / name)
        check_structure(thesis_results / name)
        check_captions(thesis_results / name)
        check_digits(shown_texts(thesis_results / name))
    assert page.get("lang") == "en"


def test_the_report_reads_in_a_browser_and_prints(thesis_results: Path, tmp_path: Path) -> None:
    """The published numbers, too; the demo in all views."""
    for name in ("report.html", "published.html"):
        check_in_browser(thesis_results / name, tmp_path, VIEWS[2:])


LABELS = {"F̂ᵘ": "Fu", "F̂": "F", "F̂*": "F*", "F̂ᵐᵃᵖ": "Fmap", "gated least squares": "least_squares"}
LABELS |= {"plain least squares": "ungated_least_squares"}
DURING = {"in contact": "contact", "free": "free", "whole run": "all"}


def test_the_force_table_shows_each_number_in_its_column(
    details: HtmlElement, force: pd.DataFrame
) -> None:
    of_compensated = force[force["kind"] == "compensated"]
    expected = of_compensated.set_index(["during", "estimate", "component"])
    header, *rows = cells_of(details, f"force-errors-{TABLE_6_1}")
    known = {*expected.index.get_level_values("estimate")}
    assert {LABELS[label] for label in header if label in LABELS} == known
    assert len(rows) == 18
    for row in rows:
        cells = dict(zip(header, row, strict=True))
        during, component = DURING[cells.pop("during")], cells.pop("component")
        for label, cell in cells.items():
            column = "zero_mae" if label == "zero" else "mae"
            value = expected.loc[(during, LABELS.get(label, "Fu"), component.split()[0]), column]
            assert cell.lstrip("▼▲ ") == f"{value:.2f}"


def test_the_report_holds_what_was_promised(thesis_results: Path, page: HtmlElement) -> None:
    text = (thesis_results / "report.html").read_text()
    follows = (thesis_results / "published.html").read_text()
    assert re.search(r"torques 5\.11", follows)
    assert "Made by commit" in text
    details = (thesis_results / "details.html").read_text()
    assert "cutoff_hz: 1.454" in (thesis_results / "configuration.yaml").read_text()
    assert "pytorch-kinematics" in details
    assert page.xpath("//a[@href='published.html']")
    published = (thesis_results / "published.html").read_text()
    assert "erratum" in published
    for drawn in ("positions", "torques_older", "forces_printed", "accelerations_published"):
        assert re.search(rf'<figure id="[^"]*-{drawn}"', published), drawn
    assert len([*page.iter("img")]) >= 6
    scripts = re.findall(r"<script.*?</script>", text, re.DOTALL)  # of the closer look
    assert len(scripts) > 10
    assert sum(map(len, scripts)) < 300_000


@pytest.mark.parametrize("recording", [TABLE_6_1, STANDSTILL[0]])
def test_the_arm_is_drawn_as_its_tables_say(
    thesis_results: Path, recording: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(thesis_results.parents[1])
    check_arm(thesis_results, recording)


def test_the_pdf_says_the_same(thesis_results: Path) -> None:
    check_pdf(thesis_results)


@pytest.mark.parametrize("during", ["motion", "rest"])
def test_bands_of_accelerations_hold_on_recordings_that_they_have_not_seen(
    study: FinishedStudy, during: str
) -> None:
    """Encoders beside the IMU below 5 Hz: of each component, over recordings."""
    table = study.table("acceleration_bands")
    held = table[(table["range"] == "below 5 Hz") & (table["during"] == during)]
    shares = held.groupby("component")["held"].mean()
    assert shares.between(0.92, 0.98).all(), shares


def test_encoders_tell_vibrations(study: FinishedStudy) -> None:
    """Above 5 Hz, at most 0.5 m/s² from the IMU; without vibrations it was up to 0.8 m/s²."""
    table = study.table("acceleration_bands")
    rows = table.query("recording == @TABLE_5_7 and range == '5 to 20 Hz' and during == 'motion'")
    assert (rows[rows["component"].isin(["x", "y", "z"])]["rms"] < 0.5).all()
