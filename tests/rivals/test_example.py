"""The example of docs/outside.md: an estimator from outside."""

import tomllib
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from tests.examples import examples
from tests.rivals.synthetic_run import synthetic_run
from ur5rivals.outside import ENTRY_POINTS, outside

EXAMPLES = examples(PROJECT / "docs" / "outside.md")


def test_its_entry_point_is_of_the_group_that_is_taken_up() -> None:
    [points] = [tomllib.loads(example.text) for example in EXAMPLES if example.kind == "toml"]
    assert [*points["project"]["entry-points"]] == [ENTRY_POINTS]


def test_it_learns_on_a_constant_torque_without_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a file of its own."""
    [code] = [example.text for example in EXAMPLES if example.kind == "python"]
    assert len(code.splitlines()) <= 25
    (tmp_path / "moving_average.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    learned = outside("moving_average:MovingAverage", []).learn(
        [synthetic_run(seed, noise=0.1) for seed in (1, 2)]
    )
    assert learned.latency is not None
    assert 0 < learned.latency <= 0.05
