"""A study on a Slurm cluster: the same results, also if a job is killed; nothing is left."""

import contextlib
import re
import shlex
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
import yte

from tests.conftest import PROJECT, STUDY, Workflow
from tests.one_node_slurm import NoSlurmError, ask, one_node_slurm
from tests.workflow.test_workflow import DECLARED, results, rules
from ur5lib.errors import InputError
from ur5lib.study.turn import take_turn

pytestmark = pytest.mark.slow

PROFILE = ("--workflow-profile", "profiles/slurm")
SMALL = ("--cores", "2", "--latency-wait", "5")  # the profile is for more cores and a slow disk
# two short recordings a job
TOGETHER = ("--group-components", "motion=2", "forces=2", "judgement=2")
GIVEN = yte.process_yaml((PROJECT / "profiles" / "slurm" / "config.yaml").read_text())


needs_plugin = pytest.mark.skipif(
    find_spec("snakemake_executor_plugin_slurm") is None,
    reason="Snakemake's plugin for Slurm is not installed: `pip install '.[slurm]'`",
)


@pytest.fixture
def slurm() -> Iterator[dict[str, str]]:
    try:
        with one_node_slurm() as environment:
            yield environment
    except NoSlurmError as error:
        pytest.skip(str(error))


def processes_in(folder: Path) -> list[str]:
    """Return the command lines of all processes that work in a folder, or are configured there."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended
            command = (process / "cmdline").read_text().replace("\0", " ")
            places = f"{(process / 'cwd').resolve()} {(process / 'environ').read_text()} {command}"
            if str(folder) in places:
                found.append(command)
    return found


def wait_until(happens: Callable[[], object], seconds: float) -> bool:
    """Whether something happens within so many seconds."""
    ends = time.monotonic() + seconds
    while not happens():
        if time.monotonic() > ends:
            return False
        time.sleep(0.1)
    return True


@pytest.mark.thorough
@needs_plugin
def test_a_killed_job_is_submitted_again_to_the_same_results(
    workflow: Workflow, slurm: dict[str, str]
) -> None:
    before = results(workflow)
    folder = workflow.folder / "results" / "small"
    shutil.rmtree(folder)
    run = subprocess.Popen(
        workflow.command(*PROFILE, *SMALL, *TOGETHER),
        cwd=workflow.folder,
        env=workflow.environment | slurm,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    try:
        assert wait_until(lambda: [*folder.rglob("robot.parquet")] or run.poll(), 200)
        running = ask(slurm, "squeue", "--noheader", "--states=RUNNING", "--format=%i").split()
        ask(slurm, "scancel", running[0])
        printed, _ = run.communicate(timeout=300)
    finally:
        run.kill()
    assert run.returncode == 0, printed
    assert results(workflow) == before
    assert workflow.plan() == {}
    ended = ask(slurm, "squeue", "--noheader", "--states=all", "--format=%i %T").splitlines()
    killed = [line.split()[0] for line in ended if not line.endswith(" COMPLETED")]
    assert killed == running[:1], ended
    assert len(ended) == 8, "two to read, one of each other group, one again"
    assert wait_until(lambda: not processes_in(workflow.folder), 10), "something goes on"


@pytest.mark.thorough
def test_a_study_as_one_job_is_started_again_to_the_same_results(
    workflow: Workflow, slurm: dict[str, str]
) -> None:
    """By the command in the documents; the second start meets the first, which is still ending."""
    before = results(workflow)
    folder = workflow.folder / "results" / "small"
    shutil.rmtree(folder)
    environment = workflow.environment | slurm
    documents = (PROJECT / "docs" / "clusters.md").read_text()
    _, *options = shlex.split(re.search("sbatch --wait .*", documents)[0].replace("--wait ", ""))
    job = ask(environment, "sbatch", "--parsable", f"--chdir={workflow.folder}", *options)
    try:
        assert wait_until(lambda: [*folder.rglob("robot.parquet")], 200)
        ask(environment, "scontrol", "requeue", job)
        assert wait_until(lambda: "JobState=COMPLETED" in known_of(job, environment), 300)
    finally:
        ask(environment, "scancel", job)
    assert "Restarts=1 " in known_of(job, environment)
    assert results(workflow) == before
    assert wait_until(lambda: not processes_in(workflow.folder), 10), "something goes on"


def known_of(job: str, environment: dict[str, str]) -> str:
    return ask(environment, "scontrol", "show", "job", job)


@pytest.mark.thorough
@needs_plugin
def test_jobs_of_a_killed_run_keep_a_second_one_waiting(
    workflow: Workflow, slurm: dict[str, str]
) -> None:
    """As far as the smoothed motion, which waits for the files to be read."""
    before = results(workflow)
    folder = workflow.folder / "results" / "small"
    shutil.rmtree(folder)
    workflow.environment |= slurm
    given = *PROFILE, *SMALL, *("--until", "align_recording")
    first = subprocess.Popen(
        workflow.command(*given),
        cwd=workflow.folder,
        env=workflow.environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert wait_until(lambda: [*folder.rglob("robot.parquet")] or first.poll(), 200)
    finally:
        first.kill()
        first.wait()
    with pytest.raises(InputError, match=f"being made by process {first.pid} of "):
        take_turn(folder)
    second = workflow.run(*given, "--config", "wait=true")
    assert second.returncode == 0, second.stdout
    after = results(workflow)
    made = [name for name in before if name in after]
    assert {"recordings/still/motion.parquet", "recordings/pushed/motion.parquet"} <= {*made}
    assert [name for name in made if after[name] != before[name]] == []


# The profile, where no cluster is at hand

PUBLISHED = "reference: workflow/studies/thesis_reference.yaml\n"


@pytest.mark.parametrize("more", ["", "hosts: {pc: [imu]}\n", PUBLISHED])
def test_the_groups_of_a_study_do_not_wait_for_each_other(workflow: Workflow, more: str) -> None:
    (workflow.folder / "config.yaml").write_text(STUDY + more)
    planned = workflow.plan("--forceall", "--groups", *map("=".join, GIVEN["groups"].items()))
    assert {"pool_drifts", "align_recording", "judge_recording"} <= planned.keys()


def test_every_rule_but_the_shortest_is_in_a_group() -> None:
    groups = GIVEN["groups"]
    named = {*DECLARED, *(name for name, _ in rules() if name)}
    assert named - groups.keys() == {"describe_arm", "pool_drifts", "set_threshold", "write_run"}
    assert groups.keys() <= named
    assert GIVEN["group-components"].keys() <= {*groups.values()}
