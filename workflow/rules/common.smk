# The study, and the paths, settings and code that all rules need.
import os
import re
import tempfile

from snakemake.exceptions import WorkflowError

from ur5lib.errors import InputError
from ur5lib.jobs.code import checksum_of_step, in_library
from ur5lib.jobs.declared import declared, every, is_figure, written_by
from ur5lib.jobs.page import check_page
from ur5lib.jobs.snakemake_inside import (
    end_beside_the_schedule,
    files_of_rules,
    is_job_of_cluster,
    plans_jobs,
    stop_rescheduling,
    study_file,
)
from ur5lib.jobs.unreadable import unreadable
from ur5lib.jobs.workers import FAILED, run_step
from ur5lib.robots.description import JOINT_SIZES_FILE, robot_path
from ur5lib.study.given import FILES, OF_OTHERS, among, design, of_arm, setting
from ur5lib.study.reading import parse_study, study_text
from ur5lib.study.selection import Selection
from ur5lib.study.turn import share_turn, take_turn
from ur5lib.workspace.extensions import KINDS, source_files
from ur5lib.workspace.places import CITATION, PACKAGE, SNAKEFILE

waits = config.pop("wait", False)
try:
    STUDY = parse_study(config, study_file(workflow))
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
    "paths",
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
    if is_job_of_cluster(workflow):
        turn.append(share_turn(Path(RESULTS)))
    elif waits and plans_jobs(workflow):
        turn.append(take_turn(Path(RESULTS), wait=True))
except InputError as error:
    raise WorkflowError(str(error))


onstart:
    if plans_jobs(workflow) and not turn:
        try:
            turn.append(take_turn(Path(RESULTS)))
        except InputError as error:
            raise WorkflowError(str(error))
    try:
        check_page_if_new()
    except InputError as error:
        raise WorkflowError(str(error))
    stop_rescheduling(workflow)
    end_beside_the_schedule()


wildcard_constraints:
    recording="[^/]+",
    robot="[^/]+",


def check_page_if_new():
    """Typeset the page of an empty study, before any job, if a source is newer than the report."""
    page = Path(f"{RESULTS}/report.html")
    since = page.stat().st_mtime if page.is_file() else 0
    if plans_jobs(workflow) and max(path.stat().st_mtime for path in PAGE) > since:
        check_page()


def list_unreadable():
    """Print the recordings that cannot be read, each with the reason."""
    if absent := unreadable(Path(RESULTS)):
        print(f"\n{len(absent)} of {len(SELECTION.entries)} recordings cannot be read:")
        print(*(f"  {name}: {reason}" for name, reason in absent.items()), sep="\n")


# Paths


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


RUNS_FOR = {}  # recordings whose outputs a run makes, by step: of a topic, else as declared
LEFT_OUT = set()  # steps that this study does not have
PRIORITY = {}  # of steps that begin early


# Recordings and settings


def code(step, *files):
    """Return a checksum of a step's code, and of files of the library that it reads."""
    return checksum_of_step(step, files)


def way_points(name):
    """Return the file of way-points of a simulated recording, if any."""
    given = getattr(RECORDINGS[name].simulate.trajectory, "way_points", None)
    return {"way_points": given} if isinstance(given, str) else {}


# The rule of a declared step

FOLDERS = {
    "recording": "recordings/{recording}",
    "posture": "postures/{recording}",
    "arm": "parameters/{robot}",
}
WILDCARDS = {"recording": "{recording}", "posture": "{recording}", "arm": "{robot}"}
try:
    STEPS = every()
except InputError as error:
    raise WorkflowError(str(error))

CALIBRATE_IMU = declared("calibrate_imu")
OUTPUTS = written_by() | {"calibration_without_each": (CALIBRATE_IMU, "imu_without_each.json")}


def files_of(output, recordings):
    """Return the paths of an output for some recordings."""
    writer, file = OUTPUTS[output]
    return [f"{RESULTS}/{FOLDERS[writer.of]}/{file}".format(recording=one) for one in recordings]


def read_by(step, wildcards):
    """Return the recordings of which a step reads several files."""
    if step.of == "arm":
        return of_arm(SELECTION, step.recordings, wildcards.robot)
    return of_arm(SELECTION, "fit", SELECTION.arm(wildcards.recording))


def further_forces(step, wildcards):
    """Return the files of a topic's estimates of force, if the study has them."""
    if "further" not in OUTPUTS or OUTPUTS["further"][0].name in LEFT_OUT:
        return []
    return files_of(
        "further", read_by(step, wildcards) if step.of == "arm" else [wildcards.recording]
    )


def input_of(step, name, source):
    """Return the input of a step's rule for a parameter; None for what is no file."""
    if setting(step.of, step.recordings, source) or (source == "drifts" and not STUDY.hosts):
        return None
    if source == "name":  # of each of several recordings: that of its folder
        return None
    if source in FILES:
        return lambda wildcards: FILES[source](SELECTION, wildcards[0])
    if source in OF_OTHERS:
        output, others = OF_OTHERS[source]
        return lambda wildcards: files_of(output, others(SELECTION, wildcards[0]))
    if source == "further":
        return lambda wildcards: further_forces(step, wildcards)
    if source not in OUTPUTS:
        raise WorkflowError(
            f"{step.name} declares `{source}`, which no step writes and no study gives; "
            "see ur5lib/study/given.py"
        )
    if name in step.several:
        return lambda wildcards: files_of(source, read_by(step, wildcards))
    writer, file = OUTPUTS[source]
    return parameter_of(file) if step.of != writer.of else f"{RESULTS}/{FOLDERS[step.of]}/{file}"


def inputs(step):
    """Return the inputs of a step's rule by name."""
    found = {name: input_of(step, name, source) for name, source in step.reads.items()}
    return {name: file for name, file in found.items() if file is not None}


def settings(step):
    """Return the settings of a step's rule by name, as functions of a job's recording or arm."""
    found = {name: setting(step.of, step.recordings, one) for name, one in step.reads.items()}
    return {
        name: lambda wildcards, give=give: give(SELECTION, wildcards[0])
        for name, give in found.items()
        if give and name not in step.several
    }


def outputs(step):
    """Return the outputs of a step's rule by name; those of a figure are the figure and its data."""
    if is_figure(step):
        drawing = [name for name, file in step.writes.items() if file.endswith(".svg")]
        others = {name: file for name, file in step.writes.items() if name not in drawing}
        folder = f"{RESULTS}/figures/{WILDCARDS[step.of]}"
        return drawn(WILDCARDS[step.of], *drawing) | {
            name: f"{folder}/{file}" for name, file in others.items()
        }
    return {name: f"{RESULTS}/{FOLDERS[step.of]}/{file}" for name, file in step.writes.items()}


def code_of(step):
    """Return the checksum of a step's code, with the arm's description if the library has it."""
    if step.name != "describe_arm":
        return code(step.name)
    return lambda wildcards: code(
        step.name, JOINT_SIZES_FILE, *in_library([robot_path(ARMS[wildcards.robot].arm)])
    )


# What a run makes


def outputs_in(folder, kind="output"):
    """Return the outputs, or the logs and benchmarks (`log`), in a folder of the results of the
    rules so far.
    """

    of = {"{robot}": lambda step: ROBOTS, "{recording}": lambda step: RUNS_FOR.get(step, [])}
    paths = []
    for step, files in files_of_rules(workflow, kind):
        for file in files:
            path = re.sub(r"\{(\w+),[^}]*\}", r"{\1}", file)
            wildcard = next((name for name in of if name in path), None)
            names = of[wildcard](step) if wildcard else [""]
            if path.startswith(f"{RESULTS}/{folder}"):
                paths += [path.replace(wildcard, name) if wildcard else path for name in names]
    return paths
