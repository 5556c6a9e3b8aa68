"""What other arms tell of one that no recording was fitted to: the thesis's UR5."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.conftest import build_once
from ur5lib.force.sensed_contact import in_contact
from ur5lib.identification.currents import parameters
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array
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

    workflow = build_once(common_folder / "unfitted", prepare, "--until", "judge_sensor")
    return workflow.folder / "results" / "thesis"


def test_friction_is_that_of_other_arms(unfitted: Path) -> None:
    friction = read_record(Friction, unfitted / "parameters" / "ur5" / "friction.json")
    assert friction.from_ == []
    assert not any(row.determined for row in parameters(friction.fit))


def errors_in_contact(unfitted: Path, name: str) -> tuple[Array, Array, Array]:
    """Return the true force, the error and half of the 95 % band (N, 3) [N] while touched."""
    folder = unfitted / "recordings" / name
    forces = Forces.read(folder / "forces.parquet")
    true = SensorWrenches.read(folder / "sensor.parquet").wrench["compensated"][:, :3]
    force, std = forces.wrench["Fmap"][:, :3], forces.std["Fmap"][:, :3]
    during = in_contact(np.linalg.norm(true, axis=1)) & np.isfinite(force).all(axis=1)
    return true[during], np.abs(force - true)[during], NORMAL95 * std[during]


@pytest.mark.parametrize("name", TOUCHED)
def test_forces_in_contact_are_better_than_zero(unfitted: Path, name: str) -> None:
    true, error, half = errors_in_contact(unfitted, name)
    assert error.mean() < 0.8 * np.abs(true).mean()
    assert (error <= half).mean() >= 0.90


TOO_WIDE = pytest.mark.xfail(
    strict=True,
    reason="all inside: without a fit, no band is narrower than with one path",
)
WIDE = [pytest.param(name, marks=[TOO_WIDE] * (name == TOUCHED[2])) for name in TOUCHED]


@pytest.mark.parametrize("name", WIDE)
def test_bands_of_forces_are_no_wider_than_promised(unfitted: Path, name: str) -> None:
    _, error, half = errors_in_contact(unfitted, name)
    assert (error <= half).mean() <= 0.99
