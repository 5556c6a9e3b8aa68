"""A run of the tests says what it took, and fails for a skip that nobody expected."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests import command
from tests.command import time_limit
from tests.conftest import PROJECT, bring_up_to_date, content, sources

CONFTEST = "from tests.session import *\n"
TESTS = """\
import time

import pytest


@pytest.mark.parametrize("seconds", [0.0, 0.2])
def test_sleeps(seconds):
    time.sleep(seconds)


def test_works():
    end = time.process_time() + 0.2
    while time.process_time() < end:
        pass


def test_skips():
    pytest.skip("no GPU is at hand")
"""


@pytest.mark.parametrize(
    ("expected", "status"), [(None, 0), ("no GPU|no browser", 0), ("no brow", 1)]
)
def test_a_skip_fails_unless_it_is_expected(
    expected: str | None, status: int, tmp_path: Path
) -> None:
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_few.py").write_text(TESTS)
    known = {key: value for key, value in os.environ.items() if key != "EXPECTED_SKIPS"}
    known |= {"PYTHONPATH": str(PROJECT), "PYTEST_ADDOPTS": ""}
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--rootdir", ".", "-n", "0"],
        cwd=tmp_path,
        env=known if expected is None else known | {"EXPECTED_SKIPS": expected},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == status, run.stdout
    assert ("  Skipped: no GPU is at hand" in run.stdout) == bool(status)
    [kept] = tmp_path.rglob("durations")
    took = json.loads(kept.read_text())
    assert {*took} >= {"test_few.py::test_sleeps[0.2]", "test_few.py::test_works"}
    assert took["test_few.py::test_sleeps[0.2]"] >= 0.2
    [kept] = tmp_path.rglob("processor")
    spent = json.loads(kept.read_text())
    assert next(iter(spent)) == "test_few.py::test_works"
    assert spent["test_few.py::test_works"] >= 0.2
    assert spent["test_few.py::test_sleeps[0.2]"] < 0.1
    assert " s of processor in tests, " in run.stdout


def test_a_kept_study_has_the_files_of_today_and_its_results(tmp_path: Path) -> None:
    kept, new = tmp_path / "kept", tmp_path / "new"

    def put(folder: Path, **files: str) -> None:
        for name, text in files.items():
            path = folder / name.replace("__", "/")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    put(new, raw__a="1", raw__b="1", config="1")
    (new / "linked").symlink_to(tmp_path / "before")
    bring_up_to_date(kept, new)
    assert not new.exists()
    put(kept, results__small__report="made", raw__run="left")
    same = (kept / "raw" / "a").stat().st_mtime_ns
    put(new, raw__a="1", raw__b="2", other__c="1")
    (new / "linked").symlink_to(tmp_path / "after")
    bring_up_to_date(kept, new)
    assert sources(kept) == sources(new) == {*map(Path, ("raw/a", "raw/b", "other/c", "linked"))}
    assert {content(kept / own) == content(new / own) for own in sources(new)} == {True}
    assert (kept / "raw" / "a").stat().st_mtime_ns == same  # by which Snakemake sees a change
    assert (kept / "results" / "small" / "report").read_text() == "made"


def test_a_limit_counts_what_a_run_works_and_not_what_the_machine_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def work(seconds: float) -> None:
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    with time_limit(0.2):
        time.sleep(0.5)
    with pytest.raises(TimeoutError), time_limit(0.2):
        work(2.0)
    monkeypatch.setattr(command, "WAITS", 2)
    with pytest.raises(TimeoutError), time_limit(0.2):
        time.sleep(5.0)
    work(0.5)  # no limit is left
