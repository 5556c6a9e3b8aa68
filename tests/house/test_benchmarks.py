"""Each benchmark runs, in small sizes, and prints its table; how fast is not asked here."""

import importlib
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import IO

import pytest

from tests.conftest import PROJECT, shared_folder

PRINTED = {  # what each prints at least
    "dynamics": ["inverse dynamics, UR5", "inertia matrix, UR5", "pinocchio", "peak memory"],
    "gpu": ["GPU"],
    "smoothing": ["200 samples", "this library", "loop, Pinocchio"],
    "motion": ["Fourier series", "within the 95 % band", "with an IMU", "bridged"],
    "long_recording": ["1 min", "processor time", "wall s"],
    "abb_like": ["1 seeds", "in band", "of least squares"],
    "slow_presses": ["1 seeds", "with an untouched span", "twenty lines"],
    "false_stops": ["4 right logs", "links described wrongly", "another arm declared"],
    "grasps": ["loads above 1 kg", "unloaded pieces", "pushes of 2 s"],
    "wrist_sensor": ["1 seeds", "turn", "intervals hold the truth", "mass_by_currents"],
    "many_runs": ["planned", "whole study", "one more run to fit", "put in: Coulomb friction"],
    "world": ["| tool of 0 cm, known |"],
    "touched_links": ["| elbow |"],
    "study": ["whole study, from raw files", "one more recording", "nothing to do"],
}
ELSEWHERE = {  # run by tests of their own, here and in tests/
    *("leaderboard", "live", "simulated_contacts", "torque_from_motion"),  # rivals/
    *("excitation", "excitation_loop"),  # lab/
    "false_changes",  # topics/health/
    "motion_alone",  # chain/
    "stand_seeds",  # topics/truth/
    "serial_arms",  # library/test_stand_of_other_arms.py
    "pictures",  # artefacts/test_lesson.py
    "pages",  # house/test_pages.py
    "installed",  # workflow/test_lab.py
}
OF_A_BUILT_STUDY = {
    "counterbalance",
    "expected",
    "leave_out",
    "live_efforts",
    "paths",
    "rollout",
    "stand_and_arms",
    "worth",
}  # in tests/artefacts/test_demo.py
OF_PUBLIC_RECORDINGS = {  # folder in ../shared, and what each prints at least
    "choice": ("ur10e", ["| cut-off [Hz] | terms |", "| 1 | velocity_root |"]),
    "episodes": ("ur10e", ["were kept: 2 of 2", "all data and the force: 8 of 8; parts left: []"]),
    "published_friction": ("staubli-tx40", ["| joint 6 | rotor", "With it, the residual"]),
}


def run_benchmark(name: str, folder: Path, *arguments: str) -> str:
    """What a benchmark and its own processes print when it runs quickly in a folder."""
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryFile("w+") as printed:
        patch.chdir(folder)
        patch.syspath_prepend(folder)
        patch.setenv("PYTHONPATH", str(PROJECT))
        patch.setattr(sys, "argv", [name, "--quick", *arguments])
        with printing_to(printed):
            importlib.import_module(f"benchmarks.{name}").main()
        printed.seek(0)
        return printed.read()


@contextmanager
def printing_to(file: IO[str]) -> Iterator[None]:
    """Standard output and error go to a file, those of other processes, too."""
    before = [(stream, os.dup(stream)) for stream in (1, 2)]
    for stream, _ in before:
        os.dup2(file.fileno(), stream)
    try:
        with redirect_stdout(file), redirect_stderr(file):
            yield
    finally:
        file.flush()
        for stream, kept in before:
            os.dup2(kept, stream)
            os.close(kept)


def test_every_benchmark_is_run() -> None:
    files = {path.stem for path in (PROJECT / "benchmarks").glob("*.py")}
    assert files == {*PRINTED, *OF_PUBLIC_RECORDINGS} | ELSEWHERE | OF_A_BUILT_STUDY


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("name", PRINTED)
def test_a_benchmark_runs_and_prints_its_table(name: str) -> None:
    printed = run_benchmark(name, PROJECT)
    assert all(text in printed for text in PRINTED[name]), printed


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("name", OF_PUBLIC_RECORDINGS)
def test_a_benchmark_of_public_recordings_prints_its_table(name: str) -> None:
    shared, texts = OF_PUBLIC_RECORDINGS[name]
    folder = shared_folder(shared, "docs/benchmark.md names their source")
    printed = run_benchmark(name, PROJECT, "--folder", str(folder))
    assert all(text in printed for text in texts), printed


def test_what_make_bench_runs_is_there() -> None:
    named = re.search(r"^SPEED := (.*)$", (PROJECT / "Makefile").read_text(), re.MULTILINE)
    assert named is not None
    assert {*named[1].split()} <= {*PRINTED}


@pytest.mark.parametrize("name", sorted(OF_A_BUILT_STUDY))
def test_a_study_that_is_not_built_is_told(name: str, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"^results/other is not built; "):
        run_benchmark(name, tmp_path, "other")
