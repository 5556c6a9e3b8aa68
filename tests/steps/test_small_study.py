"""What the steps make of the small study, by its files."""

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Workflow
from tests.in_memory import assert_draws_as_in_report
from tests.made_tables import COLUMNS
from ur5lib.force.estimators import NEW, UNGATED
from ur5lib.records.motion import Alignment
from ur5lib.records.quality import Quality
from ur5lib.robots.description import Robot
from ur5lib.tables import read_csv, read_record, read_table


@pytest.fixture(scope="module")
def results(built_workflow: Workflow) -> Path:
    return built_workflow.folder / "results" / "small"


def test_signals_are_on_the_robots_clock(results: Path) -> None:
    signals = read_table(results / "recordings" / "pushed" / "signals.parquet")
    np.testing.assert_allclose(np.diff(signals["time"]), 0.008)
    push = signals["time"].between(2.4, 3.2)
    assert signals.loc[push, "ft_fx"].mean() == pytest.approx(15, abs=0.1)
    alignment = read_record(Alignment, results / "recordings" / "pushed" / "alignment.json")
    clock = alignment.clocks["force"]
    assert clock.offset == pytest.approx(0.005, abs=1e-6)
    assert clock.drift is None
    # absent devices have no columns
    still = read_table(results / "recordings" / "still" / "signals.parquet")
    assert not still.filter(regex="ft_|imu_").columns.any()
    quality = read_record(Quality, results / "recordings" / "still" / "quality.json")
    assert quality.devices == ["robot"]


def test_its_model_draws_what_the_report_shows(results: Path, tmp_path: Path) -> None:
    assert_draws_as_in_report(results, tmp_path)


def test_tables_have_a_row_for_each_value(results: Path, ur5: Robot) -> None:
    """Without published values, of the controller's force alone beside the project's own."""
    tables = {name: read_csv(results / "tables" / f"{name}.csv") for name in COLUMNS}
    assert {name: [*own] for name, own in tables.items()} == COLUMNS
    torque = tables["torque_mae"]
    models = {*ur5.models, "identified"}
    assert len(torque) == 2 * 2 * len(models) * 6  # recordings, targets and motion, ..., joints
    force = tables["force_mae"]
    assert set(force["recording"]) == {"pushed"}
    estimates = force.groupby("kind")["estimate"].unique().map(set)
    assert estimates["printed"] == {"Fu"}
    assert estimates["corrected"] == estimates["compensated"] - {UNGATED} >= {"Fu", "Fmap"}
    assert estimates["corrected"] - {"Fu"} <= {*NEW}
    parts = force.groupby(["kind", "estimate", "during"]).size()
    assert (parts == 6).all()  # components
    assert len(parts) == sum(map(len, estimates)) * force["during"].nunique()
    assert {"all", "contact"} <= {*force["during"]}
    errors = tables["contact_errors"]
    assert errors.groupby("estimate")["contact"].nunique().eq(1).all()
    assert {*errors["estimate"]} == estimates["compensated"]
