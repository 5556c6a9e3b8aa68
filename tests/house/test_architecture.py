"""How the code hangs together."""

import ast
import functools
import graphlib
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.conftest import PROJECT
from tests.synthetic import poor_log
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files, write_study
from ur5lib.jobs.code import all_steps, module_of, modules_of_step
from ur5lib.jobs.declared import declared
from ur5lib.records.forces import REFERENCES
from ur5lib.report.page.handed import ROWS
from ur5lib.robots.description import load_robot, robot_path

BASE = {"timeseries", "robots", "channels", "errors", "strict", "tables"}  # below every room
METHODS = {"signals", "dynamics", "identification", "force"}
ROOMS = METHODS | {"recordings", "checks", "smoothing", "excitation"}
ARROWS = {  # what each part of ur5lib may import, besides itself
    "timeseries": set(),
    "channels": set(),
    "errors": set(),
    "strict": {"errors"},
    "workspace": {"errors", "strict", "tables"},
    "datasets": {"errors", "strict", "tables"},
    "tables": {"channels", "errors", "timeseries"},
    "robots": {"channels", "errors", "strict", "timeseries", "workspace"},
    # rooms know records, and not each other but for what stands here
    "recordings": BASE | {"records", "workspace"},
    "checks": BASE | {"recordings", "records"},
    "signals": BASE | {"records"},
    "dynamics": BASE,
    "identification": BASE | {"records"},
    "force": BASE | {"records", "workspace"},
    "smoothing": BASE | {"records", "signals"},
    "excitation": BASE | {"dynamics", "identification", "records"},
    "records": BASE,
    "stand": BASE | {"records"},
    "judging": BASE | {"force", "records"},
    "report": BASE
    | METHODS - {"signals", "dynamics"}
    | {"datasets", "judging", "records", "workspace"},
    # steps join the rooms; jobs know them by their names alone
    "steps": BASE | ROOMS - {"excitation"} | {"judging", "stand", "records", "report", "workspace"},
    "jobs": {"errors", "records", "report", "robots", "strict", "tables", "workspace"},
    "study": BASE | {"jobs", "stand", "recordings", "records", "workspace"},
    "chain": BASE | {"dynamics", "identification", "jobs", "records", "study", "workspace"},
    "finished": BASE | {"chain", "jobs", "records", "study", "workspace"},
    "commands": BASE
    | METHODS - {"dynamics"}
    | {"chain", "checks", "finished", "jobs", "recordings"}
    | {"records", "report", "steps", "study", "workspace"},
    "importing": BASE
    | {"chain", "checks", "commands", "recordings", "records", "study", "workspace"},
    "cli": BASE | {"commands", "datasets", "importing", "study", "workspace"},
    # a topic knows the steps' records, and the report's blocks and figures; nothing knows it
    "topics": BASE
    | ROOMS
    | {"chain", "commands", "finished", "jobs", "judging", "records"}
    | {"report", "stand", "steps", "study"},
}
DESIGN = (PROJECT / "docs" / "design.md").read_text()
TABLE_OF_FLOORS = DESIGN.partition("| floor | parts of `ur5lib` |")[2].partition("\n\n")[0]
FLOORS = [re.findall(r"`(\w+)`", row.split("|")[2]) for row in TABLE_OF_FLOORS.splitlines()[2:]]
HEIGHTS = {part: height for height, floor in enumerate(FLOORS) for part in floor}
DISTRIBUTIONS = packages_distributions()
COME_ALONG = {"mujoco-core", "mujoco-studio", "pydantic-core"}  # with what is declared
MODULES = sorted((PROJECT / "ur5lib").rglob("*.py"))
BESIDE = sorted(path.name for path in PROJECT.glob("ur5*") if path.name != "ur5lib")
EVERY = MODULES + sorted(path for package in BESIDE for path in (PROJECT / package).rglob("*.py"))
AROUND = sorted(path for part in ("tests", "benchmarks") for path in (PROJECT / part).rglob("*.py"))
STEPS_OF_TOPICS = [step for step in all_steps() if "topics" in module_of(step).parts]
TOPICS = sorted({module_of(step).parent for step in STEPS_OF_TOPICS})


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__")


FILES = {name_of(path): path for path in EVERY + AROUND}


@functools.cache
def imports(path: Path) -> set[str]:
    tree = ast.parse(path.read_text())
    froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names = {node.module or "" for node in froms}
    names |= {
        f"{node.module}.{own.name}"
        for node in froms
        if node.module in {"ur5lib", "benchmarks", *BESIDE}
        for own in node.names
        if not own.name.startswith("_")
    }
    plain = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    return names | plain


def users_of(package: str) -> set[Path]:
    """All files that import it, directly or not."""
    users = set[Path]()
    while (
        more := {
            path
            for path in FILES.values()
            for name in imports(path)
            if f"{name}.".startswith(f"{package}.") or FILES.get(name) in users
        }
        - users
    ):
        users |= more
    return users


def brought_for(package: str) -> set[str]:
    """The distributions that a package of the wheel imports, but for this one."""
    files = (PROJECT / package).rglob("*.py")
    names = {name.partition(".")[0] for path in files for name in imports(path)}
    found = (own for name in names - {"ur5lib"} for own in DISTRIBUTIONS.get(name, []))
    return {*map(canonicalize_name, found)}


def test_the_wheel_needs_what_ur5lib_imports() -> None:
    """All of it is declared; what a package beside imports alone would be an extra."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    needed = {canonicalize_name(Requirement(line).name) for line in project["dependencies"]}
    extras = project["optional-dependencies"]["xarray"]
    asked = {canonicalize_name(Requirement(line).name) for line in extras}
    own, beside = brought_for("ur5lib"), set[str]().union(*map(brought_for, BESIDE))
    assert own - needed - asked == COME_ALONG | {"scikit-learn"}  # which asks a model for its tags
    assert needed - own == {"clarabel", "font-source-sans-pro"}  # by name, and as files
    assert beside - own == set()


@pytest.mark.parametrize("package", BESIDE)
def test_nothing_but_its_tests_and_benchmarks_uses_a_package_beside(package: str) -> None:
    """The rest works as before where it is deleted (tests/workflow/test_packages.py)."""
    may = [PROJECT / package, PROJECT / "tests" / package.removeprefix("ur5")]
    may += [PROJECT / "benchmarks"]
    assert [path for path in users_of(package) if not {*may} & {*path.parents}] == []


def test_only_dynamics_imports_torch() -> None:
    """Whoever needs dynamics passes arrays through its door."""
    users = [path for path in MODULES if "torch" in imports(path)]
    rooms = {path.relative_to(PROJECT / "ur5lib").parts[0] for path in users}
    assert rooms == {"dynamics"}


def test_no_step_waits_for_torch_in_vain() -> None:
    """None that computes no dynamics loads it, which takes longer than most steps work."""
    moved = PROJECT / "ur5lib" / "dynamics" / "__init__.py"
    still = [step for step in all_steps() if moved not in modules_of_step(step)]
    assert {"fit_friction", "estimate_forces", "make_tables", "draw_figures"} <= {*still}
    program = f"import sys\nfrom ur5lib.jobs.job import load_step\n[*map(load_step, {still})]"
    program += "\nsys.exit('torch' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=True)


READ = "import ur5lib; ur5lib.read('run.csv', 'ur5')"
CHECK = "from ur5lib.cli import app; app(['check', 'mine.yaml'], standalone_mode=False)"


@pytest.mark.parametrize("command", [READ, CHECK], ids=["read", "check"])
def test_what_only_reads_loads_neither_torch_nor_matplotlib(command: str, tmp_path: Path) -> None:
    """Loading them takes longer than all else."""
    poor_log(load_robot(robot_path("ur5")), 20, 1).to_csv(tmp_path / "run.csv", index=False)
    write_study(import_files([tmp_path / "run.csv"], UserStatement("ur5")), tmp_path / "mine.yaml")
    program = f"import sys; {command}"
    program += "; print('loaded', {'torch', 'matplotlib', 'scipy.signal'} & {*sys.modules})"
    run = [sys.executable, "-c", program]
    done = subprocess.run(run, cwd=tmp_path, check=True, text=True, stdout=subprocess.PIPE)
    assert "loaded set()" in done.stdout


def part_of(module: str) -> str:
    """The room, the loose module or the package beside that a dotted name lies in."""
    package, _, rest = module.partition(".")
    return rest.partition(".")[0] if package == "ur5lib" else package


def test_the_parts_are_those_of_the_drawing() -> None:
    """Each on one floor; at most six are loose modules."""
    own_names = ("__init__.py", "__main__.py")  # that Python asks for
    paths = [path for path in MODULES if path.name not in own_names]
    assert {part_of(name_of(path)) for path in paths} == set(ARROWS)
    assert len([path for path in paths if path.parent == PROJECT / "ur5lib"]) <= 6
    drawn = [part for floor in FLOORS for part in floor]
    assert sorted(part for part in drawn if not part.startswith("ur5")) == sorted(ARROWS)
    assert {*BESIDE} <= {*drawn}  # one that was deleted is still drawn


@pytest.mark.parametrize("part", sorted(HEIGHTS))
def test_nothing_imports_from_a_floor_above_its_own(part: str) -> None:
    for path in (path for path in EVERY if part_of(name_of(path)) == part):
        of_ours = {name for name in imports(path) if name.startswith(("ur5lib.", *BESIDE))}
        above = {name for name in of_ours if HEIGHTS[part_of(name)] > HEIGHTS[part]}
        assert above == set(), path


def test_the_code_of_a_step_ends_at_its_floor() -> None:
    """A topic's, too: an edit to a command, or to how results are opened, repeats no step."""
    for step in all_steps():
        parts = {part_of(name_of(path)) for path in modules_of_step(step)} - {"", "topics"}
        assert {part for part in parts if HEIGHTS[part] > HEIGHTS["steps"]} == set(), step


def test_who_loads_a_module_by_its_name_is_drawn() -> None:
    """No import upwards hides in a name."""
    ways = re.compile("import_module|resolve_name|__import__")
    users = [
        path.relative_to(PROJECT / "ur5lib") for path in MODULES if ways.search(path.read_text())
    ]
    (drawn,) = re.findall(r"^By name, without an import.*?\n\n", DESIGN, re.MULTILINE | re.DOTALL)
    assert sorted(map(str, users)) == sorted(re.findall(r"`(\S+\.py)`", drawn))


def files_of(part: str) -> list[Path]:
    room = (PROJECT / "ur5lib").joinpath(*part.split("."))
    return [*room.rglob("*.py")] if room.is_dir() else [room.with_suffix(".py")]


@pytest.mark.parametrize("part", sorted(ARROWS))
def test_a_part_imports_what_the_drawing_allows(part: str) -> None:
    for path in files_of(part):
        used = {part_of(name) for name in imports(path) if name.startswith("ur5lib.")}
        assert used - {part} <= ARROWS[part], path


def topics_of(modules: set[str]) -> set[str]:
    """The topics that modules belong to."""
    return {name.split(".")[2] for name in modules if name.startswith("ur5lib.topics.")}


GOES_WITH = re.compile(r"^\| `ur5lib/topics/(\w+)`.*?\|(.*?)\|", re.MULTILINE)


def goes_with(topic: str) -> set[Path]:
    """The files that docs/design.md tells to delete with a topic: of packages beside, its tests and
    benchmarks."""
    listed = dict(GOES_WITH.findall(DESIGN))
    named = {PROJECT / name for name in re.findall(r"`(.*?)`", listed.get(topic, ""))}
    folders = f"tests/topics/{topic}", f"ur5lib/topics/{topic}", "benchmarks"
    return named.union(*((PROJECT / folder).rglob("*.py") for folder in folders))


@pytest.mark.parametrize("topic", [path.name for path in TOPICS])
def test_nothing_below_or_beside_a_topic_imports_it(topic: str) -> None:
    """So that its folder may be deleted, with what docs/design.md names; the report finds it by a
    loop."""
    for path in {*EVERY, *AROUND} - goes_with(topic):
        assert topic not in topics_of(imports(path)), path


def test_only_packages_beside_use_a_topic() -> None:
    """What goes with one besides its tests lies outside of ur5lib."""
    for topic in TOPICS:
        others = goes_with(topic.name) - {*topic.rglob("*.py")}
        assert not any(PROJECT / "ur5lib" in path.parents for path in others)


SECTIONS = sorted((PROJECT / "ur5lib").rglob("*.typ"))
OUTSIDE = [path for path in MODULES if "topics" not in path.parent.parts]
RULES = sorted((PROJECT / "workflow" / "rules").glob("*.smk"))
KEYS = {*re.findall(r'"(\w+)": ', (PROJECT / "workflow" / "study.schema.json").read_text())}


def rules_of(topic: Path) -> str:
    """The rules of a topic's own, if it has any."""
    path = topic / "rules.smk"
    return path.read_text() if path.exists() else ""


def outputs_of(topic: Path) -> str:
    """The outputs of a topic's rules, and of its declared steps, each in quotes."""
    steps = [declared(step) for step in STEPS_OF_TOPICS if topic in module_of(step).parents]
    files = [file for step in steps if step for file in step.writes.values()]
    stated = re.findall(r"output:.*?log:", rules_of(topic), re.DOTALL)
    return "".join([*stated, *(f'"{file}"' for file in files)])


def made_by(topic: Path) -> set[str]:
    """The tables that a topic's steps make, and the module of its views."""
    made = re.findall(r'"(\w+)\.csv"', outputs_of(topic))
    listed = re.findall(r"tables\(\[(.*?)\]\)", rules_of(topic), re.DOTALL)
    return {topic.name, *made, *re.findall(r"\w+", " ".join(listed))}


def files_made_by(topic: Path) -> set[str]:
    """The names of tables and other files that a topic's steps make, and these."""
    steps = {step for step in STEPS_OF_TOPICS if topic in module_of(step).parents}
    named = r"(?<![\w.])(\w+)(?:\.\w+)*\.(?:csv|json|parquet|html)\b"
    return (made_by(topic) - {topic.name}) | {*re.findall(named, outputs_of(topic))} | steps


def texts_of(path: Path) -> Iterator[str]:
    """The string literals of a module, or of rules, which are no Python."""
    if path.suffix == ".smk":
        yield from re.findall(r'"([^"\n]*)"', path.read_text())
        return
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def read_as_tables(path: Path) -> set[str]:
    """The tables that a module reads by name."""
    read = r"""(?:(?:rows|table|listed)\(|tables\[)\s*"(\w+)"|"(\w+)" (?:not )?in \w+\.tables"""
    return {name for found in re.findall(read, path.read_text()) for name in found if name}


@pytest.mark.parametrize("topic", TOPICS, ids=lambda path: path.name)
def test_no_file_outside_a_topic_names_what_it_makes(topic: Path) -> None:
    """Its tables, files and steps. A key of a study, or a kind of a sensor's reading, may have the
    same name; no table is read by it."""
    own = files_made_by(topic)
    assert own
    alike = own & (KEYS | {*REFERENCES})
    for path in OUTSIDE + RULES:
        named = {text.rpartition("/")[2].partition(".")[0] for text in texts_of(path)}
        assert named & (own - alike) == set(), path
        assert read_as_tables(path) & own == set(), path


@pytest.mark.parametrize("path", SECTIONS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_a_section_reads_no_topic_but_its_own(path: Path) -> None:
    """And imports the kit alone: the page is typeset where a topic's folder is deleted."""
    text = path.read_text()
    rows = {name.split(".")[0] for name in ROWS.findall(text)}
    of_others = set[str]().union(*(made_by(topic) for topic in TOPICS if topic != path.parent))
    assert rows & of_others == set()
    assert "/topics/" not in text
    used = [name for name in re.findall(r'#import "(.*?)"', text) if "kit" not in path.parts]
    assert all(name.startswith("/kit/") for name in used)


def test_no_step_imports_another() -> None:
    """What several share is a function of a room; a topic's steps are its own."""
    for path in (PROJECT / "ur5lib" / "steps").glob("*.py"):
        assert [name for name in imports(path) if name.startswith("ur5lib.steps")] == [], path


def test_a_step_has_its_name_alone() -> None:
    """Over all topics: it is found by its name."""
    assert len({*all_steps()}) == len(all_steps())


@pytest.mark.parametrize("part", sorted(ARROWS))
def test_no_arrow_of_the_drawing_is_idle(part: str) -> None:
    """But those to what is below every room, and a topic's, which may be deleted."""
    if part == "topics":
        return
    used = {part_of(name) for path in files_of(part) for name in imports(path) if "ur5lib." in name}
    assert ARROWS[part] - BASE <= used


def test_the_motion_is_smoothed_once() -> None:
    """Currents and forces take it from its file; with an IMU, it is smoothed beside it."""
    users = {
        path.stem
        for path in MODULES
        if path.parent.name != "smoothing"
        and any(name.startswith("ur5lib.smoothing") for name in imports(path))
    }
    assert users == {"align_recording", "compare_accelerations"}


def test_one_module_touches_the_inside_of_snakemake() -> None:
    """What it does not document: of its modules, all but two; in rules, members of `workflow`."""
    places = "workflow/rules/*.smk", "ur5lib/topics/*/rules.smk", "profiles/*/config.yaml"
    places += "Snakefile", "workflow/Snakefile", "ur5lib/workspace/templates/Snakefile"
    rules = [path for place in places for path in PROJECT.glob(place)]
    inside = re.compile(r"(from|import) snakemake(?!\.(exceptions|utils) import)|\bworkflow\.\w")
    users = [path.name for path in EVERY + rules if inside.search(path.read_text())]
    assert users == ["snakemake_inside.py"]


def test_no_module_imports_itself_by_way_of_others() -> None:
    names = {name_of(path): path for path in EVERY if path.name != "__init__.py"}
    used = {name: imports(path) & names.keys() for name, path in names.items()}
    graphlib.TopologicalSorter(used).prepare()  # raises CycleError


def test_tables_are_read_and_written_in_one_place() -> None:
    """pd.read_csv, to_parquet and their kind appear in tables.py and the readers alone."""
    words = ("read_parquet", "to_parquet", "to_csv(", "pd.read_csv", "json.dump(")
    users = {path.name for path in EVERY if any(word in path.read_text() for word in words)}
    assert users == {"tables.py"}


def test_readers_ask_the_registry_which_estimate_leads() -> None:
    readers = ("ur5lib/report", "ur5lib/commands", *BESIDE)
    paths = [path for reader in readers for path in (PROJECT / reader).rglob("*.py")]
    paths += SECTIONS
    assert [path for path in paths if '"Fmap"' in path.read_text()] == []


def test_functions_are_short() -> None:
    lengths = []
    for path in EVERY:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                first = node.body[1] if ast.get_docstring(node) and node.body[1:] else node.body[0]
                lengths.append((node.body[-1].end_lineno or 0) - first.lineno + 1)
    assert sorted(lengths)[len(lengths) // 2] < 10
    assert max(lengths) <= 40


def test_functions_take_at_most_eight_parameters() -> None:
    """But commands, with the options of the command line."""
    commands = {PROJECT / "ur5lib" / "cli.py", PROJECT / "ur5lab" / "commands.py"}
    for path in {*EVERY} - commands:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                taken = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                assert len([own for own in taken if own.arg not in {"self", "cls"}]) <= 8, node.name


STEPS = [*(PROJECT / "ur5lib" / "steps").glob("[!_]*.py"), *map(module_of, STEPS_OF_TOPICS)]


@pytest.mark.parametrize("path", STEPS, ids=lambda path: path.stem)
def test_a_step_is_typed_and_reads_no_file(path: Path) -> None:
    """From records to records: nothing in its signature may be anything, and no name of a file or
    of the configuration stands in it."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name == path.stem:
            given = [ast.unparse(own.annotation or ast.Constant("Any")) for own in node.args.args]
            assert not any(re.search(r"\bAny\b", own) for own in given), given
            assert node.returns is not None
    text = path.read_text()
    assert not re.search(r"snakemake|\bworkflow/|\bconfig\[|results/", text)
