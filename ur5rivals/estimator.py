"""The interface of an estimator in the benchmark."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ur5rivals.run import Estimate, Run

Method = Callable[[Run], Estimate | None]
"""Returns the wrench of a run, None where the run lacks what the method needs."""


class Learned(NamedTuple):
    """What an estimator has learnt: the method that estimates, its constants by name, and its
    latency [s], None if it was not measured.
    """

    method: Method
    constants: dict[str, Any]
    latency: float | None = None


@dataclass(frozen=True)
class Contender:
    """An estimator of the benchmark: the rows of the table with its name.

    source: the publication; causal: whether it uses only present and past samples; learn: function
    that returns the estimator with constants learnt from the contact-free runs of the role `fit`,
    predicted by fits without their own path; it may raise InputError if they do not suffice.
    """

    name: str
    source: str
    causal: bool
    learn: Callable[[Sequence[Run]], Learned]


def ready(name: str) -> Callable[[Sequence[Run]], Learned]:
    """Return the function `learn` of an estimate that the study already contains, which learns
    nothing.
    """
    return lambda _: Learned(lambda run: run.ready.get(name), {})
