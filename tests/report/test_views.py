"""Views select and sort rows of tables: nothing is judged or computed there."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import PROJECT

VIEWS = sorted((PROJECT / "ur5lib" / "report" / "views").glob("*.py"))
MAX_LINES = 600
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
STATISTICS = {"mean", "std", "var", "median", "quantile", "sum", "agg", "clip", "corr"}
OF_TABLES = {"numpy", "scipy"}


def nodes(path: Path) -> Iterator[ast.AST]:
    return ast.walk(ast.parse(path.read_text()))


def is_constant(node: ast.AST) -> bool:
    """Whether it is a number, or the name of one."""
    named = isinstance(node, ast.Name) and node.id.isupper()
    return named or (isinstance(node, ast.Constant) and isinstance(node.value, int | float))


def counts(node: ast.AST) -> bool:
    """Whether it counts rows or names, of which a page shows the first few."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "len"


@pytest.mark.parametrize("path", VIEWS, ids=lambda path: path.stem)
def test_no_view_compares_a_number_with_a_limit(path: Path) -> None:
    for node in nodes(path):
        if isinstance(node, ast.Compare) and any(isinstance(op, ORDERS) for op in node.ops):
            sides = [node.left, *node.comparators]
            assert counts(node.left) or not any(map(is_constant, sides)), ast.unparse(node)


@pytest.mark.parametrize("path", VIEWS, ids=lambda path: path.stem)
def test_no_view_computes_a_statistic(path: Path) -> None:
    for node in nodes(path):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [getattr(node, "module", None) or "", *(own.name for own in node.names)]
            assert not OF_TABLES & {name.split(".")[0] for name in names}, ast.unparse(node)
            assert "ur5lib.judging" not in names[0], ast.unparse(node)
            assert not names[0].endswith("limits"), ast.unparse(node)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            assert node.func.attr not in STATISTICS, ast.unparse(node)


def test_views_are_small() -> None:
    assert sum(len(path.read_text().splitlines()) for path in VIEWS) <= MAX_LINES
