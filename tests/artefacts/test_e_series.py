"""A simulated e-Series arm on a ceiling with a tool, at 125 and at 500 Hz, by all steps.

Beside it, a large arm.
"""

import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from tests.command import Command
from tests.compensated import check_formula
from tests.conftest import Workflow, build_once, table_of_topic
from tests.in_memory import assert_draws_as_in_report
from ur5lib.commands.exported import exported
from ur5lib.errors import InputError
from ur5lib.records.premises import Premises
from ur5lib.study.reading import read_study, study_text
from ur5lib.tables import read_csv, read_json, read_record

pytestmark = pytest.mark.slow

TOOL = {"mass": 1.2, "center_of_mass": [0, 0, 0.05], "tcp": [0, 0, 0.12, 0, 0, 0]}
TOOL["inertia"] = [4e-3, 3e-3, 2e-3, 0, 0, 5e-4]
WRIST = {"bias": [3, -3, 3, 0.1, -0.1, 0.1], "rotation_deg": [3, 0, 4], "scale": 0.9}
PUSH = {"kind": "push", "start_s": 4, "seconds": 4, "force": [60, 30, -45]}


def recording(
    name: str, format: str, role: str, draw: int, seconds: int = 12, **more: Any
) -> dict[str, Any]:
    trajectory = {"kind": "fourier", "draw": draw, "period_s": 6, "limit_share": 0.3}
    plan = {"trajectory": trajectory, "seconds": seconds, "seed": draw} | more
    return {"name": name, "format": format, "role": role, "simulate": plan}


STUDY = {
    "study": "e_series",
    "title": "A UR5e on a ceiling",
    "robot": {"arm": "ur5e", "name": "cell-2", "mounting": "ceiling", "tool": TOOL},
    "recordings": [
        recording("fit_1", "rtde-csv", "fit", 1),
        recording("fit_2", "realtime-stream", "fit", 2),
        recording("fit_3", "realtime-stream", "fit", 4),
        recording("pushed", "rtde-csv", "contact", 3, contacts=[PUSH], wrist_sensor=WRIST),
        recording("large", "realtime-stream", "fit", 5, 8) | {"robot": "ur30"},
    ],
    "settings": {
        "lowpass": {"motion": {"cutoff_hz": 80}},  # beyond Nyquist of two of them
        "pushes": {"per_arm": 90},
    },
}


@pytest.fixture(scope="module")
def workflow(common_folder: Path) -> Workflow:
    def prepare(folder: Path) -> None:
        (folder / "config.yaml").write_text(yaml.safe_dump(STUDY, sort_keys=False))

    return build_once(common_folder / "e_series", prepare)


@pytest.fixture(scope="module")
def results(workflow: Workflow) -> Path:
    return workflow.folder / "results" / "e_series"


@pytest.fixture(scope="module")
def truth(results: Path) -> pd.DataFrame:
    return table_of_topic(results, "truth")


def test_models_of_both_arms_draw_what_the_report_shows(results: Path, tmp_path: Path) -> None:
    assert_draws_as_in_report(results, tmp_path)


def test_each_recording_has_its_own_rate(results: Path) -> None:
    quality = [read_json(results / f"recordings/{n}/quality.json") for n in ("fit_1", "fit_2")]
    assert [one["period_s"] for one in quality] == [0.002, 0.008]


def test_the_tool_is_carried_and_the_controller_given_it(results: Path) -> None:
    """Where the format says so: then both agree."""
    files = [results / f"recordings/{n}/premises.json" for n in ("fit_1", "fit_2")]
    known = [read_record(Premises, file) for file in files]
    assert [own.load.mass for own in known] == [1.2, 1.2]
    configured = [own.load.configured for own in known]
    assert [payload and payload.mass for payload in configured] == [1.2, None]
    found = [one.severity for own in known for one in own.contradictions.findings]
    assert {*found} == {"note"}


@pytest.mark.parametrize(("arm", "most"), [("cell-2", 0.25), ("ur30", 0.35)])
def test_an_arm_s_parameters_come_back(truth: pd.DataFrame, arm: str, most: float) -> None:
    """Its identified model has its torques; most: error of its torque constants, relative."""
    rows = truth[truth["robot"] == arm]
    for quantity, share in (("rotor_inertia", 1e-3), ("torque_constant", most)):
        found = rows[rows["quantity"] == quantity]
        assert len(found) == 6
        assert (found["estimate"] / found["truth"] - 1).abs().max() < share
    torques = rows[(rows["quantity"] == "torque_rmse") & (rows["method"] == "Model identified")]
    assert len(torques) == (4 * 6 if arm == "cell-2" else 6)
    assert (torques["estimate"] < 1e-3 * torques["zero"].clip(upper=1.0)).all()  # Nm


def test_three_paths_tell_them_sharply(truth: pd.DataFrame) -> None:
    for quantity, most in (("rotor_inertia", 1e-5), ("base_parameter", 1e-4)):
        rows = truth[(truth["quantity"] == quantity) & (truth["robot"] == "cell-2")]
        assert len(rows)
        assert (rows["estimate"] - rows["truth"]).abs().max() < most


def test_the_wrist_sensor_is_compared_and_audited(results: Path) -> None:
    errors = read_csv(results / "tables" / "force_mae.csv")
    assert {*errors["recording"]} == {"pushed"}
    assert {*errors["kind"]} == {"corrected", "compensated"}  # it has no stamps of its own
    audit = table_of_topic(results, "audit").set_index(["quantity", "component"])
    for (quantity, *parts), truth in {
        ("turn", "x"): 3, ("turn", "z"): 4, ("scale", "y"): 0.9, ("bias", "Fx"): 3
    }.items():  # fmt: skip
        row = audit.loc[(quantity, *parts)]
        assert abs(row["value"] - truth) < 4 * row["std_error"]
        assert row["verdict"] != "right"


def test_the_wrist_sensor_is_exported_with_its_formula(results: Path) -> None:
    known = check_formula(exported("cell-2", None, "sensor", results, ""), results, "pushed")
    assert known["reading"] == "ft_raw_wrench"
    assert known["inertia"] == TOOL["inertia"]
    assert known["temperature"] == 30.0  # of the stand
    assert known["gravity"][2] > 9  # on a ceiling
    with pytest.raises(InputError, match="no reading of a force sensor on ur30"):
        exported("ur30", None, "sensor", results, "")


def test_questions_are_answered_from_the_tables(
    workflow: Workflow, run_ur5: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(workflow.folder)
    audit = run_ur5("audit", "config.yaml").out
    assert "the scale is 0.90" in audit
    assert re.search(r"its axes are turned by (4\.[89]|5\.[012])°", audit)
    assert "set_payload" not in audit  # the scale is wrong, not the payload
    payload = run_ur5("payload", "config.yaml").out
    assert payload.count("by the currents 1.") == 4
    assert payload.count("by the wrist sensor") == 1


def test_the_report_has_a_section_on_it(results: Path) -> None:
    report = (results / "report.html").read_text()
    assert "The wrist sensor" in report
    assert "cell-2" in report


def test_the_study_that_was_run_can_be_run_again(results: Path) -> None:
    again = read_study(results / "configuration.yaml")
    assert study_text(again) == (results / "configuration.yaml").read_text()


def test_the_push_is_found(truth: pd.DataFrame) -> None:
    rows = truth[(truth["quantity"] == "wrench_mae") & (truth["recording"] == "pushed")]
    forces = rows[(rows["method"] == "Fmap") & rows["index"].isin(["Fx", "Fy", "Fz"])]
    assert len(forces) == 3
    assert (forces["estimate"] < 0.6 * forces["zero"]).all()
