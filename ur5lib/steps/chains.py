"""The steps of several recordings, one after the other in one process.

What a process has loaded, parsed or compiled for one recording serves all others: of recordings of
seconds, that takes longer than the computation.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import dropwhile

from ur5lib.steps.job import Job, StepError
from ur5lib.steps.upkeep import delete_parts, is_current, run_if_changed, written_by


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

    def pending(self) -> Iterator[Job]:
        """Yield the jobs of each recording from the first on that must run."""
        for chain in self.jobs.values():
            yield from dropwhile(is_current, chain)

    def steps(self) -> set[str]:
        """Return the steps that have to run, or may have to."""
        return {job.step for job in self.pending()}

    def next(self) -> Job:
        """Return the job that has to run next; the last one if none has to."""
        *_, last = (job for chain in self.jobs.values() for job in chain)
        return next(self.pending(), last)

    def run(self, start_up: float = 0.0) -> dict[str, End]:
        """Run the steps in this process; return how those of each recording ended.

        start_up: as of `Job.run`, for the first that runs.
        """
        once = [start_up]
        return {name: end_of(chain, once) for name, chain in self.jobs.items()}


def end_of(chain: list[Job], start_up: list[float]) -> End:
    """Run the steps of a recording until one fails."""
    end = End()

    def run(job: Job) -> None:
        delete_parts(job)
        if error := job.run(start_up.pop() if start_up else 0.0):
            end.error = error
            raise StepError

    for job in chain:
        try:
            if run_if_changed(job, run):
                end.ran.append(job.step)
        except StepError:
            break
        end.written += written_by(job)
    return end
