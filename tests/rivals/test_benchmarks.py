"""The benchmarks that compare rivals run, in small sizes, and print their tables."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from benchmarks.torque_from_motion import Row, is_repeated, run_of, scored, withheld_part
from tests.conftest import PROJECT, shared_folder
from tests.house.test_benchmarks import run_benchmark
from ur5lib.robots.drives import of_the_joints


@pytest.mark.thorough
@pytest.mark.slow
def test_a_seed_goes_on_after_a_killed_run_and_is_computed_once() -> None:
    """Of the killed run, a torn file lies where the workflow writes; none of it is used or kept."""
    results, simulated = PROJECT / "results", PROJECT / "results" / "simulated-0"
    rows, table = (results / f"simulated_contacts_quick{end}" for end in ("", ".csv"))
    shutil.rmtree(rows, ignore_errors=True)
    torn = simulated / "recordings" / "path_1" / "motion.parquet"
    torn.parent.mkdir(parents=True, exist_ok=True)
    torn.write_bytes(b"PAR1")
    printed = run_benchmark("simulated_contacts", PROJECT)
    assert "| least squares | no |" in printed
    assert "seed 0: " in printed
    assert not simulated.exists()
    whole = (rows / "0.csv").read_bytes(), table.read_bytes()
    assert "seed 0: " not in run_benchmark("simulated_contacts", PROJECT)
    assert whole == ((rows / "0.csv").read_bytes(), table.read_bytes())


@pytest.mark.thorough
@pytest.mark.slow
def test_torques_of_public_recordings_are_predicted() -> None:
    folder = shared_folder("kuka-kr300/benchmark-10hz", "docs/benchmark.md names their source")
    printed = run_benchmark("torque_from_motion", PROJECT, "--folder", str(folder))
    assert all(text in printed for text in ("linear map", "| ours |", "process")), printed


def test_a_motion_of_the_fit_is_not_judged(tmp_path: Path) -> None:
    """Nor another drive of it: files 1 and 4 are drives of one motion, file 2 is of another."""
    folder = shared_folder("kuka-kr300/benchmark-10hz", "docs/benchmark.md names their source")
    one, two, four = (folder / f"val-0{number}.csv" for number in (1, 2, 4))
    assert not is_repeated(run_of(two), [run_of(one)])
    for file, place in ((one, tmp_path / "train-1.csv"), (four, tmp_path / "test" / "1.csv")):
        place.parent.mkdir(exist_ok=True)
        shutil.copy(file, place)
    with pytest.raises(SystemExit, match="1: motions of the fit"):
        run_benchmark(
            "torque_from_motion",
            PROJECT,
            *("--folder", str(tmp_path), "--test", str(tmp_path / "test")),
        )


def test_the_benchmark_s_own_file_is_read_and_scored_as_identibench_scores(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    parts = {"time_test": 0.1 * np.arange(300)[None], "u_test": random.normal(size=(18, 300))}
    parts["y_test"] = random.normal(size=(6, 300))
    savemat(tmp_path / "inverse.mat", {**parts, "u_train": np.zeros((18, 9))})
    [file] = withheld_part(tmp_path / "inverse.mat", tmp_path).glob("*.csv")
    run = run_of(file)
    counted = {"actual_q": np.deg2rad(parts["u_test"][:6].T), "actual_torque": parts["y_test"].T}
    for name, found in (("actual_q", run.signals.actual_q), ("actual_torque", run.torque)):
        np.testing.assert_allclose(found, of_the_joints(name, counted[name], run.arm), atol=1e-9)
    of_motors = np.where(np.arange(300)[:, None] < 100, 1e9, np.arange(1.0, 7.0))
    error = of_the_joints("actual_torque", of_motors, run.arm)
    assert scored(Row("a model", [run.torque - error]), [run]) == "3.5000"


@pytest.mark.parametrize("name", ["leaderboard", "live"])
def test_a_study_that_is_not_built_is_told(name: str, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"^results/other is not built; "):
        run_benchmark(name, tmp_path, "other")
