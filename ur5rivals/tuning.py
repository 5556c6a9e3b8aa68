"""One rule for the constants of all rivals, from the contact-free fit recordings only.

Of the candidates with a latency of at most 50 ms, the one with the least false force is taken: the
median of |F| without contact. (Near a singularity, |F| without a prior is unbounded, and a mean
would depend only on those postures.) An estimate that uses later samples has no latency.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import cache
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Learned, Method
from ur5rivals.force import TorqueEstimate, force, learned_noise
from ur5rivals.run import Run

MAX_LATENCY = 0.05  # s; of a causal estimate
STEP_SHARE = 1 - np.exp(-1)  # latency is the time to reach this share of a step
PUSH_FORCE = 15.0  # N; usual push by hand
SPAN_BEFORE, SPAN_AFTER = 3.0, 1.0  # s around the start of a trial push
PUSH_PLACES = (0.25, 0.5, 0.75)  # trial pushes start at these shares of the longest run


class Candidate(Protocol):
    """An estimate of the external torque: a dataclass of its constants."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm] of a run, NaN where unknown."""


SomeCandidate = TypeVar("SomeCandidate", bound=Candidate)


def tuned(candidates: Iterable[Candidate], runs: Sequence[Run]) -> Learned:
    """Return the least-squares force of the candidate with the least false force among those with
    a latency of at most MAX_LATENCY; raises as `least_false`.
    """
    return least_false(candidates, runs, lambda candidate: fitted(candidate.torque, runs))


def least_false(
    candidates: Iterable[SomeCandidate],
    runs: Sequence[Run],
    method_of: Callable[[SomeCandidate], Method],
) -> Learned:
    """Return the method of the candidate with the least false force among those with a latency of
    at most MAX_LATENCY [s].

    method_of: function that returns a candidate's method. Raises InputError if no candidate is fast
    enough.
    """
    delays = [(latency(candidate.torque, runs), candidate) for candidate in candidates]
    prompt = [
        (method_of(candidate), delay, candidate)
        for delay, candidate in delays
        if delay <= MAX_LATENCY + 1e-9
    ]
    if not prompt:
        raise InputError(
            f"no candidate has a latency of at most {1000 * MAX_LATENCY:.0f} ms; add others"
        )
    best, delay, chosen = min(prompt, key=lambda trial: false_force(trial[0], runs))
    return Learned(best, asdict(chosen), delay)


def untuned(torque: TorqueEstimate, runs: Sequence[Run], latency: float | None = None) -> Learned:
    """Return the least-squares force of a torque estimate that has no constants to tune, with its
    noise on the runs; latency: of the estimate [s], None if not measured.
    """
    return Learned(fitted(torque, runs), {}, latency)


def fitted(torque: TorqueEstimate, runs: Sequence[Run]) -> Method:
    """Return the least-squares force of a torque estimate, with its noise on contact-free runs."""
    cached_torque = cache(torque)  # noise and false force need the same runs
    noise = learned_noise(cached_torque, runs)
    return lambda run: force(run, cached_torque(run), noise)


def false_force(method: Method, runs: Sequence[Run]) -> float:
    """Return the median of |F| [N] on contact-free runs, infinite where there is no estimate."""
    wrenches = [estimate.wrench for run in runs if (estimate := method(run)) is not None]
    sizes = [np.linalg.norm(wrench[:, :3], axis=1) for wrench in wrenches]
    return float(np.nanmedian(np.concatenate(sizes))) if sizes else np.inf


def latency(torque: TorqueEstimate, runs: Sequence[Run]) -> float:
    """Return the time [s] in which the estimate reaches 63 % of a push that starts within a sample.

    Median over three places of the longest run and three directions; infinite if most pushes never
    reach it.
    """
    run = max(runs, key=lambda candidate: len(candidate.q))
    starts = [round(place * len(run.q)) for place in PUSH_PLACES]
    return float(np.median([delay for at in starts for delay in _delays(torque, run, at)]))


def _delays(torque: TorqueEstimate, run: Run, start: int) -> Iterator[float]:
    """Yield the latency [s] for a push along each axis of the base."""
    before, after = (round(seconds / run.period) for seconds in (SPAN_BEFORE, SPAN_AFTER))
    start_of_part = max(0, start - before)
    part = run.part(slice(start_of_part, start + after))
    untouched = torque(part)
    for axis in range(3):
        push = PUSH_FORCE * part.jacobian[:, axis]  # Jᵀ F (n, 6)
        push[: start - start_of_part] = 0.0
        change = torque(part.pushed(push)) - untouched
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (change * push).sum(axis=1) / (push**2).sum(axis=1)
        reached = np.flatnonzero(share[start - start_of_part :] >= STEP_SHARE)
        # + 1: the first sample of the push counts as one period
        yield (reached[0] + 1) * run.period if len(reached) else np.inf
