"""A sensor of three forces: imported and compared without moments."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.conftest import Workflow, copy_project
from ur5lib.force.estimators import LEADING
from ur5lib.records.codes import Found
from ur5lib.records.force_errors import Compared
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import read_json, read_record

PUSHES = [
    {"kind": "push", "start_s": start, "seconds": 2.0, "force": force}
    for start, force in ((2.0, [30, 0, 0]), (5.0, [0, -30, 0]), (8.0, [0, 0, 30]))
]
NAMES = ("log", "apart")  # of the file that was imported, and of the entry written by hand
MOVED = {"trajectory": {"kind": "fourier", "period_s": 11}, "seconds": 11}
FIT = {"name": "moved", "robot": "ur5", "format": "rtde-csv", "role": "fit", "simulate": MOVED}


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """A study of one pushed run: imported with its forces in the same file, and with these apart.

    The moments of the simulated sensor are dropped.
    """
    workflow = Workflow(copy_project(tmp_path_factory.mktemp("forces") / "project"))
    folder = workflow.folder / "raw" / "made" / "pushed"
    pushed = MOVED | {"seed": 1, "contacts": PUSHES, "force_sensor": {}}
    plan, robot = SimulatedRecording.model_validate(pushed), load_robot(robot_path("ur5"))
    simulate(robot, plan, "rtde-csv", folder, workflow.folder / "truth")
    apart = without_moments(folder)
    (imported,) = yaml.safe_load(workflow.ur5("import", "raw/made/pushed/log.csv"))
    study: dict[str, Any] = {"study": "forces", "title": "Three forces"}
    study["recordings"] = [FIT, imported, apart]
    (workflow.folder / "config.yaml").write_text(yaml.safe_dump(study))
    workflow.build(
        "--", *(f"results/forces/recordings/{name}/beside_sensor.json" for name in NAMES)
    )
    return workflow


def without_moments(folder: Path) -> dict[str, Any]:
    """Write the robot's file with forces, and one of forces alone; return the entry of this one."""
    sensor = np.loadtxt(folder / "force_sensor.csv", delimiter=",")[:, :4]
    np.savetxt(folder / "forces.csv", sensor, delimiter=",", fmt="%.6f")
    robot = pd.read_csv(folder / "robot.csv")
    since = robot["timestamp"] - robot["timestamp"][0]
    forces = {f"F{axis}": np.interp(since, *sensor[:, [0, k]].T) for k, axis in enumerate("xyz", 1)}
    robot.assign(**forces).to_csv(folder / "log.csv", index=False)
    files = {"file": "robot.csv", "folder": str(folder)}
    files |= {"force_sensor": {"file": "forces.csv", "columns": ["time", "ft_f"]}}
    return {"name": "apart", "robot": "ur5", "format": "rtde-csv", "role": "contact"} | files


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_forces_are_compared_and_moments_are_not_invented(compared: Workflow, name: str) -> None:
    folder = compared.folder / "results/forces/recordings" / name
    beside = read_record(Compared, folder / "beside_sensor.json")
    assert beside.sensed is not None
    assert beside.sensed.contacts == len(PUSHES)
    about = "compensated", LEADING, "contact"
    rows = [row for row in beside.errors if (row.kind, row.estimate, row.during) == about]
    assert [row.component for row in rows] == ["Fx", "Fy", "Fz"]
    assert all(row.mae < 0.8 * row.zero_mae for row in rows)
    table = pd.read_parquet(folder / "sensor.parquet")
    assert table["compensated_Fx"].notna().mean() > 0.9
    assert table[[f"compensated_n{axis}" for axis in "xyz"]].isna().all(axis=None)
    findings = read_json(folder / "quality.json")["findings"]
    assert Found.NO_MOMENTS in [one["code"] for one in findings]
