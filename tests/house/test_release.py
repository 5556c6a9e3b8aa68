"""What a release says about itself, in one version and to several readers."""

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from datetime import date
from pathlib import Path

import pandas as pd
import pytest
import yaml

import ur5lib
from benchmarks.harness.cells import CELL, DATA, with_cells
from benchmarks.pictures import BADGE, PICTURES
from tests.conftest import PROJECT

CITATION = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
PAPER = (PROJECT / "paper" / "paper.md").read_text()


def test_the_version_is_that_of_the_newest_changes() -> None:
    newest = re.search(r"^## (\S+)$", (PROJECT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert newest
    assert newest[1] == ur5lib.__version__
    assert CITATION["version"] == ur5lib.__version__
    assert BADGE.format(ur5lib.__version__) == (PICTURES / "version.svg").read_text()
    assert isinstance(CITATION["date-released"], date)


def test_the_package_has_the_licence_of_the_citation() -> None:
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    # of the project's own files, and of uPlot's, which the package holds
    assert project["license"] == f"{CITATION['license']} AND MIT"


def test_the_paper_names_title_and_authors_of_the_citation() -> None:
    head = yaml.safe_load(PAPER.split("---")[1])
    assert head["title"] == CITATION["title"]
    assert [one["name"] for one in head["authors"]] == [one["name"] for one in CITATION["authors"]]


def test_the_paper_cites_what_its_bibliography_has_and_each_number_is_a_cell() -> None:
    head, text = yaml.safe_load(PAPER.split("---")[1]), PAPER.split("---")[2]
    references = (PROJECT / "paper" / head["bibliography"]).read_text()
    cited = re.findall(r"@(\w+)", text)
    assert cited
    assert all(f"{{{name}," in references for name in cited)
    assert with_cells(text) == text
    named = r"@\w+|ur5\w*|UR5|UR10e|KR300|TX40"
    assert not re.findall(r"\d", re.sub(named, "", CELL.sub("", text)))


def test_every_published_value_is_inside_as_the_paper_says() -> None:
    rows = pd.read_csv(DATA / "published_friction.csv")
    assert (rows["inside"] == "yes").all()


def test_the_catalogue_finds_workflow_and_configuration() -> None:
    usage = yaml.safe_load((PROJECT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage["report"] is True
    assert (PROJECT / "workflow" / "Snakefile").is_file()
    assert (PROJECT / "config" / "README.md").is_file()


def test_wheel_and_sdist_are_built_twice_alike_and_name_the_commit(tmp_path: Path) -> None:
    """As `make release` builds them."""
    if not (PROJECT / ".git").exists():
        pytest.skip("no clone, so there is nothing to archive")
    git = ["git", "-C", str(PROJECT)]
    archive = tmp_path / "source.tar"
    subprocess.run([*git, "archive", "--output", archive, "HEAD"], check=True)
    built = []
    for place in ("one", "two"):
        with tarfile.open(archive) as files:
            files.extractall(tmp_path / place, filter="data")
        build = [
            sys.executable,
            "-m",
            "hatchling",
            "build",
            "--directory",
            tmp_path / place / "dist",
        ]
        subprocess.run(build, cwd=tmp_path / place, check=True, capture_output=True)
        built.append(
            {file.name: file.read_bytes() for file in (tmp_path / place / "dist").iterdir()}
        )
    assert built[0] == built[1]
    assert {name.split(".")[-1] for name in built[0]} == {"whl", "gz"}
    [wheel] = (tmp_path / "one" / "dist").glob("*.whl")
    head = subprocess.check_output([*git, "rev-parse", "HEAD"], text=True)
    packed = zipfile.ZipFile(wheel)
    assert packed.read("ur5lib/workspace/commit.txt").decode() == head
    [about] = (name for name in packed.namelist() if name.endswith(".dist-info/METADATA"))
    told = packed.read(about).decode()
    assert re.findall("^Author: (.*)$", told, re.MULTILINE) == [
        one["name"] for one in CITATION["authors"]
    ]
    assert f"Keywords: {','.join(sorted(CITATION['keywords']))}" in told
