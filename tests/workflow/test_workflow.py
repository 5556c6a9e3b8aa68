"""The workflow itself: what reruns and what does not, and what it does with bad input."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest
from lxml.html import fromstring

from tests import warm_snakemake
from tests.command import time_limit
from tests.conftest import PROJECT, STUDY, Change, Workflow, copy_project
from tests.house.test_hostile import BOMBS
from tests.stored_files import made_up_channels, write_npz
from tests.typeset_page import plain
from ur5lib.jobs.code import (
    all_steps,
    imported_modules,
    module_of,
    modules_of_step,
    steps_with,
)
from ur5lib.jobs.declared import every, written_by
from ur5lib.study.turn import take_turn
from ur5lib.tables import read_csv, read_table

SECONDS = 60  # in which a run that must fail ends
RECORDINGS = 2
RUN = "run_times", "ro-crate-metadata"  # files that say when or how long it ran
ANALYSED = rb"""(?i)analysed( on |": ")(\d+ \w+ \d{4}|[\d-]+)"""  # a kept study is of another day
EDITED = "\nEDITED = True\n"  # appended to a module
POWER = '''\
"""Mean mechanical power of a recording."""

from dataclasses import dataclass

import numpy as np

from ur5lib.records.dynamics import Torques
from ur5lib.records.forces import Forces
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.step import step
from ur5lib.robots.description import Robot


class Inputs(Opened):
    """What is read of a recording."""

    torques: Torques
    motion: Motion


@dataclass(frozen=True)
class Power:
    """A row of power.csv: mean mechanical power of a recording [W]."""

    power_w: float


@step("recording", "power.csv")
def measure_power(recording: Inputs, arm: Robot) -> list[Power]:
    """Return the mean of |τᵀ q̇| [W]."""
    torque = recording.torques.measured[arm.chosen_model]
    return [Power(float(np.abs((torque * recording.motion.qd).sum(axis=1)).mean()))]
'''
SENSED = ["judge_sensor", "judge_contacts", "draw_figures"]
FROM_FORCES = ["estimate_forces", *SENSED]
FROM_LOADS = ["estimate_load", "predict_currents", "judge_recording", *FROM_FORCES]
FROM_TORQUES = ["compute_torques", *FROM_LOADS]
ACCELERATIONS = ["compare_accelerations", "draw_figures"]
FROM_ARM = [*FROM_TORQUES, "compare_accelerations"]
FROM_MOTION = ["align_recording", *FROM_ARM]
EACH_RECORDING = ["read_recording", *FROM_MOTION]
MODELS = {"identify_model": 1, "draw_models": 1}  # of the only arm
MEASURED = {"measure_repetition": 1, "measure_pushes": 1}
RESIDUALS = {"fit_residuals": 1, "set_threshold": 1} | MEASURED
FITTED = {"fit_friction": 1, "draw_friction": 1}
FRICTION = FITTED | RESIDUALS
IMU = {"calibrate_imu": 1, "calibrate_imu_without_each": 1}
ARM = IMU | MODELS | FRICTION
DRIFTS = {"pool_drifts": 1}
DOCUMENTED = {"write_report": 1, "describe_run": 1}
DOCUMENT = {"time_steps": 1} | DOCUMENTED
REPORT = {"make_tables": 1, "judge_study": 1, "draw_calibration": 1} | DOCUMENT
DRAWINGS = {
    "draw_filters": 1,
    "draw_friction": 1,
    "draw_models": 1,
    "draw_calibration": 1,
}
ALL_ELSE = DRIFTS | ARM | {"draw_filters": 1} | REPORT
FRESH = {"describe_arm": 1} | ALL_ELSE


FILES = *PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")
RULES = {str(path.relative_to(PROJECT)): path.read_text() for path in FILES}
RULES_OF_TOPICS = "".join(text for path, text in RULES.items() if "topics" in path)


def rules() -> Iterator[tuple[str, str]]:
    """Each rule with a text of its own, also in a condition, and this; without a name in a loop."""
    for text in RULES.values():
        for rule in re.split(r"^ *rule\b", text, flags=re.MULTILINE)[1:]:
            yield rule[: rule.index(":")].strip(), rule


DECLARED = {step.name: step for step in every()}
SOME_STUDIES = [path for path, text in RULES.items() if "LEFT_OUT" in text]  # have these topics
OF_TOPICS = {*re.findall(r"^rule (\w+):", RULES_OF_TOPICS, re.MULTILINE)}
OF_TOPICS |= {
    name
    for name in DECLARED
    if (folder := module_of(name).relative_to(PROJECT).parent).parts[1] == "topics"
    and f"{folder}/rules.smk" not in SOME_STUDIES
}


OF_A_TOPIC = [  # sections of topics, of which one is as good as all
    str(path.relative_to(PROJECT)) for path in sorted(PROJECT.glob("ur5lib/topics/*/section.typ"))
][:1]


def chain(planned: dict[str, int]) -> dict[str, int]:
    """The jobs of a plan but for those of topics."""
    return {rule: count for rule, count in planned.items() if rule not in OF_TOPICS}


def names_of_files(text: str) -> set[str]:
    """The names of results in a part of a rule."""
    return {*re.findall(r'"([\w.]+\.(?:csv|json|parquet))"', text)}


def topics_after(planned: Iterable[str], edited: Path | None = None) -> set[str]:
    """The rules of topics that read what planned ones make, or whose steps use an edited module."""
    parts = {name: rule.partition("output:") for name, rule in rules()}
    read = {name: names_of_files(start) for name, (start, _, _) in parts.items()}
    made = {name: names_of_files(end.partition("log:")[0]) for name, (_, _, end) in parts.items()}
    for name, step in DECLARED.items():
        made[name] = {*step.writes.values()}
        read[name] = {written_by()[one][1] for one in step.reads.values() if one in written_by()}
    found = {name for name in OF_TOPICS if edited in modules_of_step(name)}
    while True:
        new = set[str]().union(*(made[name] for name in {*planned, *found} & made.keys()))
        more = {name for name in OF_TOPICS if read[name] & new} - found
        if not more:
            return found
        found |= more


def jobs(*rules: str, recordings: int = RECORDINGS) -> dict[str, int]:
    """Jobs of so many recordings."""
    return dict.fromkeys(rules, recordings)


def results(workflow: Workflow) -> dict[str, bytes]:
    """What the user gets, byte by byte, without when it was made and how long it took."""
    folder = workflow.folder / "results" / "small"
    kinds = {".csv", ".parquet", ".json", ".svg", ".html"}
    files = [p for p in folder.rglob("*") if p.suffix in kinds and p.stem not in RUN]
    files = [p for p in files if folder / "logs" not in p.parents]  # which hold times
    found = {str(path.relative_to(folder)): path.read_bytes() for path in files}
    times = {"report.html": rb"The \d+ jobs took.*?</p>"}
    times["details.html"] = rb'id="run-times".*?</table>'
    for page in times.keys() & found.keys():
        found[page], cut = re.subn(times[page], b"", found[page], flags=re.DOTALL)
        assert cut == 1
    for page in {*times, "results.json"} & found.keys():
        found[page] = re.sub(ANALYSED, b"", found[page])
    return found


def append(path: Path, text: str) -> None:
    path.write_text(path.read_text() + text)


NEW = "  - {name: new, robot: ur5, format: thesis-csv, folder: raw/new, role: ROLE}\n"


# What a run makes


def test_snakemake_finds_no_fault_with_the_rules(built_workflow: Workflow) -> None:
    done = built_workflow.run("--lint")
    assert done.returncode == 0, done.stdout
    assert "Congratulations" in done.stdout


def test_a_second_run_has_nothing_to_do(built_workflow: Workflow) -> None:
    assert built_workflow.plan() == {}


def test_a_fresh_run_does_every_step(built_workflow: Workflow, change: Change) -> None:
    change("results", None)
    planned = built_workflow.plan()
    assert chain(planned) == jobs(*EACH_RECORDING) | FRESH
    assert planned.keys() >= OF_TOPICS


def test_every_step_leaves_a_log_and_its_time(built_workflow: Workflow) -> None:
    folder = built_workflow.folder / "results" / "small"
    for step in EACH_RECORDING:
        for recording in ("still", "pushed"):
            assert (folder / "logs" / step / f"{recording}.log").read_text() == ""
            assert (folder / "benchmarks" / step / f"{recording}.tsv").exists()
    assert {*EACH_RECORDING} <= {*read_csv(folder / "tables" / "run_times.csv")["step"]}


# What reruns, and what does not


@pytest.mark.parametrize(
    ("module", "expected"),
    [
        ("ur5lib/timeseries/lowpass.py", jobs(*EACH_RECORDING) | ALL_ELSE),
        (
            "ur5lib/force/residual_model.py",
            jobs("judge_recording", *FROM_FORCES) | RESIDUALS | REPORT,
        ),
        # Judgements: no force estimate runs again.
        ("ur5lib/signals/imu_calibration.py", jobs(*ACCELERATIONS) | IMU | REPORT),
        ("ur5lib/force/flange_contact.py", jobs("judge_contacts") | REPORT),
        # The words of a judge's warning; words, pictures and layout of the page.
        ("ur5lib/steps/judge_recording.py", jobs("judge_recording") | REPORT),
        ("ur5lib/report/found.py", DOCUMENTED),
        ("ur5lib/report/next_steps.py", DOCUMENTED),
        ("ur5lib/report/views/contacts.py", DOCUMENTED),
        ("ur5lib/report/page/sections/currents.typ", DOCUMENTED),
        ("ur5lib/report/page/kit/numbers.typ", DOCUMENTED),
        ("ur5lib/report/page/kit/page.css", DOCUMENTED),
        ("ur5lib/report/page/templates/closer/look.js", DOCUMENTED),
        *((section, DOCUMENTED) for section in OF_A_TOPIC),
        ("ur5lib/report/figures/house_style.py", jobs("draw_figures") | DRAWINGS | DOCUMENT),
        ("ur5lib/cli.py", {}),
    ],
)  # fmt: skip
def test_editing_code_reruns_its_users(
    built_workflow: Workflow, change: Change, module: str, expected: dict[str, int]
) -> None:
    change(module, EDITED)
    planned = built_workflow.plan()
    of_topics = topics_after(expected, PROJECT / module)
    assert chain(planned) == expected | (DOCUMENT if of_topics else {})
    assert planned.keys() & OF_TOPICS == of_topics


@pytest.mark.parametrize(
    ("module", "first", "kept"),
    [
        ("timeseries/kalman.py", "align_recording", "read_recording"),
        ("dynamics/rigid_body.py", "identify_model", "align_recording"),
        ("checks/currents.py", "compute_torques", "compare_accelerations"),
        ("robots/friction.py", "identify_model", "align_recording"),
        ("identification/payload.py", "estimate_load", "fit_friction"),
        ("smoothing/imu_fusion.py", "compare_accelerations", "calibrate_imu"),
        ("force/sensor.py", "judge_sensor", "estimate_forces"),
        ("steps/judge_contacts.py", "judge_contacts", "judge_sensor"),
        ("judging/may_be_used.py", "make_tables", "estimate_forces"),
        ("report/views/contacts.py", "write_report", "judge_study"),
        ("judging/limits.py", "make_tables", "judge_contacts"),
    ],
)
def test_a_module_is_a_part_of_the_steps_that_use_it(module: str, first: str, kept: str) -> None:
    """Which run again when it is edited, with all that reads their files."""
    steps = {*steps_with(PROJECT / "ur5lib" / module)}
    assert first in steps
    assert kept not in steps


def test_the_page_of_a_recording_is_made_anew_for_what_it_shows(workflow: Workflow) -> None:
    """Its layout and its numbers; not for what the report alone has."""
    page = "results/small/runs/pushed.html"
    workflow.build("--", page)
    append(workflow.folder / "ur5lib/steps/write_report.py", EDITED)
    assert workflow.plan("--", page) == {}
    append(workflow.folder / "ur5lib/report/page/sections/force.typ", "\n// edited\n")
    assert workflow.plan("--", page) == {"write_run": 1}


def test_every_rule_of_a_page_knows_its_sources() -> None:
    typeset = PROJECT / "ur5lib" / "report" / "page" / "typeset.py"
    steps = {name: re.search(r'code\(\s*"(\w+)"(.*)\)', rule) for name, rule in rules() if name}
    given = {
        name: found[2]
        for name, found in steps.items()
        if found and typeset in modules_of_step(found[1])
    }
    assert {"write_report", "write_run"} <= given.keys()
    assert [name for name, files in given.items() if "*PAGE" not in files] == []


def test_touched_code_and_words_about_it_rerun_nothing(
    built_workflow: Workflow, change: Change
) -> None:
    """Comments, and docstrings of modules and functions."""
    for path in (built_workflow.folder / "ur5lib").rglob("*.py"):
        path.touch()
    for module in ("ur5lib/force/gate.py", "ur5lib/recordings/frames.py"):
        change(module, "\n# a remark\n")
        path = built_workflow.folder / module
        text, count = re.subn(
            r'(\A|def [^\n]+:\n +)"""', r'\1"""In other words: ', path.read_text()
        )
        assert count > 2
        path.write_text(text)
    assert built_workflow.plan() == {}


SETTING = "settings: {contact: {force_n: 30.0}}\n"
HOST = "hosts: {pc: [force_sensor, imu]}\n"


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (
            SETTING,  # contacts that hide in recordings to fit on are told by their typical force
            jobs(*FROM_FORCES)
            | {"fit_residuals": 1, "judge_recording": 2, "set_threshold": 1}
            | MEASURED | REPORT,
        ),
        ("settings: {lowpass: {currents: {order: 4}}}\n", {}),  # the default, spelt out
        (HOST, jobs(*FROM_MOTION) | DRIFTS | ARM | REPORT),
        (NEW.replace("ROLE", "contact"), jobs(*EACH_RECORDING, recordings=1) | REPORT),
        (  # a contact-free one serves the others' IMU alone
            NEW.replace("ROLE", "validate"),
            jobs(*EACH_RECORDING, recordings=1)
            | jobs(*ACCELERATIONS, recordings=3)
            | {"calibrate_imu_without_each": 1}
            | DRIFTS | MEASURED | REPORT,
        ),
        (  # one to fit on reruns what was fitted; the report draws the first few of a kind
            NEW.replace("ROLE", "fit"),
            jobs(*EACH_RECORDING, recordings=1)
            | jobs(*FROM_ARM, recordings=3)
            | jobs("draw_figures")
            | DRIFTS | ARM | REPORT,
        ),
    ],
    ids=["setting", "default", "host", "contact", "validate", "fit"],
)  # fmt: skip
def test_editing_the_study_reruns_what_it_concerns(
    built_workflow: Workflow, change: Change, more: str, expected: dict[str, int]
) -> None:
    raw = built_workflow.folder / "raw"
    shutil.copytree(raw / "still", raw / "new", dirs_exist_ok=True)
    change("config.yaml", more)
    planned = built_workflow.plan()
    assert chain(planned) == expected
    taken = {"fit_live", "estimate_live", "measure_live_pushes"} if more == SETTING else set()
    assert planned.keys() - expected.keys() <= topics_after(expected) | taken


def test_a_recording_needs_the_positions_of_the_one_before_and_none_of_its_results(
    workflow: Workflow,
) -> None:
    config = workflow.folder / "config.yaml"
    config.write_text(config.read_text().replace("name: still,", "name: still, after: pushed,"))
    until = "--until", "fit_friction"
    assert workflow.plan(*until) == {"fit_friction": 1}
    workflow.build(*until)
    results = workflow.folder / "results" / "small" / "recordings" / "pushed"
    made = [DECLARED[step].writes.values() for step in ("read_recording", "align_recording")]
    for file in [*results.glob("*")]:
        if file.name not in set[str]().union(*made):
            file.unlink()
    assert workflow.plan(*until) == {}
    (results / "motion.parquet").unlink()
    assert workflow.plan(*until).keys() >= {"align_recording", "fit_friction"}


def test_a_changed_raw_file_reruns_its_recording(built_workflow: Workflow, change: Change) -> None:
    change("raw/pushed/csv_files/log_q_actual.csv", "9.0, 1, 1, 1, 1, 1, 1\n")
    assert chain(built_workflow.plan()) == jobs(*EACH_RECORDING, recordings=1) | REPORT


DELETED = {
    "recordings/pushed/torques.parquet": jobs(*FROM_TORQUES, recordings=1) | REPORT,
    "tables/force_mae.csv": REPORT,
    "figures/still/torques.svg": {"draw_figures": 1} | DOCUMENT,
}  # fmt: skip


@pytest.mark.parametrize(("file", "expected"), DELETED.items(), ids=map(str, DELETED))
def test_a_deleted_file_is_planned_again(
    built_workflow: Workflow, change: Change, file: str, expected: dict[str, int]
) -> None:
    change(f"results/small/{file}", None)
    assert chain(built_workflow.plan()) == expected


WHY = {
    "the code has changed": ("ur5lib/force/residual_model.py", EDITED),
    "the study has changed": ("config.yaml", SETTING),
    "files have changed": ("raw/pushed/csv_files/log_q_actual.csv", "9.0, 1, 1, 1, 1, 1, 1\n"),
    "results are missing": ("results/small/recordings/pushed/torques.parquet", None),
}


@pytest.mark.parametrize("reason", WHY)
def test_a_status_says_why_steps_would_run(
    built_workflow: Workflow, change: Change, reason: str
) -> None:
    change(*WHY[reason])
    assert f" steps to run, as {reason}; next: " in built_workflow.ur5("status", "small")


def processes_of(session: int) -> list[int]:
    """The processes of a run that have not ended."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(ProcessLookupError):
            if os.getpgid(int(process.name)) == session:
                found.append(int(process.name))
    return found


def end(run: int, random: np.random.Generator) -> None:
    """Kill a run as a whole, its first process alone, or any of its processes."""
    with contextlib.suppress(ProcessLookupError):
        match random.integers(3):
            case 0:
                os.killpg(run, random.choice([signal.SIGKILL, signal.SIGTERM]))
            case 1:
                os.kill(run, random.choice([signal.SIGKILL, signal.SIGTERM]))
            case 2:
                os.kill(random.choice(processes_of(run) or [run]), signal.SIGKILL)


@pytest.mark.slow
def test_runs_killed_at_random_moments_go_on_to_the_same_results(workflow: Workflow) -> None:
    """Each goes on where the last ended, some results of which were lost."""
    before, random = results(workflow), np.random.default_rng(100)
    folder = workflow.folder / "results" / "small"
    for _ in range(int(os.environ.get("KILLS", "2"))):
        lost = random.choice(["recordings/pushed", "recordings/still", "parameters", "none"])
        shutil.rmtree(folder / lost, ignore_errors=True)
        run = warm_snakemake.start(workflow.folder, workflow.environment)
        time.sleep(random.uniform(0.5, 8))
        assert run.pid is not None
        end(run.pid, random)
        run.join(timeout=200)
        assert run.exitcode is not None
    workflow.build()
    after = results(workflow)
    assert {name: after[name] for name in before} == before
    assert [*folder.rglob("*.part")] == []
    assert workflow.plan() == {}


def test_a_second_run_at_once_is_refused_and_changes_nothing(
    built_workflow: Workflow, change: Change
) -> None:
    change("results/small/tables/clocks.csv", None)
    folder = built_workflow.folder / "results" / "small"
    with take_turn(folder):
        fails_with(built_workflow, f"being made by process {os.getpid()} of ")
        assert built_workflow.plan() == REPORT
        assert not (folder / "tables" / "clocks.csv").exists()


# Other studies


def test_another_study_inherits_nothing(built_workflow: Workflow, change: Change) -> None:
    change("config.yaml", "settings: {lowpass: {motion: {cutoff_hz: 33.0}}}\n")
    change("Snakefile", "\nprint(study_text(STUDY))\n")
    other = STUDY.replace("study: small", "study: other").splitlines()[:-1]
    (built_workflow.folder / "other.yaml").write_text("\n".join(other))
    expected = jobs(*EACH_RECORDING, recordings=1) | FRESH
    assert chain(built_workflow.plan("--configfile", "other.yaml")) == expected
    said = built_workflow.run("--dry-run", "--quiet", "all", "--configfile", "other.yaml").stdout
    assert "title: Two made-up recordings" in said
    assert "cutoff_hz: 33.0" not in said
    assert "pushed" not in said


def test_a_sensor_in_an_archive_is_compared_where_it_is_mounted(workflow: Workflow) -> None:
    """Turned by half a turn about z, it reads the same push with the opposite sign."""
    raw = workflow.folder / "raw"
    time, channels = made_up_channels(raw / "made_up")
    push = np.outer((time > 3) & (time < 4), [30.0, 0, 0, 0, 0, 0])
    names = {"time": "time"} | {name: name for name in ("actual_q", "actual_current")}
    recordings = []
    for name, sign, turn in (("ahead", 1, 0), ("turned", -1, 180)):
        write_npz(raw / f"{name}.npz", time, channels | {"wrench": sign * push})
        sensor = {"channels": {"time": "time", "ft": "wrench"}}
        sensor |= {"mounting": {"rotation_deg": [0, 0, turn]}}
        entry = {"name": name, "folder": "raw", "file": f"{name}.npz", "format": "npz"}
        entry |= {"robot": "ur5", "role": "contact", "channels": names, "force_sensor": sensor}
        recordings.append(entry)
    study = {"study": "stored", "title": "A sensor in an archive", "recordings": recordings}
    (workflow.folder / "config.yaml").write_text(json.dumps(study))
    wanted = [f"results/stored/recordings/{one['name']}/sensor.parquet" for one in recordings]
    workflow.build("--", *wanted)
    ahead, turned = (read_table(workflow.folder / path) for path in wanted)
    np.testing.assert_allclose(turned, ahead, atol=1e-9)
    assert ahead.filter(like="compensated_F").abs().max().max() > 20


# Bad input: one clear sentence, a non-zero exit, nothing destroyed


def fails_with(workflow: Workflow, *sentences: str) -> str:
    """What a run prints that fails with these sentences, and leaves other results as they are."""
    before = results(workflow)
    done = workflow.run("--cores", "1")
    assert done.returncode == 1
    assert all(sentence in done.stdout for sentence in sentences), done.stdout
    assert "Traceback" not in done.stdout
    after = results(workflow)
    assert {name: after[name] for name in before if name in after} == after
    return done.stdout


def test_a_misspelt_key(built_workflow: Workflow, change: Change) -> None:
    change("config.yaml", "settings: {lowpass: {motion: {cutof_hz: 3}}}\n")
    fault = "unknown key `settings.lowpass.motion.cutof_hz` (did you mean `cutoff_hz`?)"
    fails_with(built_workflow, fault)


# Snakemake itself writes out mappings of mappings before it reads any rule.
@pytest.mark.parametrize("kind", ["lists", "a circle"])
def test_a_study_that_expands_beyond_measure(
    built_workflow: Workflow, change: Change, kind: str
) -> None:
    change("config.yaml", BOMBS[kind])
    with time_limit(SECONDS):
        fails_with(built_workflow, "config.yaml ")


def test_a_study_of_which_no_recording_can_be_read(workflow: Workflow) -> None:
    """One has a pipe for a file, the other a letter: each has its sentence at the end, and in a
    report of nothing else.
    """
    letter, pipe = (workflow.folder / f"raw/{name}/csv_files" for name in ("pushed", "still"))
    (letter / "log_i_actual.csv").write_text("This is a letter, not a recording.\n")
    (pipe / "log_m_target.csv").unlink()
    os.mkfifo(pipe / "log_m_target.csv")
    reasons = {
        "still": "raw/still/csv_files/log_m_target.csv is a named pipe",
        "pushed": "raw/pushed/csv_files/log_i_actual.csv, line 1: expected 7 numbers (it has 2",
    }
    with time_limit(SECONDS):
        done = workflow.run("--cores", "1")
    assert done.returncode == 0, done.stdout
    [*_, end] = done.stdout.split("2 of 2 recordings cannot be read:\n")
    report = fromstring((workflow.folder / "results/small/report.html").read_text()).body
    told = plain(report.text_content())
    for name, reason in reasons.items():
        assert f"{name}: {reason}" in end
        assert f"“{name}” is left out: {reason}" in told


BROKEN = {
    "a typo": ("#let broken = fixed(", "before any job"),
    "a missing word": ("#let broken = unheard-of", "before any job"),
    "an error with rows alone": (
        '#let report() = if study.recordings != () { (:).at("missing") }',
        "write_report",
    ),
}


@pytest.mark.parametrize(("line", "failed"), BROKEN.values(), ids=BROKEN)
def test_an_error_in_a_section_is_told_with_its_place_and_leaves_the_last_report(
    workflow: Workflow, line: str, failed: str
) -> None:
    name = "ur5lib/report/page/sections/currents.typ"
    place = (workflow.folder / name).read_text().count("\n") + 1
    before = of_report(workflow)
    append(workflow.folder / name, f"{line}\n")
    told = fails_with(workflow, "the page cannot be typeset", f"{name}:{place}:")
    assert re.search(r"^ *│ +\^+$", told, re.MULTILINE)
    assert ("write_report: the page" in told) == (failed == "write_report")
    assert of_report(workflow) == before


def of_report(workflow: Workflow) -> dict[str, bytes]:
    """The files that a report consists of."""
    folder = workflow.folder / "results" / "small"
    return {path.name: path.read_bytes() for path in folder.glob("[!.]*.*")}


def test_unwritable_results(workflow: Workflow) -> None:
    shutil.rmtree(workflow.folder / "results")
    (workflow.folder / "results").write_text("a file")
    done = workflow.run()
    assert done.returncode == 1
    assert "results cannot be written to" in done.stdout
    assert "Traceback" not in done.stdout
    assert (workflow.folder / "results").read_text() == "a file"


def test_a_home_folder_that_cannot_be_written_is_not_needed(tmp_path: Path) -> None:
    workflow = Workflow(copy_project(tmp_path / "project"))
    workflow.environment |= {"HOME": "/proc/nobody"}
    workflow.environment.pop("XDG_CACHE_HOME", None)
    assert workflow.plan()


def test_a_new_step_is_one_file(workflow: Workflow) -> None:
    """It has a rule, and a table of all recordings; a field more is a line."""
    step = workflow.folder / "ur5lib" / "steps" / "measure_power.py"
    step.write_text(POWER)
    assert chain(workflow.plan()) == jobs("measure_power") | REPORT
    workflow.build("--until", "make_tables")
    power = read_csv(workflow.folder / "results" / "small" / "tables" / "power.csv")
    assert power.set_index("recording")["power_w"].between(1, 1000).all()
    step.write_text(
        POWER.replace("    motion: Motion\n", "    motion: Motion\n    forces: Forces\n")
    )
    assert "estimate_forces" in workflow.plan(
        "--until", "measure_power", "--forcerun", "fit_friction"
    )


@pytest.mark.parametrize(
    ("declares", "sentence"),
    [
        ("", "measure_power uses `motion` of a recording, which it does not declare; add it to"),
        (
            "    motion: Motion\n    power: Motion\n",
            "measure_power declares `power`, which no step writes and no study gives; see",
        ),
    ],
    ids=["less", "more"],
)
def test_a_step_that_declares_less_or_more_than_there_is_does_not_start(
    workflow: Workflow, declares: str, sentence: str
) -> None:
    step = workflow.folder / "ur5lib" / "steps" / "measure_power.py"
    step.write_text(
        POWER.replace("    motion: Motion\n", declares).replace('"power.csv"', '"mean.csv"')
    )
    done = workflow.run("--dry-run")
    assert done.returncode != 0
    assert sentence in done.stdout
    assert "Traceback" not in done.stdout


# The code of the workflow


def test_every_rule_runs_a_step_with_its_code_and_its_log() -> None:
    named = [(name, rule) for name, rule in rules() if name]
    assert {"make_tables", "write_report"} <= {name for name, _ in named}
    for name, rule in named:
        step = re.search(r'code\(\s*"(\w+)"', rule)
        assert step, name
        assert name.startswith(step[1])
        assert re.search(rf'traces\(\s*"{name}"', rule), name
        ran = "rule" if name == step[1] else f'"{step[1]}"'
        assert f"run_step({ran}, input, output, params, log)" in rule, name


def test_every_rule_of_a_loop_runs_a_step() -> None:
    """One is of declared steps; a simulated recording has its own."""
    looped = [rule for name, rule in rules() if not name]
    assert len(looped) == 2
    for rule in looped:
        assert "**traces(" in rule
        assert re.search(r"run_step\((rule|\"\w+\"), input, output, params, log\)", rule)
        assert re.search(r"code=code(_of)?\(", rule)


def test_every_step_has_a_rule() -> None:
    """Or is a part of one that has."""
    files = *PROJECT.glob("ur5lib/steps/[a-z]*.py"), *map(module_of, all_steps())
    modules = {path.stem: path for path in files}
    run = {step for _, rule in rules() for step in re.findall(r'code\(\s*"(\w+)"', rule)}
    run |= DECLARED.keys()
    parts = {used.stem for path in modules.values() for used in imported_modules(path)}
    assert run <= modules.keys() <= run | parts


def test_parsing_imports_neither_torch_nor_pandas(built_workflow: Workflow) -> None:
    """Each job of a cluster parses the workflow again."""
    heavy = "{'torch', 'pandas', 'pyarrow', 'mujoco', 'scipy'}"
    folder = built_workflow.folder  # a plugin of Snakemake's may have loaded them before
    before, after = "import sys\nbefore = {*sys.modules}\n", "{*sys.modules} - before"
    measured = f"{before}include: 'Snakefile'\nprint(bool({heavy} & ({after})))\n"
    (folder / "measured.smk").write_text(measured)
    command = built_workflow.command("--snakefile", "measured.smk", "--dry-run", "--quiet", "all")
    printed = subprocess.check_output(
        command, cwd=folder, env=built_workflow.environment, text=True
    )
    assert "\nFalse\n" in "\n" + printed
