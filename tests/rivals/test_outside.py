"""An estimator from outside: it is given what the rivals are given, and refused by a sentence."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.rivals.synthetic_run import COUNT, synthetic_run
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Learned
from ur5rivals.outside import ProtocolError, check, outside
from ur5rivals.run import Estimate, Run
from ur5rivals.tuning import fitted, untuned

ATTRIBUTES = {"name": "mine", "source": "my thesis", "causal": False}
HERE = f"{__name__}:Mine"


def runs() -> list[Run]:
    """Two paths without contact, with a sensor and an estimate that no rival may see."""
    zero = np.zeros((COUNT, 6))
    free = [synthetic_run(seed, noise=0.3) for seed in (1, 2)]
    return [replace(run, sensor=zero, ready={"Fmap": Estimate(zero)}) for run in free]


def stated(torque: Callable[[Run], Any]) -> Callable[..., Learned]:
    """Return how to learn nothing and to estimate by least squares."""
    return lambda _, own: untuned(torque, own)


def by_method(method: Callable[[Run], Any]) -> Callable[..., Learned]:
    return lambda *_: Learned(method, {})


def here(monkeypatch: pytest.MonkeyPatch, learn: object, /, **changed: object) -> None:
    """Put a class of an estimator into this module."""
    own = type("Mine", (), {**ATTRIBUTES, "learn": learn} | changed)
    monkeypatch.setattr(sys.modules[__name__], "Mine", own, raising=False)


def test_it_gets_what_the_rivals_get_and_cannot_change_it(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Run] = []

    def learn(_: object, given: Sequence[Run]) -> Learned:
        seen.extend(given)
        learned = untuned(lambda run: run.smoothed, given)
        for run in given:
            run.torque[:] = 0.0
        return learned

    here(monkeypatch, learn)
    own, estimator = runs(), outside(HERE, [])
    found = estimator.learn(own).method(own[0])
    expected = fitted(lambda run: run.smoothed, own)(own[0])
    assert found is not None
    assert expected is not None
    assert np.array_equal(found.wrench, expected.wrench)
    assert [(run.sensor, run.ready) for run in seen] == [(None, {})] * 2
    assert own[0].torque.any()


@pytest.mark.parametrize(
    ("place", "fault"),
    [
        ("mine", "is not of the form package.module:Class"),
        (":Mine", "is not of the form package.module:Class"),
        ("no_such_module:Mine", "cannot be imported .ModuleNotFoundError"),
        ("ur5rivals.run:Ruin", "did you mean `Run`"),
        ("ur5rivals.run:Run", "cannot be made without arguments"),
        ("tests.rivals.test_outside:ATTRIBUTES", "needs `name`, a str"),
    ],
)
def test_what_is_no_estimator_is_refused(place: str, fault: str) -> None:
    with pytest.raises(ProtocolError, match=fault) as refused:
        outside(place, [])
    assert "\n" not in str(refused.value)


def test_a_module_that_is_broken_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken_estimator.py").write_text("def learn(:\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ProtocolError, match="SyntaxError") as refused:
        outside("broken_estimator:Mine", [])
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"name": None}, "needs `name`"),
        ({"name": "a | b"}, "empty, or holds"),
        ({"source": " "}, "empty, or holds"),
        ({"causal": "yes"}, "needs `causal`, a bool"),
        ({"learn": None}, "needs a method"),
        ({"name": "least squares"}, "like an estimator of the benchmark"),
    ],
)
def test_a_class_without_the_protocol_is_refused(
    changed: dict[str, Any], fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here(monkeypatch, stated(lambda run: run.smoothed), **changed)
    with pytest.raises(ProtocolError, match=fault):
        outside(HERE, ["least squares"])


def with_gap(run: Run) -> Estimate:
    """A force of zero, but for one sample."""
    wrench = np.zeros_like(run.q)
    wrench[200] = np.nan
    return Estimate(wrench)


def late(run: Run, samples: int) -> Array:
    """The external torque (N, 6), some samples later, or earlier if negative."""
    before, after = max(0, samples), max(0, -samples)
    return np.pad(run.torque, ((before, after), (0, 0)))[after : after + len(run.q)]


@pytest.mark.parametrize(
    ("learn", "changed", "fault"),
    [
        (lambda *_: None, {}, "returns NoneType instead of Learned"),
        (by_method(lambda run: run.q), {}, "returns ndarray on run_1 instead of Estimate"),
        (by_method(lambda run: Estimate(run.q[:, :3])), {}, r"wrench of shape \(2500, 3\)"),
        (by_method(lambda run: Estimate(run.q, run.q[0])), {}, r"std of shape \(6,\)"),
        (by_method(with_gap), {}, "no finite wrench in 1 samples of run_1 .* 1.600 s after"),
        (by_method(lambda run: Estimate(run.q / 0.0)), {}, "no finite wrench in 2500 samples"),
        (by_method(lambda run: Estimate(run.q, 0 * run.q)), {}, "std of zero or less"),
        (stated(lambda run: late(run, -10)), {"causal": True}, "later samples of run_1 change it"),
        (by_method(lambda run: Estimate(0 * run.q)), {"causal": True}, "63 % of a push never"),
        (stated(lambda run: late(run, 10)), {"causal": True}, "63 % of a push after 88 ms"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_estimates_that_break_the_protocol_are_refused(
    learn: Callable[..., Any],
    changed: dict[str, Any],
    fault: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    here(monkeypatch, learn, **changed)
    with pytest.raises(ProtocolError, match=fault) as refused:
        outside(HERE, []).learn(runs())
    assert "\n" not in str(refused.value)


def test_an_estimator_may_lack_an_input(monkeypatch: pytest.MonkeyPatch) -> None:
    here(monkeypatch, by_method(lambda _: None), causal=True)
    assert outside(HERE, []).learn(runs()).method(runs()[0]) is None


def test_unknown_inputs_allow_unknown_forces() -> None:
    run = synthetic_run()
    run.jacobian[100:110, 0, 3] = np.nan
    unknown = np.where(run.complete()[:, None], 0.0, np.full((COUNT, 6), np.nan))
    assert np.isnan(unknown[:, 0]).sum() == 10
    check(Estimate(unknown), run, "mine")


def test_a_package_names_it_by_an_entry_point(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    here(monkeypatch, stated(lambda run: run.smoothed))
    information = tmp_path / "mylab-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: mylab\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(f"[ur5rivals.estimators]\nmy-own = {HERE}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert outside("my-own", []).name == ATTRIBUTES["name"]
