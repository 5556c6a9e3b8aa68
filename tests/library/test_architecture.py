"""How the code hangs together."""

import ast
import graphlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROJECT

ROOMS = {"recordings", "checks", "signals", "dynamics", "identification", "force", "lab.stand"}
BASE = {"timeseries", "robots", "channels", "errors", "strict", "tables"}  # below every room
ARROWS = {  # what each part of ur5lib may import, besides itself
    "timeseries": set(),
    "channels": set(),
    "errors": set(),
    "strict": {"errors"},
    "workspace": {"errors", "strict", "tables"},
    "steps": {"errors", "workspace"},
    "datasets": {"errors", "strict", "tables"},
    "tables": {"channels", "errors", "timeseries"},
    "robots": {"errors", "strict", "timeseries", "workspace"},
    **dict.fromkeys(ROOMS, BASE),
    "recordings": BASE | {"workspace"},
    "checks": BASE | {"recordings"},
    "smoothing": BASE | {"signals"},
    "lab.recorder": BASE,
    "lab.doubles": BASE | {"lab.recorder", "lab.stand"},
    "excitation": BASE | {"dynamics", "identification"},
    "records": BASE | ROOMS | {"pipeline"},
    "pipeline": BASE | ROOMS | {"records", "smoothing", "workspace"},
    "report": BASE | ROOMS | {"excitation", "pipeline", "records", "workspace"},
    "study": BASE | {"lab.recorder", "lab.stand", "recordings"},
    "finished": {"errors", "pipeline", "records", "recordings", "robots", "study", "tables"},
    "commands": BASE
    | ROOMS
    | {"datasets", "excitation", "finished", "lab.doubles", "lab.recorder", "pipeline"}
    | {"records", "report", "study"},
    "leaderboard": BASE | ROOMS | {"pipeline", "records", "workspace"},
    "importing": BASE | {"checks", "commands", "dynamics", "recordings", "study"},
    "cli": BASE
    | {"commands", "datasets", "dynamics", "force", "importing", "leaderboard", "study"}
    | {"workspace"},
}
LIGHT = ("repair_frames", "set_threshold", "make_tables", "draw_figures")
LOADED = [  # steps, loaded one after the other, and the packages that none has loaded by then
    (
        ("fit_residuals", "compare_forces", "estimate_forces", "detect_contacts"),
        {"torch", "scipy.stats", "scipy.signal", "scipy.optimize"},
    ),
    ((*LIGHT, "time_steps"), {"torch", "scipy.stats", "scipy.signal"}),
    (("compute_torques", "estimate_payload", "identify_model"), {"pytorch_kinematics"}),
]
MODULES = sorted((PROJECT / "ur5lib").rglob("*.py"))
SCRIPTS = sorted((PROJECT / "workflow" / "scripts").glob("*.py"))


def imports(path: Path) -> set[str]:
    tree = ast.parse(path.read_text())
    froms = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    plain = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    return froms | plain


def test_only_dynamics_imports_torch() -> None:
    """Whoever needs dynamics passes arrays through its door."""
    users = [path for path in [*MODULES, *SCRIPTS] if "torch" in imports(path)]
    rooms = {path.relative_to(PROJECT / "ur5lib").parts[0] for path in users}
    assert rooms == {"dynamics", "leaderboard"}  # where others' networks learn


def test_no_step_waits_for_a_package_in_vain() -> None:
    """Loading one of these takes longer than most steps work."""
    program = f"import runpy, sys\nfor steps, packages in {LOADED}:"
    program += "\n [runpy.run_path(f'workflow/scripts/{step}.py') for step in steps]"
    program += "\n if found := sys.modules.keys() & packages: sys.exit(f'{steps}: {found}')"
    done = subprocess.run([sys.executable, "-c", program], cwd=PROJECT, capture_output=True)
    assert done.stderr.decode().strip() == ""


def part_of(module: str) -> str:
    """The room, the sub-package of the lab, or the loose module that a dotted name lies in."""
    _, room, *below = module.split(".")
    return f"lab.{below[0]}" if room == "lab" and below else room


def test_the_parts_are_those_of_the_drawing() -> None:
    names = [".".join(path.relative_to(PROJECT).with_suffix("").parts) for path in MODULES]
    assert {part_of(name) for name in names} - {"__init__", "lab.__init__"} == set(ARROWS)
    assert len([name for name in names if name.count(".") == 1]) <= 6 + 1  # and __init__.py


@pytest.mark.parametrize("part", sorted(ARROWS))
def test_a_part_imports_what_the_drawing_allows(part: str) -> None:
    room = (PROJECT / "ur5lib").joinpath(*part.split("."))
    paths = [*room.rglob("*.py")] if room.is_dir() else [room.with_suffix(".py")]
    for path in paths:
        used = {part_of(name) for name in imports(path) if name.startswith("ur5lib.")}
        assert used - {part} <= ARROWS[part], path


def test_only_the_estimate_of_accelerations_smooths() -> None:
    """Currents and forces take the motion from its file."""
    users = {
        path.stem
        for path in [*MODULES, *SCRIPTS]
        if path.parent.name != "smoothing"
        and any(name.startswith("ur5lib.smoothing") for name in imports(path))
    }
    steps = {"smooth_motion", "fuse_imu", "compare_accelerations"}
    assert users == steps | {"smoothed_motion", "fused_motion", "end_effector"}


def test_no_module_imports_itself_by_way_of_others() -> None:
    names = {path: ".".join(path.relative_to(PROJECT).with_suffix("").parts) for path in MODULES}
    used = {names[path]: imports(path) & set(names.values()) for path in MODULES}
    graphlib.TopologicalSorter(used).prepare()  # raises CycleError


def test_tables_are_read_and_written_in_one_place() -> None:
    """pd.read_csv, to_parquet and their kind appear in tables.py and the readers alone."""
    words = ("read_parquet", "to_parquet", "to_csv(", "pd.read_csv", "json.dump(")
    sources = [*MODULES, *SCRIPTS]
    users = {path.name for path in sources if any(word in path.read_text() for word in words)}
    assert users == {"tables.py"}


def test_readers_ask_the_registry_which_estimate_leads() -> None:
    readers = ("report", "commands", "leaderboard")
    paths = [path for room in readers for path in (PROJECT / "ur5lib" / room).rglob("*.py")]
    assert [path for path in paths if '"Fmap"' in path.read_text()] == []


def test_no_script_reads_the_configuration() -> None:
    for path in SCRIPTS:
        assert not re.search(r"\.config\b", path.read_text()), path


def test_functions_are_short() -> None:
    lengths = []
    for path in [*MODULES, *SCRIPTS]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                first = node.body[1] if ast.get_docstring(node) and node.body[1:] else node.body[0]
                lengths.append((node.body[-1].end_lineno or 0) - first.lineno + 1)
    assert sorted(lengths)[len(lengths) // 2] < 10
    assert max(lengths) <= 40


def test_scripts_are_short() -> None:
    """A script reads, calls and writes."""
    assert max(len(path.read_text().splitlines()) for path in SCRIPTS) <= 60
