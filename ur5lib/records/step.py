"""What a step declares in addition to its signature."""

from collections.abc import Callable
from typing import Any, Literal, TypeVar

Step = TypeVar("Step", bound=Callable[..., Any])


def step(
    of: Literal["recording", "posture", "arm"],
    writes: str,
    recordings: Literal["", "fit", "contact_free", "drawn", "examined", "illustrated"] = "",
    **given: str,
) -> Callable[[Step], Step]:
    """Declare the function of a step, of which its rule and its call in memory are made.

    Each parameter, and each field of an `Opened`, receives what has its name: an output of another
    step, or a setting of `ur5lib.study.given`.

    of: what one job is for; writes: its outputs, each a file `name.ending` or `output=name.ending`;
    recordings: for a step of a recording, those that it runs for; for a step of an arm, those that
    it reads; "" for all; given: the name of what a parameter or a field receives, where it has
    another one. A parameter `Mapping[str, ...]` has a value for each recording that a step of an
    arm reads; in a step of a recording, for each of its arm's `fit` recordings.

    `ur5lib.jobs.declared` reads it in the source: a plan of jobs imports no step.
    """
    return lambda function: function
