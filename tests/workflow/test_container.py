"""The steps of the Dockerfile, in a bare root file system instead of Docker's image."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.command import printed
from tests.conftest import PROJECT
from tests.workflow.test_simulated import POINTS, STUDY

pytestmark = [
    pytest.mark.slow,
    pytest.mark.thorough,
    pytest.mark.skipif(
        not shutil.which("debootstrap") or os.geteuid() != 0, reason="needs debootstrap and root"
    ),
]
PATH = "/usr/sbin:/usr/bin:/sbin:/bin"


def instructions() -> Iterator[tuple[str, str]]:
    """The Dockerfile's instructions and their arguments."""
    text = re.sub(r"\\\n", " ", (PROJECT / "Dockerfile").read_text())
    lines = (line for line in text.splitlines() if line and not line.startswith("#"))
    for line in lines:
        word, rest = line.split(maxsplit=1)
        yield word, rest


def enter(root: Path, command: str, **variables: str) -> str:
    """Run a shell command inside; what it printed."""
    inside = [shutil.which("chroot") or "", str(root), "/bin/sh", "-c", command]
    return printed(inside, root, {"HOME": "/root", "LC_ALL": "C.UTF-8", "PATH": PATH} | variables)


@pytest.fixture(scope="module")
def container(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, dict[str, str]]]:
    """The root made by the Dockerfile's steps, with packages from beside it, and its variables."""
    root, variables = tmp_path_factory.mktemp("root"), {}
    targets = ["apt-get", "indextargets", "--format", "$(CODENAME) $(REPO_URI)"]
    mirrors = dict(map(str.split, subprocess.check_output(targets, text=True).splitlines()))
    [(_, image), *steps] = instructions()
    release = image.removeprefix("debian:").removesuffix("-slim")
    subprocess.run(
        ["debootstrap", "--variant=minbase", release, root, mirrors[release]], check=True
    )
    lock = PROJECT / "requirements.lock"
    download = [sys.executable, "-m", "pip", "download", "--quiet", "--dest", root / "packages"]
    subprocess.run([*download, "--no-deps", "--requirement", lock], check=True)
    subprocess.run([*download, "--no-deps", "pip", f"torch=={version('torch')}"], check=True)
    offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "/packages"}
    offline |= {"PIP_COMPILE": "0"}  # what is used is compiled then
    for word, rest in steps:
        if word == "RUN":
            enter(root, rest, **offline)
        elif word == "COPY":
            here, there = rest.split()
            tracked = subprocess.check_output(["git", "ls-files"], cwd=PROJECT, text=True)
            for name in tracked.splitlines():
                target = root / there.lstrip("/") / here / name
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(PROJECT / name, target)
        elif word == "ENV":
            variables |= dict(pair.split("=", 1) for pair in shlex.split(rest))
    yield root, variables
    shutil.rmtree(root)


def test_a_lab_is_built_in_the_container(container: tuple[Path, dict[str, str]]) -> None:
    root, variables = container
    enter(root, "cd / && ur5 new lab", **variables)
    (root / "lab" / "config.yaml").write_text(STUDY)
    (root / "lab" / "points.txt").write_text(POINTS)
    assert "report: results/made/report.html" in enter(root, "cd /lab && snakemake", **variables)
