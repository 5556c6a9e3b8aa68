"""The steps of several recordings, one after the other in one process.

What a process has loaded, parsed or compiled for one recording serves all others: of recordings of
seconds, that takes longer than the computation.
"""

from dataclasses import dataclass, field
from itertools import chain

from ur5lib.steps.job import Job, StepError
from ur5lib.steps.upkeep import delete_parts, known, run_if_changed


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

    def next(self) -> Job:
        """Return the job that has to run next; the last one if none has to."""
        jobs = [*chain.from_iterable(self.jobs.values())]
        return next((job for job in jobs if known(job) is None), jobs[-1])

    def run(self) -> dict[str, End]:
        """Run the steps in this process; return how those of each recording ended."""
        return {name: end_of(jobs) for name, jobs in self.jobs.items()}


def end_of(jobs: list[Job]) -> End:
    """Run the steps of a recording that must run until one fails."""
    end = End()

    def run(job: Job) -> None:
        delete_parts(job)
        if error := job.run():
            end.error = error
            raise StepError

    for job in jobs:
        try:
            ran, written = run_if_changed(job, run)
        except StepError:
            break
        end.ran += [job.step] if ran else []
        end.written += written
    return end
