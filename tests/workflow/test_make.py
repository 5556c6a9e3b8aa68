"""What `make` says where it cannot set up, and which studies it builds."""

import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.conftest import PROJECT
from ur5lib.datasets.catalogue import catalogue

OLD = "exit 1"
NO_VENV = 'test "$1" = -c'
# Its venv has a Python whose pip finds no package.
NO_NETWORK = """test "$1" = -c && exit
mkdir -p .venv/bin && ln -s "$(command -v false)" .venv/bin/python"""


@pytest.mark.parametrize(
    ("python", "sentence"),
    [
        (None, "Python 3.11 or newer is needed; name one: make PYTHON=python3.11"),
        (OLD, "Python 3.11 or newer is needed; name one: make PYTHON=python3.11"),
        (NO_VENV, "cannot make .venv; install its venv module, free the disk, or name another"),
        (NO_NETWORK, "requirements.lock cannot be installed; check the network and the disk"),
    ],
)
def test_what_is_missing_is_told(tmp_path: Path, python: str | None, sentence: str) -> None:
    for name in ("Makefile", "requirements.lock", "pyproject.toml"):
        shutil.copy(PROJECT / name, tmp_path)
    if python is not None:
        (tmp_path / "python").write_text(f"#!/bin/sh\n{python}\n")
        (tmp_path / "python").chmod(0o755)
    done = subprocess.run(
        ["make", ".venv/ready", "PYTHON=./python"],
        cwd=tmp_path,
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert sentence in done.stdout
    assert not (tmp_path / ".venv" / "ready").exists()


# Studies

STUDIES = {
    "config.yaml": "study: demo\n",
    "workflow/studies/here.yaml": "study: here\nrecordings:\n  - folder: raw/here/one\n",
    "workflow/studies/gone.yaml": "study: gone\nrecordings:\n  - {folder: raw/gone/two, file: a}\n",
    "workflow/studies/reference.yaml": "printed: 1\n",
}


def own_environment() -> dict[str, str]:
    """Without what a `make` around the tests hands down: it names the folders that it enters."""
    return {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}


def make_studies(folder: Path, snakemake: str) -> tuple[int, str]:
    """The exit status and the output of `make studies`, with another snakemake."""
    for name, text in STUDIES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "raw" / "here" / "one").mkdir(parents=True)
    for name in ("Makefile", "requirements.lock", "pyproject.toml"):
        shutil.copy(PROJECT / name, folder)
    program = folder / ".venv" / "bin" / "snakemake"
    program.parent.mkdir(parents=True)
    program.write_text(f'#!/bin/sh\necho "$@" >> built\n{snakemake}\n')
    program.chmod(0o755)
    (folder / ".venv" / "ready").touch()
    make = ["make", "studies"]
    done = subprocess.run(
        make, cwd=folder, text=True, capture_output=True, check=False, env=own_environment()
    )
    return done.returncode, done.stdout


def test_studies_are_built_whose_recordings_are_there(tmp_path: Path) -> None:
    status, said = make_studies(tmp_path, "exit 0")
    assert status == 0
    built = (tmp_path / "built").read_text().splitlines()
    assert built == ["--configfile config.yaml", "--configfile workflow/studies/here.yaml"]
    (line,) = said.splitlines()
    assert line.startswith("workflow/studies/gone.yaml is skipped: raw/gone/two is missing")
    assert line.endswith("ur5 fetch gone")


def test_a_study_that_fails_is_named_after_all_others_were_built(tmp_path: Path) -> None:
    status, said = make_studies(tmp_path, 'test "$2" != config.yaml')
    assert status == 2
    assert len((tmp_path / "built").read_text().splitlines()) == 2
    assert said.splitlines()[-1] == "failed: config.yaml"


def test_recordings_of_every_study_can_be_fetched_by_their_folder() -> None:
    for path in (PROJECT / "workflow" / "studies").glob("*.yaml"):
        study = yaml.safe_load(path.read_text())
        for recording in study.get("recordings", []):
            raw, name, *_ = Path(recording["folder"]).parts
            assert raw == "raw"
            assert name in catalogue()


# Locks


def locked(name: str) -> set[str]:
    lines = (PROJECT / name).read_text().splitlines()
    return {canonicalize_name(line.split("==")[0]) for line in lines if "==" in line}


def pins(requirement: Requirement) -> bool:
    return any(each.operator == "==" for each in requirement.specifier)


@pytest.mark.parametrize("name", ["requirements.lock", "requirements-dev.lock"])
def test_every_locked_package_has_the_hashes_of_its_files(name: str) -> None:
    lines = (PROJECT / name).read_text().replace("\\\n", " ").splitlines()
    for line in lines:
        pin, *hashes = line.split()
        assert re.fullmatch(r"[a-z0-9.-]+==\S+", pin)
        assert hashes
        assert all(re.fullmatch("--hash=sha256:[0-9a-f]{64}", each) for each in hashes)


def test_a_user_installs_nothing_that_only_tests_need() -> None:
    """Each lock has what its part of pyproject.toml names, and no package is in both.

    What pyproject.toml pins itself is in none.
    """
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for_users = map(Requirement, project["dependencies"] + extras["record"])
    named = {canonicalize_name(each.name) for each in for_users if not pins(each)}
    for_tests = {canonicalize_name(Requirement(each).name) for each in extras["dev"]}
    assert named <= locked("requirements.lock")
    assert for_tests <= locked("requirements.lock") | locked("requirements-dev.lock")
    assert not locked("requirements.lock") & locked("requirements-dev.lock")
