"""What `make` says where it cannot set up."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.conftest import PROJECT

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
