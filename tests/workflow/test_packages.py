"""What is left where the packages beside the library are deleted."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.artefacts.documents import page_texts
from tests.conftest import PROJECT, Workflow, copy_project

PACKAGES = sorted(path.name for path in PROJECT.glob("ur5*") if path.name != "ur5lib")
NOT_COPIED = (".git", ".venv", ".snakemake", ".*_cache", ".site", "raw", "results", "__pycache__")
OF_A_RUN = {"logs", "benchmarks", ".running", "run_times.csv", "tables.zip"}  # times
OF_A_RUN |= {"ro-crate-metadata.json"}
RUN_TIMES = re.compile(r"took\s\d+\ss of processor time,\s\d+\ss of it")
LEFT = [
    f"tests/house/test_{name}.py" for name in ("architecture", "docs", "examples", "benchmarks")
]
LEFT += ["tests/workspace/test_beside.py", "tests/commands/test_command_line.py"]


def results_of(folder: Path) -> dict[str, bytes | str]:
    """All that was made of the default study, but for what tells of the run itself."""
    results = folder / "results" / "demo"
    files = {path.relative_to(results): path for path in results.rglob("*") if path.is_file()}
    return {str(name): made(file) for name, file in files.items() if not OF_A_RUN & {*name.parts}}


def made(file: Path) -> bytes | str:
    """What a file holds; of a page, its text without run times."""
    match file.name:
        case "report.pdf":
            return RUN_TIMES.sub("", "\n".join(page_texts(file)))
        case "report.html":
            return RUN_TIMES.sub("", file.read_text())
        case "details.html":  # with a table of them
            return re.sub(r"\d+", "", file.read_text())
    return file.read_bytes()


@pytest.mark.thorough
@pytest.mark.slow  # builds the default study
def test_the_default_study_is_the_same_without_them(demo: Workflow, tmp_path: Path) -> None:
    left = Workflow(copy_project(tmp_path / "project"))
    for name in PACKAGES:
        shutil.rmtree(left.folder / name)
    left.build()
    found, expected = results_of(left.folder), results_of(demo.folder)
    assert found.keys() == expected.keys()
    assert [name for name in found if found[name] != expected[name]] == []


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
