"""The steps of several recordings, one after the other in one process.

What a process has loaded, parsed or compiled for one recording serves all others: of recordings of
seconds, that takes longer than the computation.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain

from ur5lib.steps.job import Job, StepError
from ur5lib.steps.upkeep import delete_parts, known, run_if_changed, written_by


@dataclass
class End:
    """How the steps of a recording ended.

    ran: those that ran; written: checksums of what each wrote; error: of the one that failed, one
    sentence, empty if none did.
    """

    ran: list[str] = field(default_factory=list)
    written: list[str] = field(default_factory=list)
    error: str = ""


@dataclass
class Chains:
    """Recordings, each with its jobs in their order, of which those run that are not current."""

    jobs: dict[str, list[Job]]

    @cached_property
    def current(self) -> dict[str, list[list[str]]]:
        """What each job of a recording wrote, until the first that must run: checksums.

        Looked up once: of thousands of recordings, that is most of the work.
        """
        return {name: [*current_of(jobs)] for name, jobs in self.jobs.items()}

    def pending(self) -> Iterator[Job]:
        """Yield the jobs of each recording from the first on that must run."""
        for name, jobs in self.jobs.items():
            yield from jobs[len(self.current[name]) :]

    def steps(self) -> set[str]:
        """Return the steps that have to run, or may have to."""
        return {job.step for job in self.pending()}

    def next(self) -> Job:
        """Return the job that has to run next; the last one if none has to."""
        *_, last = chain.from_iterable(self.jobs.values())
        return next(Chains(self.jobs).pending(), last)  # looked up anew

    def run(self, start_up: float = 0.0) -> dict[str, End]:
        """Run the steps in this process; return how those of each recording ended.

        start_up: as of `Job.run`, for the first that runs.
        """
        once, ends = [start_up], {}
        for name, jobs in self.jobs.items():
            current = self.current[name]
            ends[name] = end_of(jobs[len(current) :], [*chain.from_iterable(current)], once)
        return ends


def current_of(jobs: list[Job]) -> Iterator[list[str]]:
    """Yield what each job of a recording wrote, until the first that must run."""
    for job in jobs:
        if (written := known(job)) is None:
            return
        yield written


def end_of(jobs: list[Job], written: list[str], start_up: list[float]) -> End:
    """Run the steps of a recording that must run until one fails.

    written: checksums of what those before them wrote.
    """
    end = End(written=written)

    def run(job: Job) -> None:
        delete_parts(job)
        if error := job.run(start_up.pop() if start_up else 0.0):
            end.error = error
            raise StepError

    for job in jobs:
        try:
            if run_if_changed(job, run):
                end.ran.append(job.step)
        except StepError:
            break
        end.written += written_by(job)
    return end
