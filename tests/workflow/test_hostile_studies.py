"""Studies from others: whatever one says, it runs nothing and writes nothing but results.

`ur5 check` and a run agree: what the one accepts, the other builds.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.command import Command
from tests.conftest import Workflow, copy_project
from tests.corpus import rtde

TRACE = "executed"
CODE = f"open('{TRACE}', 'w').close()"
EVALUATED = f"open('{TRACE}', 'w').close() or 'x'"
SHELL = f"touch {TRACE}"
ENTRY = {
    "name": "run",
    "role": "fit",
    "format": "rtde-csv",
    "folder": "raw/ok",
    "file": "robot.csv",
}
SOUND: dict[str, Any] = {"study": "mine", "title": "Mine", "robot": "ur5", "recordings": [ENTRY]}
YTE = "__use_yte__: true\n"


def text(**changes: Any) -> str:
    return yaml.safe_dump({**SOUND, **changes}, sort_keys=False, allow_unicode=True)


def of_entry(**changes: Any) -> str:
    return text(recordings=[{**ENTRY, **changes}])


def simulated(**changes: Any) -> str:
    plan = {"seconds": 10, "trajectory": {"kind": "standstill"}, **changes}
    return text(recordings=[{"name": "run", "role": "fit", "format": "rtde-csv", "simulate": plan}])


PROGRAMS = {  # Snakemake would run these
    "a definition": f'{YTE}__definitions__: ["{CODE}"]\n{text()}',
    "a definition at the end": f'{text()}__definitions__: ["{CODE}"]\n{YTE}',
    "a value": YTE + text(title=f"?{EVALUATED}"),
    "a value in a list": YTE + of_entry(folder=f"?{EVALUATED}"),
    "a key": f'{YTE}"?{EVALUATED}": 1\n{text()}',
    "a condition": f'{YTE}"?if {EVALUATED}": {{a: 1}}\n{text()}',
    "a loop": f'{YTE}"?for x in [{EVALUATED}]": {{a: 1}}\n{text()}',
    "a variable": f'{YTE}__variables__: {{x: "?{EVALUATED}"}}\n{text()}',
    "yes": text(title=f"?{EVALUATED}") + "__use_yte__: yes\n",
    "a number": text(title=f"?{EVALUATED}") + "__use_yte__: 1\n",
    "a word": text(title=f"?{EVALUATED}") + "__use_yte__: on request\n",
    "an escaped key": text(title=f"?{EVALUATED}") + '"\\x5f\\x5fuse_yte__": true\n',
    "a tagged key": text(title=f"?{EVALUATED}") + "!!str __use_yte__: true\n",
    "a merged key": text(title=f"?{EVALUATED}") + "<<: {__use_yte__: true}\n",
    "an anchored key": text(title=f"?{EVALUATED}") + "a: &k __use_yte__\n*k : true\n",
    "a byte-order mark": "\ufeff" + YTE + text(title=f"?{EVALUATED}"),
    "a document's head": "%YAML 1.1\n---\n" + YTE + text(title=f"?{EVALUATED}"),
    "flow": f'{{__use_yte__: true, title: "?{EVALUATED}"}}',
}
TAGS = {  # PyYAML's loaders for trusted files would run these
    "python/object/apply": f'!!python/object/apply:os.system ["{SHELL}"]',
    "python/object/new": f'!!python/object/new:os.system ["{SHELL}"]',
    "python/object": "!!python/object:os.system {}",
    "python/name": "!!python/name:os.system",
    "python/module": "!!python/module:os",
    "python/tuple": "!!python/tuple [1, 2]",
}
REFUSED = PROGRAMS | {
    **{name: f"{text()}extra: {tag}\n" for name, tag in TAGS.items()},
    # names and paths
    **{f"a study {name!r}": text(study=name) for name in ("..", ".", "../mine", "/tmp/mine", "")},
    **{f"a name {name!r}": of_entry(name=name) for name in ("..", "../../x", "/tmp/x", "a/b")},
    "a study with a command": text(study=f"$({SHELL})"),
    "a name with a command": of_entry(name=f"x;{SHELL}"),
    "a name with a quote": of_entry(name=f"x'; {SHELL}; '"),
    "a name of two lines": of_entry(name=f"x\n{SHELL}"),
    "a name with a placeholder": of_entry(name="{recording}"),
    "a long name": of_entry(name="ab" * 101),
    "a name of one letter": of_entry(name="a" * 30),
    "an arm's name that leaves": text(robot={"arm": "ur5", "name": "../../x"}),
    "an arm that leaves": text(robot="../ur5lib/robots/ur5"),
    "an arm with a command": text(robot=f"$({SHELL})"),
    "a comparison that leaves": text(compare_with=["../mine"]),
    "a folder with a placeholder": of_entry(folder="raw/{x}"),
    "a folder with a path variable": of_entry(folder="raw/<results>"),
    "a file with a placeholder": of_entry(file="{recording}.csv"),
    "a folder with a null character": of_entry(folder="raw/ok\0"),
    "a folder with a long name": of_entry(folder="raw/" + "a" * 300),
    "a long path": of_entry(folder="raw/ok/" + "a/../" * 1000),
    "a device": text(reference="/dev/zero"),
    "a link model with a placeholder": simulated(model="{recording}"),
    "way points that are a device": simulated(
        trajectory={"kind": "movej", "way_points": "/dev/tty"}
    ),
    # values
    "a long number": text(extra=0) + f"more: {'9' * 5000}\n",
    "a long hexadecimal number": text() + f"more: 0x{'f' * 5000}\n",
    "a date that is none": of_entry().replace("role: fit", "role: fit\n  date: 2026-13-45"),
    "a deep nest": text() + f"more: {'[' * 3000}{']' * 3000}\n",
    "a circle": text() + "more: &more [*more]\n",
    "two lists of recordings": text() + "recordings: []\n",
    "a key twice in an entry": of_entry().replace("role: fit", "role: fit\n  role: contact"),
    "many values": text() + f"more: [{'0, ' * 200_000}]\n",
    "a large file": text() + f"# {'x' * 5_000_000}\n",
    "a list": "- study\n- title\n",
    "a number as title": text(title=5),
    "mappings for words": text(study={"a": 1}, title={"b": 2}, robot=[1]),
}
ACCEPTED = {  # odd, and as good as any
    "a title of commands": text(
        title=f"<script>alert(1)</script> #read('x') \\input{{x}} {{x}} <x> `{SHELL}` $({SHELL}) %s"
    ),
    "a title that is asked for": text(title=f"?{EVALUATED}"),
    "hosts of commands": text(hosts={f"$({SHELL}) {{x}} <x>": ["imu"]}),
    "a folder with a command": of_entry(folder=f"raw/`{SHELL}` $({SHELL});{SHELL}"),
    "a folder with quotes": of_entry(folder=f"raw/'; {SHELL}; '\"; {SHELL}"),
    "a folder of two lines": of_entry(folder=f"raw/x\n{SHELL}"),
    "a folder that is an option": of_entry(folder="raw/--configfile=x"),
    "a folder beside this": of_entry(folder="raw/ok/../ok"),
    "names that are options": text(study="--cores", recordings=[{**ENTRY, "name": "-rf"}]),
}
STUDIES = REFUSED | ACCEPTED


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """A copy of the project, with one recording."""
    workflow = Workflow(copy_project(tmp_path_factory.mktemp("hostile") / "project"))
    rtde(workflow.folder / "raw", "ok", b",")
    for study in ACCEPTED.values():
        folder = workflow.folder / yaml.safe_load(study)["recordings"][0]["folder"]
        if not folder.exists():
            shutil.copytree(workflow.folder / "raw" / "ok", folder)
    return workflow


def files_beside_results(folder: Path) -> dict[Path, float]:
    """What a study may not change, by the time of its last change."""
    kept = (path for path in folder.iterdir() if path.name not in ("results", ".snakemake"))
    files = (file for path in kept for file in [path, *path.rglob("*")])
    there = (file for file in files if "__pycache__" not in file.parts and not file.is_dir())
    return {file: file.stat().st_mtime for file in there}


def test_there_are_sixty_of_them() -> None:
    assert len(STUDIES) >= 60


@pytest.mark.parametrize("name", STUDIES)
def test_the_check_of_a_study_runs_nothing_and_writes_nothing(
    lab: Workflow, run_ur5: Command, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(lab.folder)
    Path("theirs.yaml").write_text(STUDIES[name], encoding="utf-8")
    before = files_beside_results(lab.folder)
    checked = run_ur5("check", "theirs.yaml")
    assert files_beside_results(lab.folder) == before
    refused = name in REFUSED
    assert checked.status == refused, checked.line
    if refused:
        assert checked.err.startswith("ur5: theirs.yaml")


RUN = {*ACCEPTED, "a value", "a definition at the end", "a merged key", "python/object/apply"}
RUN |= {"a study '..'", "a name with a command", "a name with a placeholder", "a device"}
RUN |= {"a circle", "a list"}  # of each kind; a run reads all by the function that the check calls
OTHERS = (pytest.param(name, marks=pytest.mark.thorough) for name in STUDIES if name not in RUN)


@pytest.mark.parametrize("name", [*sorted(RUN), *OTHERS])
def test_a_run_agrees_and_writes_nothing_but_results(lab: Workflow, name: str) -> None:
    (lab.folder / "theirs.yaml").write_text(STUDIES[name], encoding="utf-8")
    before = files_beside_results(lab.folder)
    ran = lab.run("--cores", "1", "--until", "read_recording", "--configfile", "theirs.yaml")
    assert files_beside_results(lab.folder) == before
    refused = name in REFUSED
    assert ran.returncode == refused, ran.stdout
    if refused:
        assert "Traceback" not in ran.stdout
        assert "theirs.yaml" in ran.stdout


@pytest.mark.parametrize("command", ["make", "snakemake --workflow-profile none --cores 1"])
def test_the_usual_study_runs_nothing_either(lab: Workflow, command: str) -> None:
    usual = lab.folder / "config.yaml"
    usual.write_text(PROGRAMS["a value"], encoding="utf-8")
    shutil.copy(Path(__file__).parents[2] / "Makefile", lab.folder)
    path = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    set_up = ["--old-file", ".venv/ready"] if command == "make" else []
    done = subprocess.run(
        [*command.split(), *set_up],
        cwd=lab.folder,
        env=lab.environment | path,
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode != 0
    assert "config.yaml: `__use_yte__` tells Snakemake to run code" in done.stderr
    assert not (lab.folder / TRACE).exists()


WAYS = {  # to start, from another folder than the project's: there, and with which Snakefile
    "the root's": ("elsewhere", "Snakefile"),
    "the catalogue's": ("elsewhere", "workflow/Snakefile"),
    "in its folder": ("workflow", None),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_study_is_data_wherever_snakemake_starts(lab: Workflow, way: str) -> None:
    folder, snakefile = WAYS[way]
    here = Workflow(lab.folder / folder)
    here.folder.mkdir(exist_ok=True)
    here.environment |= {"PYTHONPATH": str(lab.folder)}
    (here.folder / "theirs.yaml").write_text(PROGRAMS["a value"], encoding="utf-8")
    chosen = ["--snakefile", str(lab.folder / snakefile)] if snakefile else []
    ran = here.run(*chosen, "--cores", "1", "--dry-run", "--configfile", "theirs.yaml")
    assert ran.returncode != 0
    assert "theirs.yaml: `__use_yte__` tells Snakemake to run code" in ran.stdout
    assert not (here.folder / TRACE).exists()
