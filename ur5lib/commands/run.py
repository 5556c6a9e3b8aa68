"""`ur5 run`: Snakemake builds a study; prints the progress and what went wrong."""

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.progress import Progress

if TYPE_CHECKING:
    from ur5lib.commands.verdicts import CardState

from ur5lib.commands.console import text_console
from ur5lib.commands.interrupts import signals_interrupt
from ur5lib.commands.listed import written
from ur5lib.errors import InputError, expect_text, printable
from ur5lib.finished import FinishedStudy
from ur5lib.jobs.unreadable import unreadable
from ur5lib.study.address import results_folder, study_file
from ur5lib.study.reading import read_study
from ur5lib.study.turn import running
from ur5lib.workspace.origin import foreign
from ur5lib.workspace.places import SNAKEFILE, WORKFLOW

PROGRESS = re.compile(r"(\d+) of (\d+) steps \(\d+%\) done")
STEPS_TO_RUN = re.compile(r"^total +(\d+)$", re.MULTILINE)
CODE = r"'[0-9a-f]{16}'"  # a checksum among a step's params
WHY = {  # reasons of Snakemake to run a step, but for those that follow from another step's
    r"Missing output": "results are missing",
    r"Incomplete output": "a step was stopped",
    r"Updated input": "files have changed",
    rf"Params have .*{CODE}": "the code has changed",
    rf"(?:Set of input|Params) (?!.*{CODE})": "the study has changed",
}
# Lines that Snakemake prints in every run.
USUAL = re.compile(
    r"$|\[|Using |Assuming |Building DAG|Provided |Rules claiming|Select jobs|Execute \d"
    r"|WorkflowError in file|the study has errors$|  File \".*\", line \d+, in <module>"
    r"|Job stats|job +count|-+ +-+|\w+ +\d+$|Finished jobid|Complete log|Elapsed time|report: "
)
SECONDS_BETWEEN_LINES = 60.0
Report = Callable[[int, int], None]  # takes the numbers of finished and of all steps


def run(study: str | Path, *, quiet: bool = False) -> FinishedStudy:
    """Build a study as `ur5 run` does, what is new or has changed, and return its results.

    study: its name, as `mine`, or its YAML file; quiet: show no progress. Raises InputError where
    the study is wrong, or a step fails.

        >>> ur5lib.run("mine.yaml").recordings
        ['pushed']
    """
    file = study_file(expect_text(study, "study"))
    results = results_folder(str(file))
    build(file, results, [], verbose=False, quiet=quiet)
    return FinishedStudy(results)


def build(
    study: Path, results: Path, options: Sequence[str], verbose: bool, quiet: bool = False
) -> Path | None:
    """Build a study and return its report; print progress and unusual lines on stderr.

    options: of Snakemake; verbose: print all of its lines; quiet: no progress. A dry run prints all
    lines and returns None. Raises InputError if the run fails.
    """
    read_study(study)
    dry = _is_dry(options)
    with nullcontext(_untold) if quiet or dry else _progress() as report:
        status = _watch(_command(study, options), report, verbose or dry)
    if status:
        again = "" if verbose else "; `--verbose` shows every line of Snakemake's"
        raise InputError(f"{study} is not built (see above){again}")
    built = results / "report.html"
    return built if built.is_file() and not dry else None


def _is_dry(options: Sequence[str]) -> bool:
    """Return whether Snakemake's options ask for a dry run."""
    return any(re.fullmatch(r"--dry-?run|-[a-zA-Z]*n", option) for option in options)


@dataclass(frozen=True)
class State:
    """The state of a study's results.

    report: its file, None without one; unreadable: reasons by recording; steps_to_run: number of
    steps in a new run, None while another run is active, and why; verdicts: states of cards, None
    without any.
    """

    study: str
    being_made_by: str | None
    report: str | None
    written: str | None
    unreadable: dict[str, str]
    steps_to_run: int | None
    why: list[str]
    verdicts: "list[CardState] | None"

    def lines(self) -> Iterator[str]:
        """Yield the state line by line."""
        from ur5lib.commands.verdicts import lines

        if self.being_made_by:
            yield f"being made by {self.being_made_by}"
        if self.report:
            yield f"report: {self.report}, written {self.written}"
        else:
            yield "no report yet"
        if self.report or self.verdicts:
            yield from lines(self.verdicts, self.study)
        for name, reason in self.unreadable.items():
            yield f"{name} cannot be read: {printable(reason)}"
        if self.steps_to_run:
            why = f", as {' and '.join(self.why)}" if self.why else ""
            yield f"{self.steps_to_run} steps to run{why}; next: ur5 run {self.study}"
        elif self.steps_to_run == 0:
            yield "nothing to be done"
        if warning := foreign():
            yield warning


def state(study: Path, results: Path) -> State:
    """Return the state of a study's results. Raises InputError if the study has mistakes."""
    from ur5lib.commands.verdicts import card_states  # slow to import

    read_study(study)
    report, holder = results / "report.html", running(results)
    steps, why = (None, []) if holder else _steps_to_run(study)
    return State(
        str(study),
        holder or None,
        str(report) if report.is_file() else None,
        written(report),
        unreadable(results) if results.is_dir() else {},
        steps,
        why,
        card_states(results),
    )


def _steps_to_run(study: Path) -> tuple[int, list[str]]:
    """Return the number of steps in a new run, and why they would run.

    Raises InputError if the study has mistakes.
    """
    dry = subprocess.run(
        _command(study, ["--dry-run", "--quiet", "host"]),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
    )  # fmt: skip
    if dry.returncode:
        lines = [line for line in dry.stdout.splitlines() if not USUAL.match(line)]
        raise InputError("\n".join(lines))
    count = STEPS_TO_RUN.search(dry.stdout)
    told = "\n".join(re.findall(r"^ +reason: (.*)", dry.stdout, re.MULTILINE))
    why = [words for pattern, words in WHY.items() if re.search(pattern, told)]
    return int(count[1]) if count else 0, why


def _command(study: Path, options: Sequence[str]) -> list[str]:
    """Return Snakemake's command line for a study, in a workspace or in any other folder."""
    here = Path("Snakefile").is_file()
    place = [] if here else ["--snakefile", str(SNAKEFILE)]
    if not here and not any(option.startswith("--workflow-profile") for option in options):
        place += ["--workflow-profile", str(WORKFLOW / "profiles" / "default")]
    # -P: modules in the working folder must not replace Snakemake's
    program = [sys.executable, "-P", "-m", "snakemake"]
    return [*program, *place, "--configfile", str(study), *options]


def _watch(command: Sequence[str], report: Report, verbose: bool) -> int:
    """Run a command, print its unusual lines (with verbose, all), report its progress, and return
    its exit status.
    """
    with (
        signals_interrupt(),
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        ) as process,
    ):
        assert process.stdout is not None
        try:
            for line in process.stdout:
                if steps := PROGRESS.match(line):
                    report(int(steps[1]), int(steps[2]))
                if verbose or not (steps or USUAL.match(line)):
                    print(printable(line), end="", file=sys.stderr, flush=True)
        except KeyboardInterrupt as stop:
            if stop.args:  # a signal to this process alone; Ctrl-C has reached both
                process.terminate()
            process.communicate()  # it removes incomplete files
            raise
    return process.returncode


@contextmanager
def _progress() -> Iterator[Report]:
    """Yield a `Report`, a function that shows progress: a bar on a terminal, a line a minute in a
    file.
    """
    if not sys.stderr.isatty():
        yield _a_line_a_minute()
        return
    with Progress(console=text_console(stderr=True), transient=True) as progress:
        bar = progress.add_task("steps", total=None)
        yield lambda done, total: progress.update(bar, completed=done, total=total)


def _untold(done: int, total: int) -> None:
    """Do nothing with the progress: the `Report` of a quiet run."""


def _a_line_a_minute() -> Report:
    """Return a `Report` that prints the number of finished steps at most once a minute."""
    printed = time.monotonic()

    def report(done: int, total: int) -> None:
        nonlocal printed
        if time.monotonic() - printed > SECONDS_BETWEEN_LINES:
            printed = time.monotonic()
            print(f"{done} of {total} steps are done", file=sys.stderr, flush=True)

    return report
