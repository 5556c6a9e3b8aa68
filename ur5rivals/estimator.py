"""The interface of an estimator in the benchmark."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ur5rivals.run import Estimate, Run

Method = Callable[[Run], Estimate | None]
"""Returns the wrench of a run, None where the run lacks what the method needs."""


class Learned(NamedTuple):
    """A method with its constants filled in, and its latency [s], None if it was not measured."""

    method: Method
    constants: dict[str, Any]
    latency: float | None = None


@dataclass(frozen=True)
class Contender:
    """One row of the table.

    source: the publication; causal: whether no later sample of its inputs is used; learn: takes the
    contact-free runs of the role `fit`, predicted by fits without their own path, and nothing else.
    It may raise InputError if they do not suffice.
    """

    name: str
    source: str
    causal: bool
    learn: Callable[[Sequence[Run]], Learned]


def ready(name: str) -> Callable[[Sequence[Run]], Learned]:
    """Return how to learn an estimate that the study already has: there is nothing to learn."""
    return lambda _: Learned(lambda run: run.ready.get(name), {})
