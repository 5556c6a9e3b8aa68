"""From a URDF and two logs to a report, in the commands of docs/robots.md: an arm that is no UR."""

import html
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio
import pytest
import yaml

from benchmarks.abb_like import UNSEEN
from benchmarks.harness.abb_like import JOINTS, MadeUpArm, write_files
from tests.conftest import PROJECT, Workflow, copy_project
from tests.examples import examples
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import load_robot

pytestmark = pytest.mark.slow
SEED, DAY = 0, UNSEEN["same day"]
FEW_PUSHES = "\nsettings: {pushes: {per_arm: 90}}\n"


@pytest.fixture(scope="module")
def made() -> MadeUpArm:
    return MadeUpArm(SEED)


@pytest.fixture(scope="module")
def cell(made: MadeUpArm, tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """The arm described, its file edited, and the chapter's study, which is not yet built."""
    workflow = Workflow(copy_project(tmp_path_factory.mktemp("cell") / "project"))
    raw, file = workflow.folder / "raw" / "cell", workflow.folder / "robots" / "my-arm.yaml"
    write_files(made, SEED, raw, {"fit": (6, DAY), "validate": (2, DAY)})
    told = workflow.ur5("describe", "raw/cell/arm.urdf", "--name", "my-arm")
    assert "links: unknown" in told
    edited = made.as_described(yaml.safe_load(file.read_text()))
    file.write_text(yaml.safe_dump(edited, sort_keys=False))
    blocks = examples(PROJECT / "docs" / "robots.md")
    (study,) = (block.text for block in blocks if "study: cell" in block.text)
    (workflow.folder / "cell.yaml").write_text(study + FEW_PUSHES)
    return workflow


@pytest.fixture(scope="module")
def results(cell: Workflow) -> Path:
    cell.build("--configfile", "cell.yaml")
    return cell.folder / "results" / "cell"


def test_an_import_takes_counts_of_motors_for_what_they_are(cell: Workflow) -> None:
    told = cell.ur5("import", "raw/cell/fit.csv", "--robot", "my-arm")
    assert "actual_torque" in told
    assert "deg" not in told
    assert "explains the efforts" not in told


def test_the_check_has_nothing_to_blame(cell: Workflow) -> None:
    told = cell.ur5("check", "cell.yaml")
    assert "(error)" not in told
    assert "(warning)" not in told
    assert "next: ur5 run" in told


def test_bands_hold_on_the_other_path(results: Path) -> None:
    table = pd.read_csv(results / "tables" / "current_rmse.csv")
    rows = table[(table["model"] == "fitted") & (table["recording"] == "other_path")]
    assert len(rows) == JOINTS
    assert rows["coverage95"].min() > 0.85  # of one seed; benchmarks/abb_like.py has the means
    assert rows["r2"].min() > 0.95


def test_gravity_is_that_of_the_true_links(results: Path, made: MadeUpArm) -> None:
    arm = load_robot(results / "parameters" / "my-arm" / "arm.yaml")
    q = np.random.default_rng(0).uniform(-1, 1, (100, JOINTS))
    data = made.model.createData()
    true = np.array([pinocchio.computeGeneralizedGravity(made.model, data, row) for row in q])
    found = LinkModel(arm, arm.chosen_model).gravity_torque(q)
    assert np.abs(found - true).max() < 0.03 * np.abs(true).max()


def test_the_report_speaks_of_torques_and_blames_nothing(results: Path) -> None:
    """But for the names of files, which stay."""
    told = words(results / "report.html")
    quality = pd.read_csv(results / "tables" / "quality.csv")
    assert {*quality["severity"]} == {"note"}
    assert "Gains ○ not known links unknown 0 of 6 Joints whose constant may be used" in told
    assert "cannot be told from the links' masses" in told
    assert re.findall(r"(?i).{30}\bcurrents?\b(?!\.csv).{30}", told) == []


def words(page: Path) -> str:
    """What a page says, without its figures and the study."""
    bare = re.sub(r"(?s)<(script|style|svg|pre)\b.*?</\1>|<[^>]+>", " ", page.read_text())
    return " ".join(html.unescape(bare).split())
