"""Where the tests find the project, the real recordings, and results to look at."""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import hypothesis
import pandas as pd
import pytest

from tests import warm_snakemake
from tests.command import Command
from tests.session import pytest_runtest_makereport as pytest_runtest_makereport
from tests.session import pytest_runtest_protocol as pytest_runtest_protocol
from tests.session import pytest_sessionfinish as pytest_sessionfinish
from tests.synthetic import write_recording
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.tables import read_csv

if TYPE_CHECKING:
    from tests.real_arms import RealStudy

pytest.register_assert_rewrite("tests.artefacts.documents")  # which says what Axe found
# An example takes as long as the machine's other work lets it.
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")

PROJECT = Path(__file__).parents[1]
KEPT = PROJECT / ".pytest_cache" / "studies"  # built ones, for later sessions
COPIED = [
    "Snakefile",
    "CITATION.cff",
    "config.yaml",
    "profiles",
    "workflow",
    "pyproject.toml",
    *sorted(path.name for path in PROJECT.glob("ur5*")),  # the packages
]
Change = Callable[[str, str | None], None]
STUDY = """\
study: small
title: Two made-up recordings
recordings:
  - {name: still, robot: ur5, format: thesis-csv, folder: raw/still, role: fit}
  - {name: pushed, robot: ur5, format: thesis-csv, folder: raw/pushed, role: contact}
"""


BUILD_FOR_OTHERS = ["test_thesis.py", "test_lab.py", "test_e_series.py", "test_loads.py"]
LONGEST = ["artefacts", "workflow", "lab", "rivals"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with studies that others look at, who would wait, or build them again.

    Then come the folders with the longest files, so that both processes end at about one time.
    """
    order = {name: place for place, name in enumerate([*BUILD_FOR_OTHERS, *LONGEST])}

    def place(item: pytest.Item) -> int:
        parts = item.path.relative_to(PROJECT).parts
        return min(order.get(part, len(order)) for part in parts)

    items.sort(key=place)


@pytest.fixture(scope="session")
def ur5() -> Robot:
    return load_robot(robot_path("ur5"))


@pytest.fixture(scope="session")
def ur5e() -> Robot:
    return load_robot(robot_path("ur5e"))


@pytest.fixture
def run_ur5(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Command:
    return Command(monkeypatch, capsys)


@pytest.fixture
def on_a_terminal() -> Iterator[None]:
    """Signals as on a terminal; under nohup, and in the background, programs ignore some."""
    usual = {signal.SIGHUP: signal.SIG_DFL, signal.SIGINT: signal.default_int_handler}
    before = {number: signal.signal(number, handler) for number, handler in usual.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def said(finding: Finding) -> str:
    """The sentence of the report and of `ur5 check` about a finding."""
    return finding.sentence()


def table_of_topic(results: Path, name: str) -> pd.DataFrame:
    """A table of a study that a topic makes, as far as there is that topic."""
    file = results / "tables" / f"{name}.csv"
    if not file.exists():
        pytest.skip(f"the topic of {name}.csv is deleted")
    return read_csv(file)


def shared_folder(name: str, remedy: str, *others: Path) -> Path:
    """A folder of files that the project does not contain, where it is at hand."""
    for folder in (*others, PROJECT.parent / "shared" / name):
        if folder.is_dir():
            return folder
    pytest.skip(f"the files of ../shared/{name} are not here: {remedy}")


@pytest.fixture(scope="session")
def thesis_data() -> Path:
    return shared_folder("thesis", "`make thesis` fetches them", PROJECT / "raw" / "thesis")


@pytest.fixture(scope="session")
def ur10e_data() -> Path:
    return shared_folder("ur10e", "`ur5 fetch ur10e` fetches them", PROJECT / "raw" / "ur10e")


@pytest.fixture(scope="session")
def common_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A temporary folder of all processes of this session."""
    folder = tmp_path_factory.getbasetemp()
    return folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder


@pytest.fixture(scope="session")
def kept_motion(common_folder: Path) -> Path:
    """Where smoothed motion of real recordings is kept, for all processes of this session."""
    return common_folder / "motion"


@pytest.fixture(scope="session")
def real_ur5(thesis_data: Path, kept_motion: Path) -> "RealStudy":
    from tests.real_arms import RealStudy, workflow_study

    return RealStudy(workflow_study("thesis", thesis_data), kept_motion)


@pytest.fixture(scope="session")
def real_ur10e(ur10e_data: Path, kept_motion: Path) -> "RealStudy":
    from tests.real_arms import RealStudy, workflow_study

    return RealStudy(workflow_study("ur10e", ur10e_data), kept_motion)


@pytest.fixture(scope="session")
def real_ur3(kept_motion: Path) -> "RealStudy":
    """Three runs of another lab, of which only positions, speeds and currents are known."""
    from tests.real_arms import RealStudy
    from ur5lib.study.reading import parse_study

    folder = shared_folder("ur3-cb", "they are recordings of a real UR3")
    channels = ["time", "actual_q", "actual_qd", "actual_current"]
    alike = {"robot": "ur3", "format": "table-csv", "folder": str(folder), "role": "fit"}
    files = {"id1": "id1.csv", "id2": "id2.csv", "circle": "_2019-11-27-20-59-11.csv"}
    runs = [alike | {"name": n, "file": file, "columns": channels} for n, file in files.items()]
    return RealStudy(
        parse_study({"study": "ur3", "title": "", "recordings": runs}, ""), kept_motion
    )


def copy_project(target: Path) -> Path:
    """The project's own files, compiled or not, without environment, recordings and results."""
    target.mkdir()
    for name in COPIED:
        source = PROJECT / name
        if source.is_dir():
            shutil.copytree(source, target / name)
        else:
            shutil.copy(source, target / name)
    return target


class Workflow:
    """A copy of the project in which Snakemake can be run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # of no commit, wherever it lies, also within the clone
        without_commit = {"GIT_CEILING_DIRECTORIES": str(folder.parent)}
        self.environment = os.environ | {"PYTHONPATH": str(folder)} | without_commit

    def copied(self, target: Path) -> "Workflow":
        """All of it, in another place."""
        return Workflow(Path(shutil.copytree(self.folder, target)))

    def command(self, *arguments: str) -> list[str]:
        return [sys.executable, "-m", "snakemake", *arguments]

    def run(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return warm_snakemake.run(self.folder, self.environment, arguments)

    def build(self, *arguments: str) -> None:
        """Run; among other processes of tests by one worker, which loads all packages once."""
        cores = ("--cores", "1") if "PYTEST_XDIST_WORKER" in os.environ else ()
        done = self.run("--quiet", "rules", *cores, *arguments)
        assert done.returncode == 0, done.stdout

    def ur5(self, *arguments: str) -> str:
        """What a command of `ur5` prints."""
        told = warm_snakemake.run_ur5(self.folder, self.environment, arguments)
        assert told.returncode == 0, told.stderr
        return told.stdout

    def plan(self, *arguments: str) -> dict[str, int]:
        """How many jobs of each rule the next run would do."""
        done = self.run("--dry-run", *arguments)
        assert done.returncode == 0, done.stdout
        if "Nothing to be done" in done.stdout:
            return {}
        table = done.stdout.split("Job stats:")[1].split("total")[0].splitlines()[3:]
        counts = {line.split()[0]: int(line.split()[1]) for line in table if line.strip()}
        return {rule: count for rule, count in counts.items() if rule != "all"}


def build_once(folder: Path, prepare: Callable[[Path], None], *arguments: str) -> Workflow:
    """A study in a copy of the project: the first process that needs it builds it, others wait.

    It is kept for later sessions, which repeat the steps whose code, settings or files are others
    then. folder: of this session, with the study's name; prepare: puts recordings and settings
    into the copy.
    """
    kept, built = KEPT / folder.name, folder.with_name(f"{folder.name}.built")
    KEPT.mkdir(parents=True, exist_ok=True)
    with open(f"{kept}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            with tempfile.TemporaryDirectory() as other:
                new = copy_project(Path(other) / "project")
                prepare(new)
                bring_up_to_date(kept, new)
            Workflow(kept).build(*arguments)
            built.touch()
    return Workflow(kept)


def bring_up_to_date(kept: Path, new: Path) -> None:
    """Replace the files of a folder that are others than the new ones; results stay."""
    if not kept.exists():
        shutil.move(new, kept)
        return
    wanted = sources(new)
    for name in sources(kept) - wanted:
        (kept / name).unlink()
    for name in wanted:
        if content(kept / name) != content(new / name):
            (kept / name).unlink(missing_ok=True)
            (kept / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(new / name, kept / name, follow_symlinks=False)


def sources(folder: Path) -> set[Path]:
    """The files of a folder, and its links, that no run of a study wrote."""
    paths = {path.relative_to(folder) for path in folder.rglob("*") if content(path) is not None}
    written = {"results", ".snakemake", "__pycache__"}
    return {path for path in paths if written.isdisjoint(path.parts)}


def content(path: Path) -> bytes | str | None:
    """What a link leads to, or a file holds."""
    if path.is_symlink():
        return os.readlink(path)
    return path.read_bytes() if path.is_file() else None


def put_small_study(folder: Path) -> None:
    (folder / "config.yaml").write_text(STUDY)
    write_recording(folder / "raw" / "still", seconds=3, seed=1)
    write_recording(folder / "raw" / "pushed", seconds=4, seed=2, force_sensor=True)


@pytest.fixture(scope="session")
def built_workflow(common_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """A small study of two made-up recordings, built once; each process has a copy."""
    workflow = build_once(common_folder / "small", put_small_study)
    return workflow.copied(tmp_path_factory.mktemp("small") / "project")


@pytest.fixture
def change(built_workflow: Workflow) -> Iterator[Change]:
    """Append text to a file of the built study, or remove it, until the test ends."""
    kept: list[tuple[Path, Path]] = []

    def changed(name: str, more: str | None) -> None:
        file = built_workflow.folder / name
        aside = file.with_name(f"{file.name}.aside")
        file.rename(aside)
        kept.append((aside, file))
        if more is not None:
            file.write_text(aside.read_text() + more)

    yield changed
    for aside, file in kept:
        aside.replace(file)


@pytest.fixture
def workflow(built_workflow: Workflow, tmp_path: Path) -> Workflow:
    """The small study as built, in a copy of its own."""
    return built_workflow.copied(tmp_path / "project")


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory, common_folder: Path) -> Workflow:
    """The default study, simulated and built: by the installed package, where that was tested."""

    def prepare(folder: Path) -> None:
        for part in (common_folder / "lab").glob("*"):
            if part.name in ("raw", "results", ".snakemake"):
                shutil.copytree(part, folder / part.name)

    workflow = build_once(common_folder / "demo", prepare)  # what is missing
    return workflow.copied(tmp_path_factory.mktemp("demo") / "project")


@pytest.fixture(scope="session")
def thesis_results(thesis_data: Path, common_folder: Path) -> Path:
    """The thesis study, built once from its real recordings; nothing may be written there."""

    def prepare(folder: Path) -> None:
        (folder / "raw").mkdir()
        (folder / "raw" / "thesis").symlink_to(thesis_data)

    arguments = "--configfile", "workflow/studies/thesis.yaml"
    return build_once(common_folder / "thesis", prepare, *arguments).folder / "results" / "thesis"
