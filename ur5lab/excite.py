"""`ur5 excite`: a trajectory designed for an arm, its surroundings and a question."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from pydantic import ValidationError
from rich.console import Console
from rich.progress import Progress

from ur5lab.collisions import Surroundings
from ur5lab.excitation.design import USUAL_EFFORT, Design, Effort, design
from ur5lab.excitation.figure import excitation_figure
from ur5lab.excitation.files import write_files
from ur5lab.excitation.objective import QUESTIONS, STATE_STEP, Task, Worth
from ur5lab.excitation.trajectory import WorkCell
from ur5lib import channels
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError, unknown
from ur5lib.excitation.outlook import (
    Bands,
    Earlier,
    Outlook,
    RecordedStates,
    feels_forces,
    problem_after,
)
from ur5lib.excitation.problem import DesignProblem, build_problem, nominal_maps
from ur5lib.finished import StudyFiles
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification
from ur5lib.records.motion import Motion
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import Payload, Robot, described
from ur5lib.strict import read_yaml

LOAD_ADVICE = "a known load on the flange (--payload) or a longer motion (--seconds) may"
SAFETY_ADVICE = (
    "Look at the sweep in excitation.svg, run stand.yaml, and go along the way-points slowly "
    "before the arm moves at full speed."
)
RECORD_COMMAND = "ur5 record STUDY NAME --move"
DRIVER_ADVICE = (
    "Let the arm's own driver move it along trajectory.csv, which has the time [s] and all joint "
    "angles [rad], and add the recording to a study (docs/robots.md)."
)
PROGRESS_CONSOLE = Console(stderr=True)
MAX_PRINTED_ERRORS = 6  # parameters with printed standard errors


@dataclass(frozen=True)
class ExciteOptions:
    """The options of `ur5 excite`; without a table, the arm may move below its base."""

    robot: str
    seconds: float
    question: str
    results: Path | None
    table: float | None
    boxes: Path | None
    seed: int
    payload: Payload | None = None


def excite(options: ExciteOptions, folder: Path, effort: Effort = USUAL_EFFORT) -> Iterator[str]:
    """Design a trajectory, write its files into a folder, and yield its predicted errors.

    Raises InputError for a wrong option, missing results, and limits that allow no motion.
    """
    if options.question not in QUESTIONS:
        raise unknown("--question", options.question, QUESTIONS)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--output {folder} is a file; name a folder")
    arm, earlier_study = earlier(options)
    designed = _design(task_of(options, arm, earlier_study), options.seed, effort)
    asked = {"robot": options.robot, "question": options.question, "seed": options.seed}
    write_files(folder, asked, options.payload, designed)
    save(excitation_figure(designed), folder / "excitation.svg")
    yield from designed.margins.lines()
    yield from _worth_lines(designed.task.problem, designed.worth)
    yield from _band_lines(outlook_of(arm, earlier_study, designed), arm.measured)
    if options.payload is not None:
        yield _mounting(options.payload, len(arm.joints))
    yield SAFETY_ADVICE
    command = f"{RECORD_COMMAND} {folder}/trajectory.csv --speed 1"
    yield f"{folder} written; next: {command if arm.is_ur() else DRIVER_ADVICE}"


def _design(task: Task, seed: int, effort: Effort) -> Design:
    """Return the designed trajectory; a progress bar shows the search."""
    with Progress(console=PROGRESS_CONSOLE, transient=True) as progress:
        line = progress.add_task("searching", total=effort.iterations())
        return design(task, seed, effort, lambda count: progress.advance(line, count))


def _mounting(load: Payload, last: int) -> str:
    """Return the sentence on how to mount a load before its motion is recorded; last: number of the
    frame at its flange.
    """
    x, y, z = load.center_of_mass
    return (
        f"Mount {load.mass:g} kg with its centre of mass at ({x:g}, {y:g}, {z:g}) m in frame "
        f"{last}; declare it to the controller and as the payload of the recording."
    )


def earlier(options: ExciteOptions) -> tuple[Robot, Earlier | None]:
    """Return the arm, as fitted by a study or else as described, and the study's recordings of it,
    None without a study.

    Raises InputError for an unknown arm, and if a file of the study is missing.
    """
    if options.results is None:
        return described(options.robot), None
    study = StudyFiles(options.results)
    arm = study.arm(options.robot)
    friction = study.parameters(Friction, arm.name, "friction")
    base = study.parameters(Identification, arm.name, "identification")
    return arm, Earlier(
        friction.fit,
        friction.parameters,
        base.noise,
        fitted=len(friction.from_),
        recordings=[_recorded(arm, study, n) for n in sorted({*friction.from_, *base.from_})],
    )


def task_of(options: ExciteOptions, arm: Robot, earlier_study: Earlier | None) -> Task:
    """Return the task of the design, from the options, the arm and what earlier recordings show of
    it.
    """
    cell = WorkCell.around(
        arm.carrying(options.payload), surroundings(options.table, options.boxes)
    )
    bare, seeks_load = LinkModel(arm, arm.fullest_model()), options.question == "payload"
    if earlier_study is None:
        problem = build_problem(arm, bare, nominal_maps(arm), seeks_load)
        information = problem.prior
    else:
        problem, information = problem_after(arm, earlier_study, seeks_load)
    problem = problem.of_model(cell.model.parameters)
    question = QUESTIONS[options.question](problem, cell)
    return Task(cell, problem, question, information, options.seconds)


def outlook_of(arm: Robot, earlier_study: Earlier | None, designed: Design) -> list[Bands]:
    """Return the present 95 % bands, and those after the designed motion and after others of the
    same length.

    Empty without a fit to earlier recordings, from which the bands come, and for an arm that does
    not feel all forces.
    """
    if earlier_study is None or not earlier_study.fit.joints or not feels_forces(arm):
        return []
    outlook, task = Outlook(arm, earlier_study), designed.task
    problem = outlook.problem.of_model(task.cell.model.parameters)
    information = problem.information(*task.regressor(designed.path), STATE_STEP)
    return outlook.ranked([("this motion", information), *outlook.candidates(task.seconds)])


def known_load(mass: float, *center: float) -> Payload:
    """Return a load on the flange; mass: [kg]; center: its centre of mass in frame 6 [m].

    Raises InputError for impossible values.
    """
    try:
        return Payload.model_validate({"mass": mass, "center_of_mass": center})
    except ValidationError as error:
        raise InputError(
            f"--payload {mass:g} {' '.join(f'{c:g}' for c in center)}: give a mass above zero [kg] "
            "and three coordinates [m]"
        ) from error


def surroundings(table: float | None, boxes: Path | None) -> Surroundings:
    """Return a table, by its height [m], and the boxes of a YAML file as obstacles; None for none.

    Raises InputError where they are wrong.
    """
    if table is not None and not math.isfinite(table):
        raise InputError(f"--table {table}: give its height in the base frame [m]")
    try:
        entries = [] if boxes is None else read_yaml(boxes)
        return Surroundings(table=table, boxes=entries)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"--boxes {boxes} cannot be read: {error}") from error
    except ValidationError as error:
        fault = error.errors()[0]
        where = ".".join(map(str, fault["loc"]))
        raise InputError(
            f"{boxes}: {where}: {fault['msg']}; list boxes as {{center: [x, y, z], "
            "size: [x, y, z]}} in metres, base frame"
        ) from error


def _worth_lines(problem: DesignProblem, worth: Worth) -> Iterator[str]:
    """Yield lines of text: the information (log det) with a trajectory and its gain, condition
    numbers, and the standard errors of the parameters known worst, before it and after.
    """
    whole = f", of the whole problem {worth.condition:.0f}" if np.isfinite(worth.condition) else ""
    yield (
        f"log det of the information: {worth.log_det:.1f}, {worth.gain:.1f} more than before; "
        f"condition number of the regressor {worth.regressor_condition:.0f}{whole}"
    )
    yield "least determined so far, predicted standard errors before and after:"
    names, units = problem.names(), problem.units()
    for k in worth.least_determined()[:MAX_PRINTED_ERRORS]:
        yield f"  {names[k]:<34} {worth.before[k]:>9.2g} {worth.after[k]:>9.2g} {units[k]}"
    worst = worth.least_determined()[0]
    if worth.hardly_lowered()[worst]:
        yield f"this motion would hardly lower the first of these errors: {LOAD_ADVICE}"


def _band_lines(outlook: Sequence[Bands], effort: channels.Effort) -> Iterator[str]:
    """Yield lines of text on the bands of a force, an effort and a load, before and after
    recordings.
    """
    if outlook:
        kinds = f"a force in contact, a {effort.quantity} and a load"
        yield f"half of the 95 % bands of {kinds}, on average:"
    for row in outlook:
        current = f"{row.current:>7.4f} {effort.unit}"
        yield f"  {row.after:<46}{row.force:>7.2f} N {current} {row.mass:>6.3f} kg"


def _recorded(arm: Robot, study: StudyFiles, name: str) -> RecordedStates:
    """Return the states of a study's recording along its motion."""
    gravity = study.recording(name).known_gravity()
    motion = study.record(Motion, name)
    robot = arm.carrying(study.payload(name)).mounted(gravity)
    return RecordedStates.along(robot, motion.time, motion.q, motion.qd, motion.qdd)
