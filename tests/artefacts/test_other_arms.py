"""What other arms tell of one that no recording was fitted to: the thesis's UR5."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.conftest import build_once
from tests.library.test_benchmarks import run_benchmark
from ur5lib.force.detection import in_contact
from ur5lib.identification.currents import parameters
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.pipeline.records.friction import Friction
from ur5lib.tables import read_record
from ur5lib.timeseries.metrics import NORMAL95

TOUCHED = [
    "Movement_No9_Singularity_Free_ForceSensor",
    "Movement_No10_Standstill_ForceSensor_All",
    "Movement_No10_Standstill_ForceSensor_Fx",
]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def unfitted(thesis_data: Path, common_folder: Path) -> Path:
    """Results of the recordings in contact alone; as of the thesis, its UR5 is no known arm."""

    def prepare(folder: Path) -> None:
        (folder / "raw").mkdir()
        (folder / "raw" / "thesis").symlink_to(thesis_data)
        study = yaml.safe_load((folder / "workflow" / "studies" / "thesis.yaml").read_text())
        study["recordings"] = [own for own in study["recordings"] if own["name"] in TOUCHED]
        del study["reference"]
        (folder / "config.yaml").write_text(yaml.safe_dump(study))

    workflow = build_once(common_folder / "unfitted", prepare, "--until", "compare_forces")
    return workflow.folder / "results" / "thesis"


def test_friction_is_that_of_other_arms(unfitted: Path) -> None:
    friction = read_record(Friction, unfitted / "parameters" / "ur5" / "friction.json")
    assert friction.from_ == []
    assert not any(row.determined for row in parameters(friction.fit))


def test_forces_in_contact_are_better_than_zero_and_inside_their_band(unfitted: Path) -> None:
    """All contacts of one recording may be inside; of all recordings, not more than promised."""
    inside = []
    for name in TOUCHED:
        folder = unfitted / "recordings" / name
        forces = Forces.read(folder / "forces.parquet")
        true = SensorWrenches.read(folder / "sensor.parquet").wrench["compensated"][:, :3]
        force, std = forces.wrench["Fmap"][:, :3], forces.std["Fmap"][:, :3]
        during = in_contact(np.linalg.norm(true, axis=1)) & np.isfinite(force).all(axis=1)
        error = np.abs(force - true)[during]
        assert error.mean() < 0.8 * np.abs(true[during]).mean(), name
        inside.append(error <= NORMAL95 * std[during])
        assert inside[-1].mean() >= 0.90, name
    assert np.concatenate(inside).mean() <= 0.99


def test_each_arm_is_judged_by_the_others(thesis_results: Path) -> None:
    printed = run_benchmark("population", thesis_results.parents[1])
    [ur5] = [line for line in printed.splitlines() if line.startswith("ur5 of thesis")]
    ratio = float(ur5.split("expected ")[1].split(";")[0])
    without = float(ur5.split("no friction ")[1].split(";")[0])
    assert ratio < without
    assert "ur10e of ur10e: not built" in printed
