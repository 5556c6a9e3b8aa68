"""Nothing installs the package by its name from an index, where the name is somebody else's."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.conftest import PROJECT

INSTALLER = r"(?:pip[\d.]*|pipx|uv|conda|mamba|poetry|pdm|pixi)"
VERB = r"(?:install|add|run|inject|download|tool)"
# In one command of a line: neither a wheel's file name nor a folder, which go on after the name.
BY_NAME = re.compile(
    rf"\b(?:{INSTALLER}\b[^`\n;|&#]*?\b{VERB}|uvx)\b[^`\n;|&#]*?"
    r"(?<![\w./-])ur5lib(?!(?:\[\w+\])? *@ *file:|[\w/*-]|\.\w)",
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
    for name in ("ur5lib", "UR5" + "lib"):
        assert installing(command.replace("NAME", name))


@pytest.mark.parametrize(
    "command",
    [
        "pip install ur5lib-*.whl      # or `pip install .` in a clone",
        "pip install dist/ur5lib-1.0.0-py3-none-any.whl",
        "pip install .  # in a clone, or ur5lib-*.whl; '.[record]' to move an arm",
        "pip install 'ur5lib[record] @ file:///home/me/ur5lib-1.0.0-py3-none-any.whl'",
        "`pip install .` put the package ur5lib.",
        "pip install --no-build-isolation /opt/ur5lib",
        "pip uninstall ur5lib; pip install .",
        "pip show ur5lib",
    ],
)
def test_a_wheel_file_and_a_clone_are_fine(command: str) -> None:
    assert not installing(command)
