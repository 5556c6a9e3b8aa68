"""An estimator from outside this project: found by its name, under the same rule as all rivals.

It gets copies of the runs that all estimators get, without the force sensor and without the study's
own estimates. An estimator that breaks the protocol is refused with one sentence.
"""

import importlib
import sys
from collections.abc import Collection, Sequence
from copy import deepcopy
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ur5lib.errors import InputError, perhaps
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned, Method
from ur5rivals.run import Estimate, Run
from ur5rivals.tuning import MAX_LATENCY, latency

EXAMPLE_HINT = "docs/outside.md shows an example"
ENTRY_POINTS = "ur5rivals.estimators"  # group in which a package names its estimators
FIELD_TYPES = {"name": str, "source": str, "causal": bool}
MAX_CAUSAL_DIFFERENCE = 0.01  # N; between equal estimates of a sample


def outside(place: str, taken: Collection[str]) -> Contender:
    """Return the estimator at `package.module:Class`, in the working folder or installed.

    place: of a class without arguments, or of an object; or the entry point of an installed
    package; taken: names of the rivals. Raises ProtocolError with the missing part, also in the
    estimator's `learn`.
    """
    estimator = made(place)
    for field, kind in FIELD_TYPES.items():
        value = getattr(estimator, field, None)
        if not isinstance(value, kind):
            refuse(place, f"needs `{field}`, a {kind.__name__}; {EXAMPLE_HINT}")
        if isinstance(value, str) and (not value.strip() or set("|\r\n") & set(value)):
            refuse(place, f"has a `{field}` that is empty, or holds | or a line break; change it")
    if not callable(getattr(estimator, "learn", None)):
        refuse(place, f"needs a method `learn(runs)`; {EXAMPLE_HINT}")
    if estimator.name in taken:
        refuse(place, f"is called `{estimator.name}` like an estimator of the benchmark; rename it")
    return Contender(
        estimator.name,
        estimator.source,
        estimator.causal,
        lambda runs: learn(estimator, place, runs),
    )


class ProtocolError(InputError):
    """An estimator breaks the protocol or the rule of the benchmark."""


def refuse(place: str, fault: str) -> NoReturn:
    """Raise ProtocolError for an estimator; place: where it is from; fault: what is wrong, in
    words.
    """
    raise ProtocolError(f"{place} {fault}")


def made(place: str) -> Any:
    """Return the object at `package.module:Class`, constructed if it is a class."""
    points = entry_points(group=ENTRY_POINTS, name=place)
    module, _, name = next((point.value for point in points), place).partition(":")
    if not module or not name:
        refuse(place, f"is not of the form package.module:Class; {EXAMPLE_HINT}")
    if str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    try:
        imported = importlib.import_module(module)
    except Exception as error:  # whatever the module does
        why = f"{type(error).__name__}: {error}".splitlines()[0]
        refuse(place, f"cannot be imported ({why}); it has to lie here, or to be installed")
    if not hasattr(imported, name):
        refuse(place, f"is not there{perhaps(name, dir(imported))}; correct the name")
    named = getattr(imported, name)
    try:
        return named() if isinstance(named, type) else named
    except TypeError as error:
        refuse(place, f"cannot be made without arguments ({error})")


def learn(estimator: Any, place: str, runs: Sequence[Run]) -> Learned:
    """Return the estimator's learnt method, and its measured latency, None if it is not causal.

    Raises ProtocolError if its estimates on the same runs break the protocol or the rule.
    """
    learned = estimator.learn([without_answers(run) for run in runs])
    if not isinstance(learned, Learned):
        kind = type(learned).__name__
        refuse(place, f"has a `learn` that returns {kind} instead of Learned; {EXAMPLE_HINT}")

    def method(run: Run) -> Estimate | None:
        estimate = learned.method(without_answers(run))
        check(estimate, run, place)
        return estimate

    estimated = [run for run in runs if method(run) is not None]
    if not estimator.causal or not estimated:
        return Learned(method, learned.constants)
    longest = max(estimated, key=lambda run: len(run.q))
    check_causal(method, longest, place)
    delay = latency(lambda run: torque_of(method, run), [longest])
    if delay > MAX_LATENCY + 1e-9:
        late = "never" if np.isinf(delay) else f"after {1000 * delay:.0f} ms"
        refuse(
            place,
            f"shows 63 % of a push {late}; causal estimators have {1000 * MAX_LATENCY:.0f} ms",
        )
    return Learned(method, learned.constants, delay)


def without_answers(run: Run) -> Run:
    """Return a copy of a run with only the inputs that every rival may use: no sensor, no estimates
    of the study, no repeats.
    """
    return deepcopy(replace(run, sensor=None, ready={}, repeats=()))


def check(estimate: Any, run: Run, place: str) -> None:
    """Raise ProtocolError unless an estimate is None, or has values at all samples with complete
    inputs.
    """
    if estimate is None:
        return
    if not isinstance(estimate, Estimate):
        kind = type(estimate).__name__
        refuse(place, f"returns {kind} on {run.name} instead of Estimate or None; {EXAMPLE_HINT}")
    for what, values in estimate._asdict().items():
        if values is None and what == "std":
            continue
        if np.shape(values) != run.q.shape:
            size = np.shape(values)
            refuse(
                place, f"returns a {what} of shape {size} on {run.name} instead of {run.q.shape}"
            )
        unknown = run.complete() & ~np.isfinite(values[:, :3]).all(axis=1)
        if unknown.any():
            count, start = unknown.sum(), run.period * unknown.argmax()
            refuse(place, f"states no finite {what} in {count} samples of {run.name} whose inputs "
                   f"are known, the first {start:.3f} s after its start")  # fmt: skip
    if estimate.std is not None and (estimate.std[:, :3] <= 0).any():
        refuse(place, f"states a std of zero or less on {run.name}")


def check_causal(method: Method, run: Run, place: str) -> None:
    """Raise ProtocolError if the force in the first half of a run depends on the second half."""
    half = len(run.q) // 2
    alone, whole = method(run.part(slice(half))), method(run)
    assert alone is not None
    assert whole is not None
    if not np.allclose(
        alone.wrench[:, :3], whole.wrench[:half, :3], 0, MAX_CAUSAL_DIFFERENCE, equal_nan=True
    ):
        refuse(place, f"is called causal, but later samples of {run.name} change its estimate")


def torque_of(method: Method, run: Run) -> Array:
    """Return the torque J_vᵀ F (N, 6) [Nm] of an estimated force."""
    estimate = method(run)
    assert estimate is not None
    return np.einsum("nij,ni->nj", run.jacobian[:, :3], estimate.wrench[:, :3])
