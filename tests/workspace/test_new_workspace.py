"""`ur5 new`, and what to do next in a workspace."""

from pathlib import Path

import pytest

from tests.command import Command
from ur5lib.datasets.catalogue import catalogue
from ur5lib.strict import read_yaml
from ur5lib.study.reading import read_study
from ur5lib.tables import write_text
from ur5lib.workspace.new import copy_study, new_workspace


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_new_workspace_has_all_that_snakemake_needs(here: Path, run_ur5: Command) -> None:
    assert run_ur5("new", "my arm").out.endswith(
        "next: cd 'my arm' && ur5 run config.yaml --open\n"
    )
    assert (here / "my arm" / "raw").is_dir()
    assert (here / "my arm" / "profiles" / "default" / "config.yaml").is_file()
    assert read_study(here / "my arm" / "config.yaml").study == "demo"


def test_published_studies_and_their_schema_are_at_hand(here: Path) -> None:
    new_workspace(Path())
    published = {dataset.study for dataset in catalogue().values()} - {None}
    assert published <= {str(path) for path in Path("workflow/studies").glob("*.yaml")}
    for study in [*published, "config.yaml"]:
        schema = Path(study).read_text().splitlines()[0].partition("$schema=")[2]
        assert not Path(schema).is_absolute()
        assert (Path(study).parent / schema).is_file()


def test_files_that_are_there_stay(here: Path) -> None:
    (here / "config.yaml").write_text("study: mine\n")
    assert new_workspace(Path()).endswith("next: ur5 run config.yaml --open")
    assert (here / "config.yaml").read_text() == "study: mine\n"


@pytest.mark.parametrize("written", range(0, 12, 3))
def test_a_workspace_whose_making_was_stopped_is_completed(
    here: Path, monkeypatch: pytest.MonkeyPatch, written: int
) -> None:
    files = []

    def stopped(text: str, path: Path) -> None:
        if len(files) == written:
            raise KeyboardInterrupt
        files.append(path)
        write_text(text, path)

    with monkeypatch.context() as patch:
        patch.setattr("ur5lib.workspace.new.write_text", stopped)
        with pytest.raises(KeyboardInterrupt):
            new_workspace(here / "a")
    new_workspace(here / "a")
    new_workspace(here / "whole")
    made, whole = ({*(here / name).rglob("*")} for name in ("a", "whole"))
    assert {path.relative_to(here / "a") for path in made} == {
        path.relative_to(here / "whole") for path in whole
    }


def test_a_folder_with_a_snakefile_is_left_alone(here: Path, run_ur5: Command) -> None:
    (here / "Snakefile").touch()
    assert run_ur5("new", ".").status == 1
    assert [path.name for path in here.iterdir()] == ["Snakefile"]


def test_what_cannot_be_written_is_said(here: Path, run_ur5: Command) -> None:
    (here / "file").touch()
    answer = run_ur5("new", "file")
    assert answer.status == 1
    assert answer.err.startswith("ur5: file cannot be written")


def test_a_fetched_study_comes_with_its_printed_numbers(here: Path) -> None:
    study = copy_study("workflow/studies/thesis.yaml")
    assert read_yaml(Path(read_yaml(study)["reference"]))["printed"]
    study.write_text("edited")
    assert copy_study("workflow/studies/thesis.yaml").read_text() == "edited"
