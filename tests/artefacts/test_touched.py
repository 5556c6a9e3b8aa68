"""A UR5e led by hand, declared as if nothing touched it: what its sensor reads beats the role."""

from pathlib import Path

import pytest
import yaml

from tests.conftest import Workflow, build_once, shared_folder
from ur5lib.records.scene import Scene
from ur5lib.tables import read_csv, read_record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def led(common_folder: Path) -> Path:
    """Results of the study ur5e-rtde with its recording in freedrive as `validate`."""
    raw = shared_folder("ur5e", "`ur5 fetch ur5e-rtde` fetches them")

    def prepare(folder: Path) -> None:
        (folder / "raw").mkdir()
        (folder / "raw" / "ur5e-rtde").symlink_to(raw)
        study = yaml.safe_load((folder / "workflow" / "studies" / "ur5e-rtde.yaml").read_text())
        study["recordings"][1]["role"] = "validate"
        (folder / "config.yaml").write_text(yaml.safe_dump(study))

    until = "--until", "make_tables", "draw_figures"
    workflow: Workflow = build_once(common_folder / "led", prepare, *until)
    return workflow.folder / "results" / "ur5e-rtde"


@pytest.mark.parametrize(
    ("recording", "count", "largest"), [("freedrive", 2, 34), ("moving", 3, 43)]
)
def test_its_sensor_beats_its_role(led: Path, recording: str, count: int, largest: int) -> None:
    """An error takes the place of the warning about the same readings."""
    rows = read_csv(led / "tables" / "quality.csv").query("recording == @recording")
    of_sensor = rows[rows["device"] == "force"].set_index("code")
    assert "contact" not in of_sensor.index
    error = of_sensor.loc["touched"]
    assert (error["severity"], error["count"]) == ("error", count)
    assert f"up to {largest} N in {count} contacts" in error["detail"]


@pytest.mark.parametrize("recording", ["freedrive", "moving"])
def test_replay_calls_nothing_there_a_false_alarm(led: Path, recording: str) -> None:
    scene = read_record(Scene, led / "figures" / recording / "scene.json")
    assert scene.contacts
    assert not scene.free


def test_its_contacts_have_fates(led: Path) -> None:
    rows = read_csv(led / "tables" / "contact_errors.csv").dropna(subset="fate")
    assert {*rows["component"]} == {"norm"}
    assert (
        rows.query("recording == 'moving' and estimate == 'Fmap'")["fate"].eq("missed").sum() == 3
    )
