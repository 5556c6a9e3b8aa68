"""`ur5 excite`: a trajectory designed for an arm, its surroundings and a question."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from pydantic import ValidationError
from rich.console import Console
from rich.progress import Progress

from ur5lib.commands.exported import described
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.excitation.design import USUAL, Design, Effort, design
from ur5lib.excitation.files import summary_of, write_files
from ur5lib.excitation.objective import Task, Worth
from ur5lib.excitation.problem import Maps, Noise, Problem, build_problem, nominal_maps
from ur5lib.excitation.questions import QUESTIONS
from ur5lib.excitation.trajectory import Cell
from ur5lib.finished import FinishedStudy
from ur5lib.identification.currents import JointFit
from ur5lib.identification.population import population_of
from ur5lib.identification.samples import STEP as INDEPENDENT
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.models import Identification
from ur5lib.pipeline.records.motion import Motion
from ur5lib.report.excitation import LOAD, excitation_figure, excitation_page
from ur5lib.report.house_style import save
from ur5lib.report.render import write_html
from ur5lib.robots.collisions import Surroundings
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.population import population_files
from ur5lib.strict import read_yaml
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

BEFORE = (
    "Look at the sweep, run stand.yaml, and go along the way-points slowly before the arm moves "
    "at full speed."
)
SHOWN = Console(stderr=True)
MAX_PRINTED = 6  # parameters whose standard errors are printed
KEPT = ("torque_constant", "offset", "coulomb", "viscous", "load")  # of a fit's coefficients
ROUNDS = 4  # iterations, after which predicted standard errors are within 3 % of the study's


@dataclass(frozen=True)
class ExciteOptions:
    """The options of `ur5 excite`; without a table, nothing below the base is avoided."""

    robot: str
    seconds: float
    question: str
    results: Path | None
    table: float | None
    boxes: Path | None
    seed: int
    payload: Payload | None = None


def excite(options: ExciteOptions, folder: Path, effort: Effort = USUAL) -> Iterator[str]:
    """Design a trajectory, write its files into a folder, and yield its predicted errors.

    Raises InputError for a wrong option, missing results, and limits that allow no motion.
    """
    if options.question not in QUESTIONS:
        raise InputError(f"--question {options.question!r}: give one of {', '.join(QUESTIONS)}")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--write {folder} is a file; name a folder")
    task = task_of(options)
    planned = _design(task, options.seed, effort)
    worth = Worth.along(task, planned.path)
    asked = {"robot": options.robot, "question": options.question, "seed": options.seed}
    summary = summary_of(options.robot, options.question, options.seed, task, planned, worth)
    drawing = excitation_figure(task.cell.robot, planned.path, planned.margins, task.problem, worth)
    write_files(folder, options.robot, options.payload, task, planned.path, summary)
    drawn = folder / "excitation.svg"
    save(drawing, drawn)
    command = f"ur5 record STUDY NAME --move {folder}/trajectory.csv --speed 1"
    before = [] if options.payload is None else [_mounting(options.payload)]
    page = excitation_page(asked, [*before, BEFORE], command, planned, task.problem, worth, drawn)
    write_html(page, folder / "excitation.html")
    yield from planned.margins.lines()
    yield from _worth_lines(task.problem, worth)
    yield from before
    yield f"{folder} written; next: {command}"


def _design(task: Task, seed: int, effort: Effort) -> Design:
    """Return the designed trajectory; a progress bar shows the search."""
    with Progress(console=SHOWN, transient=True) as progress:
        line = progress.add_task("searching", total=effort.iterations())
        return design(task, seed, effort, lambda count: progress.advance(line, count))


def _mounting(load: Payload) -> str:
    """Return how to mount a load before its motion is recorded."""
    x, y, z = load.center_of_mass
    return (
        f"Mount {load.mass:g} kg with its centre of mass at ({x:g}, {y:g}, {z:g}) m in frame 6; "
        "declare it to the controller and as the payload of the recording."
    )


def task_of(options: ExciteOptions) -> Task:
    """Return the task of the design: limits, problem, question, information so far, duration."""
    study = None if options.results is None else FinishedStudy(options.results)
    arm = described(options.robot) if study is None else study.arm(options.robot)
    cell = Cell.around(arm.carrying(options.payload), surroundings(options.table, options.boxes))
    bare, seeks_load = LinkModel(arm, arm.fullest_model()), options.question == "payload"
    if study is None:
        problem = build_problem(arm, bare, nominal_maps(arm), seeks_load)
        earlier = problem.prior
    else:
        problem, earlier = problem_after(arm, bare, study, seeks_load)
    problem = problem.of_model(cell.model.parameters)
    return Task(
        cell, problem, QUESTIONS[options.question](problem, cell.model), earlier, options.seconds
    )


def known_load(mass: float, *center: float) -> Payload:
    """Return a load on the flange [kg], with its centre of mass in frame 6 [m].

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
    """Return a table [m] and the boxes of a YAML file. Raises InputError where they are wrong."""
    if table is not None and not math.isfinite(table):
        raise InputError(f"--table {table}: give its height in the base frame [m]")
    try:
        listed = [] if boxes is None else read_yaml(boxes)
        return Surroundings(table=table, boxes=listed)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"--boxes {boxes} cannot be read: {error}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise InputError(
            f"{boxes}: {where}: {first['msg']}; list boxes as {{center: [x, y, z], "
            "size: [x, y, z]}} in metres, base frame"
        ) from error


def _worth_lines(problem: Problem, worth: Worth) -> Iterator[str]:
    """Yield the information of a trajectory, and the least determined parameters' errors."""
    yield (
        f"log det of the information: {worth.log_det:.1f}, {worth.gain:.1f} more than before; "
        f"condition number of the regressor {worth.regressor_condition:.0f}, of the whole problem "
        f"{worth.condition:.0f}"
    )
    yield "least determined so far, predicted standard errors before and after:"
    names, units = problem.names(), problem.units()
    for k in worth.least_determined()[:MAX_PRINTED]:
        yield f"  {names[k]:<34} {worth.before[k]:>9.2g} {worth.after[k]:>9.2g} {units[k]}"
    worst = worth.least_determined()[0]
    if worth.hardly_lowered()[worst]:
        yield f"this motion would hardly lower the first of these errors: {LOAD}"


class Recorded(NamedTuple):
    """Independent states of a recording: link model with its payload and mounting, regressor Y
    (N, 6, 66), velocities (N, 6) [rad/s].
    """

    model: LinkModel
    Y: Array
    qd: Array


def problem_after(
    arm: Robot, model: LinkModel, study: FinishedStudy, has_payload: bool
) -> tuple[Problem, Array]:
    """Return the problem of an arm that a study identified, and the information (P, P) so far.

    arm: as identified; has_payload: whether a load is estimated. The noise of the currents is
    scaled to the study's standard errors, which include correlated residuals and differences
    between recordings. Raises InputError where a file is missing.
    """
    friction, base = (
        study.parameters(Friction, arm.name, "friction"),
        study.parameters(Identification, arm.name, "identification"),
    )
    known = study.configuration()
    population = population_of(population_files(known.settings.friction.population), known.study)
    problem = build_problem(arm, model, _maps(arm, friction, base), has_payload, population)
    recordings = [*_recorded(arm, study, sorted({*friction.from_, *base.from_}))]
    if friction.from_:
        problem = _as_observed(problem, recordings, _observed(friction))
    return problem, _information(problem, recordings)


def _maps(arm: Robot, friction: Friction, base: Identification) -> Maps:
    """Return the fitted maps from torque and motion to currents, with noise; else nominal ones."""
    nominal = nominal_maps(arm)
    torque = nominal.noise.torque if base.noise is None else base.noise
    if not friction.from_:
        return Maps(nominal.coefficients, Noise(torque, nominal.noise.current))
    fit = friction.fit
    bands = np.array([joint.band_moving for joint in fit.joints]) / NORMAL95
    current = np.where(np.isfinite(bands), bands, nominal.noise.current)
    return Maps(np.array([_kept(joint) for joint in fit.joints]), Noise(torque, current))


def _kept(joint: JointFit) -> list[float]:
    """Return a joint's coefficients of KEPT; zero for a term that the fit does not have."""
    fitted = dict(zip(joint.names(), joint.estimate.coefficients.tolist(), strict=True))
    return [fitted.get(name, 0.0) for name in KEPT]


def _observed(friction: Friction) -> Array:
    """Return a study's standard errors (6, 5) of KEPT, NaN for a missing term."""
    errors = {(row.joint, row.name): row.std_error for row in friction.parameters}
    return np.array([[errors.get((k, name), np.nan) for name in KEPT] for k in range(1, 7)])


def _recorded(arm: Robot, study: FinishedStudy, names: Sequence[str]) -> Iterator[Recorded]:
    """Yield the states of recordings."""
    for name in names:
        robot = arm.carrying(study.payload(name))
        robot = robot.mounted(study.recording(name).known_gravity())
        model = LinkModel(robot, robot.fullest_model())
        motion = study.record(Motion, name)
        every = max(1, round(INDEPENDENT / float(np.median(np.diff(motion.time)))))
        states = np.stack([motion.q, motion.qd, motion.qdd])[:, ::every]
        q, qd, qdd = states[:, np.isfinite(states).all(axis=(0, 2))]
        yield Recorded(model, model.regressor(q, qd, qdd), qd)


def _as_observed(problem: Problem, recordings: Sequence[Recorded], observed: Array) -> Problem:
    """Return the problem with the noise of currents scaled to the observed standard errors (6, 5).

    One factor for each joint: the median over its five parameters, at least 1.
    """
    noise, factor = problem.noise, np.ones(6)
    for _ in range(ROUNDS):
        errors = problem.standard_errors(_information(problem, recordings))
        predicted = errors[problem.of_currents].reshape(6, 5)
        factor = np.maximum(factor * np.nanmedian(observed / predicted, axis=1), 1)
        problem = replace(problem, noise=replace(noise, current=noise.current * factor))
    return problem


def _information(problem: Problem, recordings: Sequence[Recorded]) -> Array:
    """Return the information (P, P) of the prior and of recordings."""
    information = problem.prior.copy()
    for model, Y, qd in recordings:
        information += problem.of_model(model.parameters).information(Y, qd, INDEPENDENT)
    return information
