"""Several optimisers at once: their cost functions are evaluated together, as one stack."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock

import numpy as np

from ur5lib.timeseries.arrays import Array

Cost = Callable[[Array], float]


def minimise_together(
    minimise: Callable[[Cost], Array], costs: Callable[[Sequence[int], Array], Array], count: int
) -> Array:
    """Return what so many optimisers find (count, P), each of which has its own cost function.

    minimise: an optimiser, which takes a cost function of P parameters. costs: what is evaluated at
    once, from the numbers (k,) of the functions asked for and their parameters (k, P) to costs
    (k,).

    Each optimiser has a thread of its own. As soon as all that still run have asked for a cost,
    they get it: what an optimiser finds does not depend on the others' speed.
    """
    rounds = _Rounds(costs, count)
    with ThreadPoolExecutor(count) as threads:
        return np.stack([*threads.map(lambda one: rounds.take_part(minimise, one), range(count))])


class _Rounds:
    """The costs that optimisers have asked for, and how many of these still run."""

    def __init__(self, costs: Callable[[Sequence[int], Array], Array], count: int) -> None:
        self.costs, self.running, self.lock = costs, count, Lock()
        self.asked: dict[int, tuple[Array, Future[float]]] = {}

    def take_part(self, minimise: Callable[[Cost], Array], one: int) -> Array:
        """Return what one optimiser finds."""
        try:
            return minimise(lambda parameters: self._ask(one, parameters))
        finally:
            with self.lock:
                self.running -= 1
                self._answer()

    def _ask(self, one: int, parameters: Array) -> float:
        """Return a cost as soon as all others have asked for theirs."""
        answer: Future[float] = Future()
        with self.lock:
            self.asked[one] = parameters, answer
            self._answer()
        return answer.result()

    def _answer(self) -> None:
        """Evaluate the costs if all that run have asked."""
        if not self.asked or len(self.asked) < self.running:
            return
        ones = sorted(self.asked)
        parameters, answers = zip(*(self.asked.pop(one) for one in ones), strict=True)
        try:
            for answer, cost in zip(answers, self.costs(ones, np.stack(parameters)), strict=True):
                answer.set_result(float(cost))
        except Exception as error:  # each optimiser's own caller gets it
            for answer in answers:
                answer.set_exception(error)
