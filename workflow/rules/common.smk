# The study, and the paths, settings and code that all rules need.
import os
import re
import tempfile
from functools import cache

from snakemake.exceptions import WorkflowError

from ur5lib.errors import InputError
from ur5lib.jobs.code import checksum_of_step, in_library, of_study
from ur5lib.jobs.page import check_page
from ur5lib.jobs.unreadable import unreadable
from ur5lib.jobs.workers import FAILED, end_beside_the_schedule, run_step
from ur5lib.robots.description import JOINT_SIZES_FILE, robot_path
from ur5lib.study.given import STEPS, design
from ur5lib.study.reading import parse_study, study_text
from ur5lib.study.selection import Selection
from ur5lib.study.turn import share_turn, take_turn
from ur5lib.workspace.extensions import KINDS, source_files
from ur5lib.workspace.places import CITATION, PACKAGE, SNAKEFILE

waits = config.pop("wait", False)
try:
    STUDY = parse_study(config, str((workflow.overwrite_configfiles or workflow.configfiles)[-1]))
    SELECTION = Selection(STUDY)
except InputError as error:
    raise WorkflowError(f"the study has errors\n{error}")

results_folder = Path("results") if os.path.lexists("results") else Path(".")
try:
    tempfile.TemporaryFile(dir=results_folder).close()
except OSError as error:
    raise WorkflowError(
        f"results cannot be written to {results_folder.absolute()} ({error.strerror}); "
        "check the name, the free disk space and the permissions"
    )

STUDY_TEXT = study_text(STUDY)
SETTINGS = STUDY.settings
RESULTS = f"results/{STUDY.study}"
RECORDINGS = SELECTION.recordings
TRUTHS = SELECTION.truths(RESULTS)
ARMS = STUDY.arms()
ROBOTS = sorted(ARMS)
TABLES = [  # written by make_tables for every study; others are joined from parts that steps write
    "recordings",
    "files",
    "account",
    "quality",
    "clocks",
    "acceleration_mae",
    "acceleration_bands",
    "innovations",
    "torque_mae",
    "current_rmse",
    "payload",
    "force_mae",
    "contact_errors",
    "sensed",
    "detection",
    "fixed_threshold",
    "contact_place",
    "contacts",
    "imu_calibration",
    "rotor_inertia",
    "parameters",
    "excitation",
    "remarks",
    "friction",
    "torque_constants",
    "cross_validation",
]
JUDGED = [  # tables that judge_study writes
    "verdicts",
    "uses",
    "judged_errors",
    "model_errors",
    "error_parts",
    "noticed",
    "false_alarms",
    "advice",
]
PAGE = sorted(PACKAGE.glob("report/page/**/*.*")) + sorted(PACKAGE.glob("topics/*/section.typ"))
PAGE = [path for path in PAGE if path.suffix in (".typ", ".css", ".js", ".LICENSE")]


# A second run of a study would delete the first one's results: it waits before it plans its jobs.
turn = []
try:
    if workflow.remote_exec:
        turn.append(share_turn(Path(RESULTS)))
    elif waits and workflow.is_main_process:
        turn.append(take_turn(Path(RESULTS), wait=True))
except InputError as error:
    raise WorkflowError(str(error))


# Each job's end starts a timer that reschedules all jobs every second, which takes a tenth of a
# study's time. No option stops it: https://github.com/snakemake/snakemake/pull/3744
onstart:
    if workflow.is_main_process and not turn:
        try:
            turn.append(take_turn(Path(RESULTS)))
        except InputError as error:
            raise WorkflowError(str(error))
    try:
        check_page_if_new()
    except InputError as error:
        raise WorkflowError(str(error))
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
    end_beside_the_schedule()


wildcard_constraints:
    recording="[^/]+",
    robot="[^/]+",


def check_page_if_new():
    """Typeset the page of an empty study, before any job, if a source is newer than the report."""
    page = Path(f"{RESULTS}/report.html")
    since = page.stat().st_mtime if page.is_file() else 0
    if workflow.is_main_process and max(path.stat().st_mtime for path in PAGE) > since:
        check_page()


def list_unreadable():
    """Print the recordings that cannot be read, each with the reason."""
    if absent := unreadable(Path(RESULTS)):
        print(f"\n{len(absent)} of {len(SELECTION.entries)} recordings cannot be read:")
        print(*(f"  {name}: {reason}" for name, reason in absent.items()), sep="\n")


# Paths


def result(name):
    """Return the path of a recording's file, with the recording as a wildcard."""
    return f"{RESULTS}/recordings/{{recording}}/{name}"


def results(name, recordings=RECORDINGS):
    """Return the paths of a file of each of some recordings."""
    return [f"{RESULTS}/recordings/{recording}/{name}" for recording in recordings]


def posture(name):
    """Return the path of a file of a recording of postures, with the recording as a wildcard."""
    return f"{RESULTS}/postures/{{recording}}/{name}"


def postures(name, recordings):
    """Return the paths of a file of each of some recordings of postures at rest."""
    return [f"{RESULTS}/postures/{recording}/{name}" for recording in recordings]


def parameter(name):
    """Return the path of an arm's file, with the arm as a wildcard."""
    return f"{RESULTS}/parameters/{{robot}}/{name}"


def parameters(name):
    """Return the paths of a file of each arm."""
    return [f"{RESULTS}/parameters/{robot}/{name}" for robot in ROBOTS]


def parameter_of(name):
    """Return a function that gives the path of a file of a recording's arm."""
    return lambda wildcards: parameter(name).format(robot=SELECTION.arm(wildcards.recording))


def results_of(names, file):
    """Return a function that gives the paths of a file of the recordings that `names` returns."""
    return lambda wildcards: results(file, names(wildcards.robot))


def traces(step, of=None):
    """Return the paths of a job's log and benchmark."""
    job = f"{step}/{of}" if of else step
    return {
        "log": f"{RESULTS}/logs/{job}.log",
        "benchmark": f"{RESULTS}/benchmarks/{job}.tsv",
    }


def tables_of(studies, names):
    """Return the paths of tables of results of some studies."""
    return [f"results/{study}/tables/{name}.csv" for study in studies for name in names]


def tables(names):
    """Return the tables of results."""
    return {name: f"{RESULTS}/tables/{name}.csv" for name in names}


def drawn(of, *names):
    """Return figures, each with its numbers as CSV.

    of: the wildcard of the recordings or arms that each is drawn for, none for the whole study.
    """
    folder = f"{RESULTS}/figures/{of}" if of else f"{RESULTS}/figures"
    figures = {name: f"{folder}/{name}.svg" for name in names}
    return figures | {f"{name}_data": f"{folder}/{name}.csv" for name in names}


RUNS_FOR = {}  # of a topic: the recordings of a step, if not all
FURTHER_FORCES = []  # of a topic: the file of a recording with its estimates of forces


# Recordings and settings


@cache
def fitted_on(robot):
    """Return the names of an arm's `fit` recordings."""
    return SELECTION.of_arm(robot, "fit")


@cache
def before_fitted(robot):
    """Return the names of the recordings that an arm's `fit` recordings follow."""
    return SELECTION.before(*fitted_on(robot))


@cache
def contact_free(robot):
    """Return the names of an arm's contact-free recordings."""
    return SELECTION.of_arm(robot, "fit", "validate")


@cache
def recordings_of(robot):
    """Return the names of an arm's recordings in motion."""
    return [name for name in RECORDINGS if SELECTION.arm(name) == robot]


def further_forces(wildcards):
    """Return the files of further estimates of a recording, or of an arm's `fit` recordings."""
    of = dict(wildcards)
    names = [of["recording"]] if "recording" in of else fitted_on(of["robot"])
    return [path for file in FURTHER_FORCES for path in results(file, names)]


def of_recording(method):
    """Return a function that calls a method of the selection with a job's recording."""
    return lambda wildcards: method(wildcards.recording)


def gravities_of(names):
    """Return a function that gives the gravities in base frames of the recordings of `names`."""
    return lambda wildcards: SELECTION.gravities(names(wildcards.robot))


def from_study(step):
    """Return a step's parameters from the study, as functions of a job's recording or arm."""
    return {
        name: lambda wildcards, of=of: of(SELECTION, wildcards[0])
        for name, of in STEPS[step].items()
    }


def code(step, *files):
    """Return a checksum of a step's code, and of files of the library that it reads."""
    return checksum_of_step(step, files)


def way_points(name):
    """Return the file of way-points of a simulated recording, if any."""
    given = getattr(RECORDINGS[name].simulate.trajectory, "way_points", None)
    return {"way_points": given} if isinstance(given, str) else {}


# What a run makes


def outputs_in(folder, kind="output"):
    """Return the outputs, or the logs and benchmarks (`log`), in a folder of the results of the
    rules so far.
    """

    def recordings(step):
        return RUNS_FOR.get(step, SELECTION.of_step(step))

    of = {"{robot}": lambda step: ROBOTS, "{recording}": recordings}
    paths = []
    for step in workflow.rules:
        for file in getattr(step, kind) or []:
            path = re.sub(r"\{(\w+),[^}]*\}", r"{\1}", str(file))
            wildcard = next((name for name in of if name in path), None)
            names = of[wildcard](step.name) if wildcard else [""]
            if path.startswith(f"{RESULTS}/{folder}"):
                paths += [path.replace(wildcard, name) if wildcard else path for name in names]
    return paths
