# The study as a typed model, and the files, settings and code that all steps need.
import json
import os
import re
import tempfile
from functools import cache
from hashlib import sha256

from snakemake.exceptions import WorkflowError

from ur5lib.errors import InputError
from ur5lib.lab.extensions import KINDS, source_files
from ur5lib.lab.places import CITATION, PACKAGE, SCRIPTS, SNAKEFILE
from ur5lib.report.page.document import MOST_SHOWN, Picture, contents
from ur5lib.report.reference import read_reference
from ur5lib.robots.description import JOINT_SIZES, robot_path
from ur5lib.steps.batches import Batches, Step
from ur5lib.steps.workers import FAILED, run_batch, run_step
from ur5lib.strict import SNAKEMAKE_PLACEHOLDER, read_yaml
from ur5lib.study.reading import names_by_pattern, parse_study, study_text
from ur5lib.study.turn import share_turn, take_turn

waits = config.pop("wait", False)
try:
    STUDY = parse_study(config, str((workflow.overwrite_configfiles or workflow.configfiles)[-1]))
    PUBLISHED = read_reference(STUDY.reference)
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
ENTRIES = {recording.name: recording for recording in STUDY.recordings}
AT_REST = [name for name, entry in ENTRIES.items() if entry.at_rest]  # postures, without time
RECORDINGS = {name: entry for name, entry in ENTRIES.items() if name not in AT_REST}
PRINTED = sorted(PUBLISHED.recordings() & RECORDINGS.keys())
EXPLAINED = sorted(PUBLISHED.explained() & RECORDINGS.keys())
OLDER_MODEL = sorted(PUBLISHED.of_older_model() & RECORDINGS.keys())
LOOPS = "closed_loop_q", "closed_loop_qd"
PRINTED_TRACKING = sorted(PUBLISHED.recordings(*LOOPS) & RECORDINGS.keys())
FILTERED_FIRST = sorted(PUBLISHED.explained_accelerations().keys() & RECORDINGS.keys())
PRINTED_CURRENTS = sorted(PUBLISHED.recordings("current_torque") & RECORDINGS.keys())
SIMULATED = [name for name, recording in RECORDINGS.items() if getattr(recording, "simulate", None)]
RESULTS = f"results/{STUDY.study}"
TRUTHS = {name: f"{RESULTS}/truth/{name}" for name in SIMULATED} | {  # without their suffixes
    name: f"{recording.folder}/{recording.truth}"
    for name, recording in RECORDINGS.items()
    if getattr(recording, "truth", None)
}
BY_PATTERN = names_by_pattern(config["recordings"])
MOST_ALONE = 100  # recordings whose steps are jobs of their own
MOST_DRAWN = 40  # contact-free recordings of an arm on which contacts are tried, of many
BATCHES = None  # of more recordings than that
SETTINGS = STUDY.settings
REFERENCE = {"reference": STUDY.reference} if STUDY.reference else {}
CONTACT_FREE = [name for name, one in RECORDINGS.items() if one.role != "contact"]
TOUCHED = [name for name, recording in RECORDINGS.items() if recording.role == "contact"]
ARMS = STUDY.arms()
ROBOTS = sorted(ARMS)
WRIST_SENSORS = {name for name, arm in ARMS.items() if arm.description().wrist_sensor}
WITH_WRIST_SENSOR = [name for name, one in RECORDINGS.items() if one.arm.known_as in WRIST_SENSORS]


# A second run of a study would delete what the first has made. Who waits plans afterwards.
turn = []
try:
    if workflow.remote_exec:
        turn.append(share_turn(Path(RESULTS)))
    elif waits and workflow.is_main_process:
        turn.append(take_turn(Path(RESULTS), wait=True))
except InputError as error:
    raise WorkflowError(str(error))


# Snakemake's limit of jobs a second adds a timer with each job that ends, and each timer weighs all
# jobs anew every second, to the end of the run: more than the work of the jobs. No option ends it.
onstart:
    if workflow.is_main_process and not turn:
        try:
            turn.append(take_turn(Path(RESULTS)))
        except InputError as error:
            raise WorkflowError(str(error))
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


wildcard_constraints:
    recording="[^/]+",
    robot="[^/]+",


def result(name):
    """Return the path of a recording's file, with the recording as a wildcard."""
    return f"{RESULTS}/recordings/{{recording}}/{name}"


def result_if_made(name, step):
    """Return a function of the path of a recording's file, of none where the step does not run."""
    return lambda wildcards: (
        results(name, [wildcards.recording]) if wildcards.recording in recordings_of(step) else []
    )


def results(name, recordings=RECORDINGS):
    """Return the paths of a file of each of some recordings."""
    return [f"{RESULTS}/recordings/{recording}/{name}" for recording in recordings]


def parameter(name):
    """Return the path of an arm's file, with the arm as a wildcard."""
    return f"{RESULTS}/parameters/{{robot}}/{name}"


def parameters(name):
    """Return the paths of a file of each arm."""
    return [f"{RESULTS}/parameters/{robot}/{name}" for robot in ROBOTS]


def arm_of(wildcards):
    """Return the name of a job's arm, or of the arm of its recording."""
    return getattr(wildcards, "robot", None) or recording_of(wildcards).arm.known_as


def parameter_of(name):
    """Return a function of the path of a file of a recording's arm."""
    return lambda wildcards: parameter(name).format(robot=arm_of(wildcards))


@cache
def names_of(robot, *roles):
    """Return the names of an arm's recordings with some roles."""
    return [
        name
        for name, recording in RECORDINGS.items()
        if recording.role in roles and recording.arm.known_as == robot
    ]


def fitted_on(wildcards):
    """Return the names of an arm's `fit` recordings."""
    return names_of(arm_of(wildcards), "fit")


def contact_free(wildcards):
    """Return the names of an arm's contact-free recordings."""
    return names_of(arm_of(wildcards), "fit", "validate")


def postures(name, recordings):
    """Return the paths of a file of each of some recordings of postures at rest."""
    return [f"{RESULTS}/postures/{recording}/{name}" for recording in recordings]


def postures_of(wildcards):
    """Return what an arm's `fit` recordings at rest hold."""
    robot = arm_of(wildcards)
    own = [name for name in AT_REST if ENTRIES[name].arm.known_as == robot]
    return postures("postures.json", [name for name in own if ENTRIES[name].role == "fit"])


def results_of(names, file):
    """Return a function of the paths of a file of each recording that another function names."""
    return lambda wildcards: results(file, names(wildcards))


def date_of(name):
    """Return the date of a recording; empty where the study gives none."""
    return str(RECORDINGS[name].date or "")


@cache
def drawn_of(robot):
    """Return the contact-free recordings of an arm on which contacts are tried.

    Of many, some that are drawn by their names: another recording seldom changes the choice.
    """
    names = names_of(robot, "fit", "validate")
    if len(RECORDINGS) <= MOST_ALONE:
        return names
    drawn = sorted(names, key=lambda name: sha256(name.encode()).digest())[:MOST_DRAWN]
    return [name for name in names if name in drawn]


def drawn(wildcards):
    """Return the recordings of an arm on which contacts are tried."""
    return drawn_of(arm_of(wildcards))


def is_tried(wildcards):
    """Return whether pushes are tried on a recording, to find the smallest that is detected."""
    return recording_of(wildcards).role == "validate" and wildcards.recording in examined()


def recording_of(wildcards):
    return ENTRIES[wildcards.recording]


def what_was_recorded(wildcards):
    """Return the description of a recording for its reader, without its use in the study."""
    names = "name role robot date gravity mounting tool payload untouched simulate truth".split()
    unread = dict.fromkeys(names, True) | {"force_sensor": {"mounting"}}
    return recording_of(wildcards).model_dump_json(exclude=unread)


def gravity_of(wildcards):
    """Return gravity in the base frame of a recording [m/s²]; None: as described for the arm."""
    return gravities([wildcards.recording])[0]


def gravities(names):
    """Return gravity in the base frames of several recordings."""
    found = [ENTRIES[name].known_gravity() for name in names]
    return [gravity and list(gravity) for gravity in found]


def gravities_of(names):
    """Return a function of gravity in the base frames of recordings that another function names."""
    return lambda wildcards: gravities(names(wildcards))


def payload_of(wildcards):
    """Return the payload that the study declares for a recording, as JSON; empty without one."""
    payload = recording_of(wildcards).known_payload()
    return payload.model_dump_json() if payload else ""


def tcp_of(wildcards):
    """Return the tool centre point that the study declares for a recording; empty without one."""
    tool = recording_of(wildcards).known_tool()
    return list(tool.tcp) if tool and tool.tcp else []


def sensor_mounting_of(wildcards):
    """Return position [m] and turn [°] of a recording's force sensor; None: as described."""
    sensor = getattr(recording_of(wildcards), "force_sensor", None)
    mounting = sensor.mounting if sensor else None
    return [mounting and [*mounting.position_m], mounting and [*mounting.rotation_deg]]


@cache
def raw_files(name):
    """Return the files that a recording names, or all files where readers look for others."""
    folder = Path(ENTRIES[name].folder)
    named = [folder / file for file in ENTRIES[name].file_names()]
    if name in SIMULATED:
        return [str(path) for path in named]
    files = named or [*folder.glob("*"), *folder.glob("csv_files/*")]
    paths = sorted(str(path) for path in files if path.is_file())
    return [path for path in paths if not SNAKEMAKE_PLACEHOLDER.search(path)]


def illustrated():
    """Return the recordings whose figures the report may show.

    Those with printed values, the first few with a contact or to validate, and the first.
    """
    touched = sorted(TOUCHED, key=lambda name: not has_force_sensor(name))
    validated = [name for name in RECORDINGS if RECORDINGS[name].role == "validate"]
    chosen = {*PRINTED, *touched[:MOST_SHOWN], *validated[:MOST_SHOWN], *[*RECORDINGS][:1]}
    return [name for name in RECORDINGS if name in chosen]


@cache
def examined():
    """Return the recordings of which all is examined: of many, some that are drawn, and those that
    are shown or fitted to. No force depends on what is examined of these alone.
    """
    if len(RECORDINGS) <= MOST_ALONE:
        return [*RECORDINGS]
    by_name = (name for robot in ROBOTS for name in drawn_of(robot))
    chosen = {*by_name, *illustrated(), *OLDER_MODEL, *PRINTED_TRACKING}
    return [name for name, one in RECORDINGS.items() if name in chosen or one.role == "fit"]


def figures_of_run(wildcards):
    """Return the figures of a recording's own page."""
    tracking = rules.draw_tracking.output if wildcards.recording in examined() else []
    return expand([*rules.draw_figures.output, *tracking], recording=wildcards.recording)


def has_force_sensor(name):
    """Return whether a recording names or holds a file of a force sensor."""
    named = getattr(RECORDINGS[name], "force_sensor", None)
    return bool(named) or any("force_sensor" in path for path in raw_files(name))


def way_points(name):
    """Return the file of way-points of a simulated recording, if any."""
    given = getattr(RECORDINGS[name].simulate.trajectory, "way_points", None)
    return {"way_points": given} if isinstance(given, str) else {}


def arm_file(wildcards):
    return described(arm_of(wildcards))


def described(robot):
    """Return the path of an arm's description, with what is its own."""
    return f"{RESULTS}/parameters/{robot}/described.yaml"


def traces(step, of=None):
    """Return the paths of a job's log and benchmark."""
    job = f"{step}/{of}" if of else step
    return {
        "log": f"{RESULTS}/logs/{job}.log",
        "benchmark": f"{RESULTS}/benchmarks/{job}.tsv",
    }


def in_cluster(group):
    """Return a function of the group of steps that are one job of a cluster; elsewhere, none are.

    Snakemake checks groups in a time that grows with the cube of the number of recordings.
    """
    return lambda wildcards: group if workflow.group_settings.group_components else None


def code(step, *files):
    """Return a checksum of a step's script, of all library modules that it uses, and of files.

    files: of the library, too. It is the same wherever the library is installed. Extensions of the
    lab count as code of the steps whose modules take them up.
    """
    script = SCRIPTS / f"{step}.py"
    modules, unseen = set(), {script}
    while unseen:
        modules |= unseen
        unseen = {used for module in unseen for used in imported_modules(module)} - modules
    library = sorted(modules - {script} | {*files})
    extensions = source_files(modules)
    return sha256(b"".join(map(content, [script, *library, *extensions]))).hexdigest()[:16]


@cache
def content(path):
    return path.read_bytes()


def shipped(*paths):
    """Return those files that belong to the library: they count as code of a step, see `code`."""
    return [Path(path) for path in paths if Path(path).is_relative_to(PACKAGE)]


def own(*paths):
    """Return those files that belong to the study: inputs of a step."""
    return [str(path) for path in paths if not Path(path).is_relative_to(PACKAGE)]


TYPES = re.compile(r"^if TYPE_CHECKING:.*\n(?: .*\n)+", re.MULTILINE)  # types change no result
IMPORT = re.compile(r"^ *(?:from|import) (ur5lib[\w.]*)(?: import (\([^)]*\)|.*))?", re.MULTILINE)


@cache
def imported_modules(path):
    """Return the files of ur5lib modules that a Python file imports, without importing them."""
    found = IMPORT.findall(TYPES.sub("", content(path).decode()))
    names = {module for module, _ in found}
    names |= {f"{module}.{name}" for module, of in found for name in re.findall(r"\w+", of)}
    stems = [PACKAGE.parent.joinpath(*name.split(".")) for name in names]
    files = [file for stem in stems for file in (stem.with_suffix(".py"), stem / "__init__.py")]
    return {file for file in files if file.is_file()}


def outputs_in(folder):
    """Outputs of every job of the rules so far that lie in a folder of the results."""
    return of_every_job("output", f"{RESULTS}/{folder}/")


def parts_of_tables():
    """Return the CSV files that steps so far write for each arm, by their name.

    Together they are the table of this name.
    """
    parts = {}
    for path in outputs_in("parameters"):
        if path.endswith(".csv"):
            parts.setdefault(Path(path).stem, []).append(path)
    return parts


def drawn_by(rule, of=""):
    """Return the figures that the report's contents name as drawn by a rule, each with its numbers
    as CSV.

    of: the wildcard of the recordings or arms that each is drawn for, none for the whole study.
    """
    blocks = (block for part in contents().parts() for block in part.flat())
    own = (block for block in blocks if isinstance(block, Picture) and block.rule == rule)
    names = dict.fromkeys(block.figure for block in own)
    folder = f"{RESULTS}/figures/{of}" if of else f"{RESULTS}/figures"
    figures = {
        name: report(
            f"{folder}/{name}.svg",
            caption="../captions/figures.rst",
            category="Figures",
            subcategory=of or "study",
            labels={"figure": name.replace("_", " ")},
        )
        for name in names
    }
    return figures | {f"{name}_data": f"{folder}/{name}.csv" for name in names}


def as_wide_as_a_column(figure):
    """Return the path of a figure for a paper, as wide as its columns, by that of the report's."""
    return figure.replace(f"{RESULTS}/figures", f"{RESULTS}/paper/figures").replace(".svg", ".pdf")


def tables_of(studies, names):
    """Return the paths of tables of results of some studies."""
    return [f"results/{study}/tables/{name}.csv" for study in studies for name in names]


def tables(names):
    """Return the tables of results."""
    return {
        name: report(
            f"{RESULTS}/tables/{name}.csv",
            caption="../captions/tables.rst",
            category="Tables",
            labels={"table": name.replace("_", " ")},
        )
        for name in names
    }


CONSTRAINT = re.compile(r"\{(\w+),[^}]*\}")  # of a wildcard, as Snakemake adds it


@cache
def recordings_of(step):
    """Return the recordings that a step of each recording runs for by itself."""
    only = {
        "audit_sensor": [name for name in examined() if name in WITH_WRIST_SENSOR],
        "draw_figures": illustrated(),
        "estimate_gains": examined(),
        "examine_joints": CONTACT_FREE,
        "draw_tracking": PRINTED_TRACKING or illustrated(),
        "draw_filtered_first": FILTERED_FIRST,
        "draw_older_model": OLDER_MODEL,
        "draw_current_torque": PRINTED_CURRENTS,
        "draw_published_forces": PRINTED,
        "tabulate_postures": AT_REST,
        "write_run": [],  # on demand alone
    }
    return only.get(step, RECORDINGS)


def of_every_job(kind, start=""):
    """Return the outputs or logs (`output`, `log`) that a run makes by the rules above, of which the
    paths have a start.

    What is for a paper is made on demand alone.
    """
    batches = BATCHES.batches if BATCHES else []
    files = {step.name: getattr(step, kind) or [] for step in workflow.rules}
    patterns = {
        CONSTRAINT.sub(r"{\1}", str(file)): recordings_of(name)
        for name, found in files.items()
        for file in ([found] if isinstance(found, str) else found)
        if str(file).startswith(start) and not str(file).startswith(f"{RESULTS}/paper")
    }
    of = {"{recording}": None, "{robot}": ROBOTS, "{batch}": batches}
    return [
        path
        for pattern, names in patterns.items()
        for path in filled_in(pattern, of | {"{recording}": names})
    ]


def filled_in(pattern, of):
    """Return the paths of a pattern with at most one wildcard; `expand` takes ten times as long."""
    found = next((wildcard for wildcard in of if wildcard in pattern), None)
    return [pattern.replace(found, name) for name in of[found]] if found else [pattern]
