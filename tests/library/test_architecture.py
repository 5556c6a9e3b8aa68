"""How the code hangs together."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROJECT

ROOMS = ["recordings", "signals", "dynamics", "identification", "force", "stand", "report"]
GROUND_FLOOR = ["errors", "metrics", "strict", "trajectories"]
LIGHT_STEPS = [
    "repair_frames",
    "fit_residuals",
    "estimate_forces",
    "compare_forces",
    "set_threshold",
    "detect_contacts",
    "ablate_forces",
    "make_tables",
    "draw_figures",
    "time_steps",
]
MODULES = sorted((PROJECT / "ur5lib").rglob("*.py"))


def imports(path: Path) -> set[str]:
    tree = ast.parse(path.read_text())
    froms = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    plain = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    return froms | plain


def test_only_dynamics_imports_torch() -> None:
    """Nor does any other module by way of others: tried in a fresh interpreter."""
    modules = [
        ".".join(path.relative_to(PROJECT).with_suffix("").parts)
        for path in MODULES
        if "dynamics" not in path.parts and path.name != "__init__.py"
    ]
    program = f"import sys, {', '.join(modules)}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=False).returncode == 0


@pytest.mark.parametrize(
    ("package", "steps"),
    [
        ("scipy.stats", LIGHT_STEPS),
        ("scipy.signal", LIGHT_STEPS),
        (
            "scipy.optimize",
            ["fit_residuals", "compare_forces", "estimate_forces", "detect_contacts"],
        ),
        ("pytorch_kinematics", ["compute_torques", "estimate_payload", "identify_model"]),
    ],
)
def test_no_step_waits_for_a_package_in_vain(package: str, steps: list[str]) -> None:
    """Loading one of these takes longer than most steps work."""
    paths = [f"workflow/scripts/{step}.py" for step in steps]
    program = f"import runpy, sys; [runpy.run_path(path) for path in {paths}]"
    program += f"; sys.exit({package!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=False).returncode == 0


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_do_not_import_one_another(room: str) -> None:
    others = tuple(f"ur5lib.{other}" for other in ROOMS if other != room)
    for path in (PROJECT / "ur5lib" / room).rglob("*.py"):
        assert not [name for name in imports(path) if name.startswith(others)], path


@pytest.mark.parametrize("module", GROUND_FLOOR)
def test_the_ground_floor_knows_no_room(module: str) -> None:
    """What several rooms share imports none of them, nor what lies above them."""
    used = {name for name in imports(PROJECT / "ur5lib" / f"{module}.py") if "ur5lib" in name}
    assert used <= {f"ur5lib.{other}" for other in GROUND_FLOOR}


def test_robots_know_no_other_room() -> None:
    for path in (PROJECT / "ur5lib" / "robots").glob("*.py"):
        assert not [n for n in imports(path) if n.startswith(tuple(f"ur5lib.{r}" for r in ROOMS))]


def test_tables_are_read_and_written_in_one_place() -> None:
    """pd.read_csv, to_parquet and their kind appear in tables.py and the readers alone."""
    words = ("read_parquet", "to_parquet", "to_csv(", "pd.read_csv", "json.dump(")
    sources = [*MODULES, *(PROJECT / "workflow" / "scripts").glob("*.py")]
    users = {path.name for path in sources if any(word in path.read_text() for word in words)}
    assert users == {"tables.py"}


def test_no_script_reads_the_configuration() -> None:
    for path in (PROJECT / "workflow" / "scripts").glob("*.py"):
        assert ".config" not in path.read_text(), path


def test_functions_are_short() -> None:
    lengths = []
    for path in [*MODULES, *(PROJECT / "workflow" / "scripts").glob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                first = node.body[1] if ast.get_docstring(node) and node.body[1:] else node.body[0]
                lengths.append((node.body[-1].end_lineno or 0) - first.lineno + 1)
    assert sorted(lengths)[len(lengths) // 2] < 10
    assert max(lengths) <= 40
