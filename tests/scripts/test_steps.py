"""What the scripts share, and what each makes of one small recording."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import Workflow
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_csv, read_json, read_table


@pytest.fixture
def job(tmp_path: Path) -> SimpleNamespace:
    log = [str(tmp_path / "step.log")]
    return SimpleNamespace(input=1, output=2, params=3, log=log, rule="some_step")


def test_a_step_gets_input_output_and_params(
    job: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, status = [], []
    monkeypatch.setattr("os._exit", status.append)
    run_step(lambda *arguments: given.extend(arguments), job)
    assert given == [1, 2, 3]
    assert status == [0]


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (InputError("mend this"), "some_step: mend this"),
        (KeyError("x"), "some_step: KeyError: 'x'"),
    ],
)
def test_a_failed_step_says_why(
    job: SimpleNamespace,
    error: Exception,
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """One sentence for the terminal, what it printed and the traceback for the log."""

    def fails(*_: object) -> None:
        print("so far so good")
        raise error

    with (tmp_path / "terminal").open("w") as terminal:
        monkeypatch.setattr("sys.__stderr__", terminal)
        with pytest.raises(SystemExit) as stop:
            run_step(fails, job)
    assert stop.value.code == 1
    assert (tmp_path / "terminal").read_text().startswith(sentence)
    log = Path(job.log[0]).read_text()
    assert log.splitlines()[1] == "so far so good"
    assert log.endswith(sentence + "\n") or f"{sentence} (traceback in {job.log[0]})\n" in log
    assert ("Traceback" in log) == (not isinstance(error, InputError))


# The small study's steps


@pytest.fixture(scope="module")
def results(built_workflow: Workflow) -> Path:
    return built_workflow.folder / "results" / "small"


def test_signals_are_on_the_robots_clock(results: Path) -> None:
    signals = read_table(results / "recordings" / "pushed" / "signals.parquet")
    np.testing.assert_allclose(np.diff(signals["time"]), 0.008)
    push = signals["time"].between(2.4, 3.2)
    assert signals.loc[push, "ft_fx"].mean() == pytest.approx(15, abs=0.1)
    clock = read_json(results / "recordings" / "pushed" / "clocks.json")["force"]
    assert clock["offset"] == pytest.approx(0.005, abs=1e-6)
    assert clock["drift"] is None


def test_absent_devices_have_no_columns(results: Path) -> None:
    signals = read_table(results / "recordings" / "still" / "signals.parquet")
    assert not signals.filter(regex="ft_|imu_").columns.any()
    assert read_json(results / "recordings" / "still" / "quality.json")["devices"] == ["robot"]


def test_motion_is_the_derivative_of_itself(results: Path) -> None:
    motion = read_table(results / "recordings" / "still" / "motion.parquet")
    targets = read_table(results / "recordings" / "still" / "signals.parquet")
    inside = slice(40, -40)  # away from the ends of the filter
    for name, target, tolerance in (("q", "target_q", 1e-3), ("qdd", "target_qdd", 0.05)):
        np.testing.assert_allclose(
            channel(motion, name)[inside], channel(targets, target)[inside], atol=tolerance
        )


def test_tables_have_a_row_for_each_value(results: Path, ur5: Robot) -> None:
    torque = read_csv(results / "tables" / "torque_mae.csv")
    looped = ur5.models.keys() & ur5.closed_loop_gains.keys()
    models = {*ur5.models, "identified"}
    assert len(torque) == 2 * (2 * len(models) + len(looped)) * 6  # recordings, ..., joints
    assert torque["printed"].isna().all()
    force = read_csv(results / "tables" / "force_mae.csv")
    assert set(force["recording"]) == {"pushed"}
    estimates = force.groupby("kind")["estimate"].unique().map(set)
    assert estimates["printed"] == {"Fu", "F", "F*"}
    assert (
        estimates["corrected"] == estimates["compensated"] >= {"Fu", "F", "F*", "Fmap", "observer"}
    )
    parts = force.groupby(["kind", "estimate", "during"]).size()
    assert (parts == 6).all()  # components
    assert len(parts) == sum(map(len, estimates)) * force["during"].nunique()
    assert {"all", "contact"} <= {*force["during"]}
    errors = read_csv(results / "tables" / "contact_errors.csv")
    assert errors.groupby("estimate")["contact"].nunique().eq(1).all()
    assert {*errors["estimate"]} == estimates["compensated"]
