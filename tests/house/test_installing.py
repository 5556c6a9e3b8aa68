"""No file installs the package by a name: on an index, `ur5lib` is somebody else's, and the name of
the distribution is nobody's yet.
"""

import re
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.conftest import PROJECT
from ur5lib.cli import app
from ur5lib.workspace.origin import DISTRIBUTION

INSTALLER = r"(?:pip[\d.]*|pipx|uv|conda|mamba|poetry|pdm|pixi)"
VERB = r"(?:install|add|run|inject|download|tool)"
# In one command of a line: neither a wheel's file name nor a folder, which go on after the name.
BY_NAME = re.compile(
    rf"\b(?:{INSTALLER}\b[^`\n;|&#]*?\b{VERB}|uvx)\b[^`\n;|&#]*?"
    r"(?<![\w./-])(?:ur5lib|arm[-_]force[-_]lab)(?!(?:\[\w+\])? *@ *file:|[\w/*-]|\.\w)",
    re.IGNORECASE,
)


def tracked() -> list[Path]:
    """The files of the clone; a link leads to one of them."""
    if not (PROJECT / ".git").exists():
        pytest.skip("no clone, so no list of its files")
    names = subprocess.check_output(["git", "ls-files", "-z"], cwd=PROJECT, text=True).split("\0")
    return [path for name in names if name and (path := PROJECT / name).is_file()]


def installing(text: str) -> list[str]:
    return [found[0] for found in BY_NAME.finditer(text.replace("\\\n", " "))]


def test_no_file_installs_the_package_by_its_name() -> None:
    texts = {path: path.read_text(encoding="utf-8", errors="ignore") for path in tracked()}
    assert PROJECT / "README.md" in texts
    assert {path: found for path, text in texts.items() if (found := installing(text))} == {}


@pytest.mark.parametrize(
    "command",
    [
        "`pip install NAME`",
        "| `pip install 'NAME[formats]'` | is gone |",
        "install it: pip install 'NAME[record]'\"",
        ".venv/bin/python -m pip install --quiet NAME==1.0.0",
        "pip3.11 install -U numpy 'NAME>=1,<2'",
        "pip install \\\n    NAME",
        '"!pip install NAME\\n"',
        '[sys.executable, "-m", "pip", "install", "NAME"]',
        "pip install NAME.",
        "pipx install NAME",
        "pipx run --spec NAME ur5",
        "uv add NAME",
        "uv pip install NAME~=1.0",
        "uv tool install --with NAME snakemake",
        "uvx --from NAME ur5 new myarm",
        "uvx NAME",
    ],
)
def test_each_way_to_install_by_name_is_found(command: str) -> None:
    for name in ("ur5lib", "UR5" + "lib", DISTRIBUTION):
        assert installing(command.replace("NAME", name))


@pytest.mark.parametrize(
    "command",
    [
        "pip install arm_force_lab-*.whl      # or `pip install .` in a clone",
        "pip install dist/arm_force_lab-1.0.0-py3-none-any.whl",
        "pip install .  # in a clone, or arm_force_lab-*.whl; '.[record]' to move an arm",
        "pip install 'arm-force-lab[record] @ file:///home/me/arm_force_lab-1.0.0-py3-none-any.whl'",
        "`pip install .` put the package ur5lib.",
        "pip install --no-build-isolation /opt/ur5lib",
        "pip uninstall ur5lib; pip install .",
        "pip show ur5lib",
    ],
)
def test_a_wheel_file_and_a_clone_are_fine(command: str) -> None:
    assert not installing(command)


def test_another_package_of_the_name_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "another package" not in CliRunner().invoke(app, ["--version"]).output
    information = tmp_path / "ur5lib-1.0.3.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: ur5lib\nVersion: 1.0.3\n")
    monkeypatch.syspath_prepend(tmp_path)
    for words in (["--version"], ["status", str(PROJECT / "config.yaml")]):
        told = " ".join(CliRunner().invoke(app, words).output.split())
        assert "another package is installed as ur5lib 1.0.3" in told
