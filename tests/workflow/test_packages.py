"""What is left where the packages beside the library are deleted."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROJECT, Workflow, copy_project

PACKAGES = sorted(path.name for path in PROJECT.glob("ur5*") if path.name != "ur5lib")
NOT_COPIED = (".git", ".venv", ".snakemake", ".*_cache", ".site", "raw", "results", "__pycache__")
OF_A_RUN = {"logs", "benchmarks", ".running", "run_times.csv", "tables.zip"}  # times
OF_A_RUN |= {"ro-crate-metadata.json"}
LEFT = [f"tests/library/test_{name}.py" for name in ("architecture", "beside", "command_line")]
LEFT += [f"tests/library/test_{name}.py" for name in ("docs", "examples", "benchmarks")]


def results_of(folder: Path) -> dict[Path, bytes]:
    """All that was made of the default study, but for what tells of the run itself."""
    results = folder / "results" / "demo"
    files = {path.relative_to(results): path for path in results.rglob("*") if path.is_file()}
    made = {name: file.read_bytes() for name, file in files.items() if not OF_A_RUN & {*name.parts}}
    details = Path("details.html")  # has a table of run times
    return made | {details: re.sub(rb"\d+", b"", made[details])}


@pytest.mark.thorough
@pytest.mark.slow  # builds the default study
def test_the_default_study_is_the_same_without_them(demo: Workflow, tmp_path: Path) -> None:
    left = Workflow(copy_project(tmp_path / "project"))
    for name in PACKAGES:
        shutil.rmtree(left.folder / name)
    left.build()
    made, expected = results_of(left.folder), results_of(demo.folder)
    assert {
        name for name in made.keys() | expected if made.get(name) != expected.get(name)
    } == set()


@pytest.mark.thorough
@pytest.mark.slow  # collects all tests
@pytest.mark.parametrize("package", PACKAGES)
def test_all_other_tests_are_there_and_those_of_the_whole_project_hold(
    package: str, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    shutil.copytree(PROJECT, project, ignore=shutil.ignore_patterns(*NOT_COPIED), symlinks=True)
    (project / "raw").mkdir()
    shutil.copy(PROJECT / "raw" / "README.md", project / "raw")
    shutil.rmtree(project / package)
    shutil.rmtree(project / "tests" / package.removeprefix("ur5"))
    environment = Workflow(project).environment
    for arguments in (["--collect-only", "--quiet"], ["-m", "not thorough", *LEFT]):
        command = [sys.executable, "-m", "pytest", "--numprocesses", "0", *arguments]
        done = subprocess.run(command, cwd=project, env=environment, text=True, capture_output=True)
        assert done.returncode == 0, done.stdout[-4000:]
