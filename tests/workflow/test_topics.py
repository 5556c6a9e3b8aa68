"""Topics: deleted, their folders take their own results along, and change no other."""

import re
import shutil
from pathlib import Path

import pytest

from tests.conftest import PROJECT, Workflow, copy_project
from ur5lib.workspace.places import PACKAGE

pytestmark = [pytest.mark.slow, pytest.mark.thorough]

TOPICS = sorted(path.parent.name for path in PACKAGE.glob("topics/*/section.typ"))
OF_A_RUN = {
    ".running",
    "run_times.csv",
    "ro-crate-metadata.json",
    "tables.zip",
    "Snakefile",
    "report.pdf",
}
VERDICTS = "tables/verdicts.csv"
OF_ALL = {"What was found", "Provenance"}  # sections that name what all others have
NUMBERED = re.compile(r"(Table|Figure)[ \xa0]\d+")


def results(folder: Path) -> dict[str, bytes]:
    """The files of a study by their names, but for pages and for what tells of the run itself."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    named = {str(path.relative_to(folder)): path for path in files if path.name not in OF_A_RUN}
    kept = {name for name in named if not name.startswith(("logs/", "benchmarks/"))}
    return {name: named[name].read_bytes() for name in kept if not name.endswith(".html")}


def sections(page: Path) -> dict[str, str]:
    """The sections of a page by their titles, tables and figures without their numbers."""
    parts = page.read_text().split("<section ")[1:]
    by_title = {re.findall(r"<h2[^>]*>(.*?)</h2>", part)[0]: part for part in parts}
    return {title: NUMBERED.sub(r"\1", part) for title, part in by_title.items()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of the default study with all topics."""
    return built(tmp_path_factory.mktemp("whole") / "project")


def built(folder: Path, *without: str) -> Path:
    """The results of the default study in a fresh copy of the project."""
    workflow = Workflow(copy_project(folder))
    for topic in without:
        shutil.rmtree(folder / "ur5lib" / "topics" / topic)
    workflow.build()
    return folder / "results" / "demo"


@pytest.mark.parametrize("topic", TOPICS)
def test_a_deleted_topic_changes_no_other_result(whole: Path, tmp_path: Path, topic: str) -> None:
    folder = PROJECT / "ur5lib" / "topics" / topic
    section = (folder / "section.typ").read_text()
    stated = [path.read_text() for path in (*folder.glob("rules.smk"), *folder.glob("*.py"))]
    titles = {*re.findall(r'"(.*?)"', " ".join(re.findall(r"^#let .*title = .*", section, re.M)))}
    before, without = results(whole), built(tmp_path / "project", topic)
    after = results(without)
    assert after.keys() <= before.keys()
    gone = {Path(name).stem for name in before.keys() - after.keys()}
    assert {name for name in gone if name not in "".join([*stated, section])} == set()
    told = {"results.json", VERDICTS}  # findings, steps and verdicts, its own among them
    assert [name for name in after if after[name] != before[name] and name not in told] == []
    own = b"".join(before[name] for name in before.keys() - after.keys() if "verdicts" in name)
    questions = {line.partition(b",")[0] for line in own.splitlines()[1:]}
    kept = [one for one in before[VERDICTS].splitlines() if one.partition(b",")[0] not in questions]
    assert after[VERDICTS].splitlines() == kept
    for name in ("report.html", "details.html"):
        left, all_of_them = sections(without / name), sections(whole / name)
        assert all_of_them.keys() - left.keys() <= titles
        others = left.keys() - OF_ALL
        assert [title for title in others if left[title] != all_of_them[title]] == []
