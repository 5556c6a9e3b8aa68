"""A folder of one's own: the package, installed without the clone, builds a study there."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks import installed as installed_size
from tests.command import printed
from tests.conftest import PROJECT, shared_folder
from tests.workflow.test_simulated import POINTS, STUDY
from ur5lib.workspace.beside import commands_beside

TREES = {path.name: path.name for path in PROJECT.glob("ur5*")}
TREES |= {"workflow": "ur5lib/workflow/workflow"}
TREES |= {"profiles": "ur5lib/workflow/profiles"}
SINGLE = {
    name: f"ur5lib/workflow/{name}"
    for name in ("Snakefile", "CITATION.cff", "config.yaml", "requirements.lock")
}


@dataclass
class Installed:
    """An environment into which the wheel was installed, beside a folder for labs."""

    environment: Path
    labs: Path

    @property
    def library(self) -> Path:
        [packages] = self.environment.glob("lib/python*/site-packages/ur5lib")
        return packages

    def run(self, *command: str, folder: Path) -> str:
        """What a program of the environment prints, without the clone on any path."""
        program = self.environment / "bin" / command[0]
        variables = {"PATH": "/usr/bin:/bin", "HOME": str(self.labs), "LC_ALL": "C.UTF-8"}
        return printed([program, *command[1:]], folder, variables)

    def snakemake(self, folder: Path, *arguments: str) -> str:
        return self.run("python", "-m", "snakemake", *arguments, folder=folder)

    def lab(self, name: str) -> Path:
        self.run("ur5", "new", name, folder=self.labs)
        return self.labs / name


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = ["wheel", "--quiet", "--no-build-isolation", "--no-deps", "--no-index"]
    subprocess.run([sys.executable, "-m", "pip", *build, "-w", folder, PROJECT], check=True)
    [built] = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installed]:
    """The wheel in an environment that borrows all other packages; nobody may write there."""
    labs = tmp_path_factory.mktemp("Prüfstand für Kräfte")
    environment = labs / "mit Paket"
    venv.create(environment, with_pip=False)
    [packages] = environment.glob("lib/python*/site-packages")
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib"))
    pip = [sys.executable, "-m", "pip", "--python", environment / "bin" / "python"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", wheel], check=True)
    set_mode(packages, writable=False)
    yield Installed(environment, labs)
    set_mode(packages, writable=True)


def set_mode(folder: Path, writable: bool) -> None:
    for path in [folder, *folder.rglob("*")]:
        path.chmod(path.stat().st_mode | 0o200 if writable else path.stat().st_mode & ~0o222)


def small_study(lab: Path) -> None:
    (lab / "config.yaml").write_text(STUDY)
    (lab / "points.txt").write_text(POINTS)


def test_the_wheel_holds_every_file_of_the_library_and_the_workflow(wheel: Path) -> None:
    expected = {*SINGLE.values()}
    for tree, place in TREES.items():
        files = (PROJECT / tree).rglob("*")
        expected |= {
            f"{place}/{path.relative_to(PROJECT / tree)}"
            for path in files
            if path.is_file() and "__pycache__" not in path.parts
        }
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert names == expected


def test_a_wheel_of_a_clone_names_its_commit(wheel: Path) -> None:
    if not (PROJECT / ".git").exists():
        pytest.skip("no clone, so no commit")
    head = subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=PROJECT, text=True).strip()
    stamp = zipfile.ZipFile(wheel).read("ur5lib/workspace/commit.txt").decode()
    assert stamp.strip() in (head, f"{head} + changes")


def test_the_size_of_an_installation_is_measured(
    wheel: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = ["--wheel", str(wheel), "--python", sys.executable, "--quick"]
    monkeypatch.setattr(sys, "argv", ["installed", *arguments])
    installed_size.main()
    python, torch, packages, _ = capsys.readouterr().out.splitlines()[-1].split("|")[1:5]
    assert python.strip() == f"3.{sys.version_info.minor}"
    assert torch.strip() == "none, CPU"
    assert int(packages) <= 2  # Python 3.11 brings setuptools
    (tmp_path / "file").write_bytes(bytes(10**6))
    assert 10**6 <= installed_size.size(tmp_path) <= 1.1 * 10**6  # in blocks of the disk


def test_a_clone_is_installed_as_make_does(tmp_path: Path) -> None:
    """Editable, by the packages of requirements.lock; the workflow is that of the clone."""
    venv.create(tmp_path, with_pip=False)
    python = tmp_path / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-index"]
    [packages] = tmp_path.glob("lib/python*/site-packages")
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib"))
    editable = ["--no-build-isolation", "--no-deps", "--editable", PROJECT]
    subprocess.run([*pip, *editable], check=True)
    (packages / "borrowed.pth").unlink()
    program = "from ur5lib.workspace.places import SNAKEFILE; print(SNAKEFILE)"
    printed = subprocess.check_output([python, "-I", "-c", program], cwd=tmp_path, text=True)
    assert Path(printed.strip()) == PROJECT / "Snakefile"


def test_a_new_lab_simulates_and_computes_on_its_own(installed: Installed) -> None:
    """Its first study is the demonstration; nothing of the clone is needed to plan it."""
    lab = installed.lab("erstes Labor")
    planned = installed.snakemake(lab, "--dry-run")
    assert "simulate_recording_way_points_pushed" in planned
    assert "write_report" in planned
    assert str(PROJECT) not in planned
    told = installed.run("ur5", "--help", folder=lab)
    assert "Usage" in told
    assert all(f" {own.name} " in told for own in commands_beside())


MODULE = """configfile: "config.yaml"
module ur5:
    snakefile: "{snakefile}"
    config: config
use rule * from ur5
"""


@pytest.mark.parametrize(("name", "text"), [("Snakefile", MODULE), ("workflow/Snakefile", "")])
def test_the_installed_workflow_runs_where_one_stands(
    installed: Installed, tmp_path: Path, name: str, text: str
) -> None:
    """Also without a Snakefile of one's own, and from where Snakemake's catalogue expects it."""
    small_study(tmp_path)
    snakefile = installed.library / "workflow" / name
    given = tmp_path / "Snakefile" if text else snakefile
    if text:
        given.write_text(text.format(snakefile=snakefile))
    assert "write_report" in installed.snakemake(tmp_path, "--snakefile", str(given), "--dry-run")


def files_of(folder: Path) -> dict[Path, int]:
    """Each file below, and when it was changed; byte-code aside."""
    files = (path for path in folder.rglob("*") if path.suffix != ".pyc")
    return {path: path.stat().st_mtime_ns for path in files if path.is_file()}


def test_a_published_study_needs_its_recordings_alone(installed: Installed) -> None:
    lab = installed.lab("veröffentlicht")
    recordings = shared_folder("ur3-cb", "they are recordings of a real UR3")
    (lab / "raw" / "ur3-cb").symlink_to(recordings)
    planned = installed.snakemake(lab, "--configfile", "workflow/studies/ur3-cb.yaml", "--dry-run")
    assert "read_recording" in planned


@pytest.mark.thorough
@pytest.mark.slow  # installs all that the package depends on, and builds the demonstration
def test_from_the_wheel_to_the_first_report_by_pipx(
    wheel: Path, tmp_path: Path, common_folder: Path
) -> None:
    """With the packages alone that the wheel asks for; nothing is written beside the library."""
    pins = re.findall(r"^\S+==\S+", (PROJECT / "requirements.lock").read_text(), re.MULTILINE)
    (tmp_path / "pins").write_text("\n".join(pins))
    pipx = [sys.executable, "-m", "pipx", "install", "--quiet", "--include-deps", wheel]
    places = {"PIPX_HOME": str(tmp_path / "home"), "PIPX_BIN_DIR": str(tmp_path / "bin")}
    # what is used is compiled then
    pip = {"PIP_CONSTRAINT": str(tmp_path / "pins"), "PIP_COMPILE": "0"}
    subprocess.run(pipx, env=os.environ | places | pip, check=True)
    [library] = (tmp_path / "home").glob("venvs/*/lib/python*/site-packages/ur5lib")
    before = files_of(library)
    here = Installed(tmp_path, tmp_path)
    lab = here.lab("mylab")
    demo = "results/demo"
    assert f"report: {demo}/report.html" in here.run("snakemake", folder=lab)
    assert (lab / demo / "report.pdf").stat().st_size > 10_000
    assert files_of(library) == before
    lab.rename(common_folder / "lab")  # where tests/artefacts/test_demo.py looks at it


@pytest.mark.thorough
@pytest.mark.slow  # simulates and reads a study
def test_labs_never_mix(installed: Installed) -> None:
    """A change of the package repeats what depends on it, in the lab that has the change."""
    lab, other = installed.lab("zweites Labor"), installed.lab("drittes Labor")
    small_study(lab)
    target = "results/made/recordings/moved/robot.parquet"
    read = ("--dry-run", "--quiet", "host", "--", target)
    installed.snakemake(lab, target)
    assert not (other / "results").exists()
    moved = lab.rename(installed.labs / "umgezogen")
    assert "Nothing to be done" in installed.snakemake(moved, *read)

    updated = Installed(installed.labs / "neues Paket", installed.labs)
    shutil.copytree(installed.environment, updated.environment, symlinks=True)
    set_mode(updated.environment, writable=True)
    edited = updated.library / "recordings" / "frames.py"
    edited.write_text(edited.read_text() + "\nADDED = True\n")
    planned = updated.snakemake(moved, *read)
    assert "read_recording" in planned
    assert "Params have changed" in planned
    assert "simulate_recording" not in planned
    assert "Nothing to be done" in installed.snakemake(moved, *read)
