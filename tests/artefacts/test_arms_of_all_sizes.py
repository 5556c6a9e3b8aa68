"""Arms of all sizes, simulated and identified: what comes back is what was put in."""

from pathlib import Path

import pandas as pd
import pytest
import yaml

from tests.conftest import Workflow, copy_project
from ur5lib.tables import read_csv

pytestmark = pytest.mark.slow

ARMS = ["ur3", "ur30"]  # between them: the demonstration's UR5, the UR5e of test_e_series.py
EXCITING = {"kind": "fourier", "draw": 3, "period_s": 6, "limit_share": 0.4, "amplitude_rad": 1.0}


def recording(arm: str) -> dict[str, object]:
    plan = {"trajectory": EXCITING, "seconds": 8, "seed": 1}
    return {"name": arm, "robot": arm, "format": "realtime-stream", "role": "fit", "simulate": plan}


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    made = Workflow(copy_project(tmp_path_factory.mktemp("arms") / "project"))
    study = {"study": "arms", "title": "Two arms", "recordings": list(map(recording, ARMS))}
    (made.folder / "config.yaml").write_text(yaml.safe_dump(study, sort_keys=False))
    made.build("--until", "compare_with_truth")
    return read_csv(Path(made.folder, "results", "arms", "tables", "truth.csv"))


@pytest.mark.parametrize("arm", ARMS)
def test_its_parameters_come_back(truth: pd.DataFrame, arm: str) -> None:
    rows = truth[truth["robot"] == arm]
    for quantity, count in (("rotor_inertia", 6), ("torque_constant", 6)):
        found = rows[rows["quantity"] == quantity]
        assert len(found) == count
        most = 1e-3 if quantity == "rotor_inertia" else 0.35
        assert (found["estimate"] / found["truth"] - 1).abs().max() < most


@pytest.mark.parametrize("arm", ARMS)
def test_its_identified_model_has_its_torques(truth: pd.DataFrame, arm: str) -> None:
    rows = truth[(truth["robot"] == arm) & (truth["quantity"] == "torque_rmse")]
    identified = rows[rows["method"] == "Model identified"]
    assert len(identified) == 6
    assert (identified["estimate"] < 1e-3 * identified["zero"].clip(lower=1.0)).all()
