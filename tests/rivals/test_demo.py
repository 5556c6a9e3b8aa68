"""Estimators compared on the default study, by the command, the benchmarks and the package."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchmarks.harness.markdown import read_page
from benchmarks.leaderboard import QUICK
from tests.conftest import PROJECT, Workflow
from tests.house.test_benchmarks import run_benchmark
from tests.workflow.test_lab import Installed, installed, wheel  # noqa: F401 (fixtures)
from ur5lib.cli import app
from ur5lib.tables import read_csv
from ur5rivals import board
from ur5rivals.estimators import all_estimators


def test_an_estimator_from_outside_is_compared_beside_the_page(demo: Workflow) -> None:
    """That of the page's example: in table and page copy; the page itself stays as it is."""
    page = PROJECT / "docs" / "benchmark.md"
    before = page.read_text()
    example = (PROJECT / "docs" / "outside.md").read_text().split("```python\n")[1].split("```")[0]
    (demo.folder / "moving_average.py").write_text(example)
    chosen = ("--estimator", "moving_average:MovingAverage")
    printed = run_benchmark("leaderboard", demo.folder, "demo", "--page", *chosen)
    beside = read_page(demo.folder / "results" / "benchmark.md")
    for name in ("momentum observer", "moving average"):
        assert f"| {name} | yes |" in printed
        assert f"| {name} | yes |" in beside
    table = read_csv(demo.folder / "results" / "leaderboard.csv")
    counts = table.groupby("estimator").size()
    assert counts["moving average"] == counts["least squares"]
    assert page.read_text() == before


def test_the_command_compares_estimators(demo: Workflow, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all that are published, a few; the installed package compares all of them."""
    few = [own for own in all_estimators() if own.name in QUICK]
    monkeypatch.setattr(board, "all_estimators", lambda: few)
    monkeypatch.chdir(demo.folder)
    done = CliRunner().invoke(app, ["leaderboard", "results/demo"], catch_exceptions=False)
    assert "| momentum observer | yes |" in done.output


@pytest.mark.thorough
def test_the_live_estimate_is_measured(demo: Workflow) -> None:
    printed = run_benchmark("live", demo.folder)
    for text in ("NumPy, a step: median", "alarms a minute", "are left after its release"):
        assert text in printed


@pytest.mark.thorough
def test_the_installed_package_compares_all(
    demo: Workflow,
    installed: Installed,  # noqa: F811
    tmp_path: Path,
) -> None:
    results = demo.folder / "results" / "demo"
    told = installed.run("ur5", "leaderboard", str(results), folder=tmp_path)
    assert "| momentum observer | yes |" in told
    assert all(f"| {own.name} |" in told for own in all_estimators() if own.source == "ours")
