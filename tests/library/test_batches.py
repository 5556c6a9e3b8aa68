"""Many recordings as few jobs: what waits for what, and which steps run again."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from ur5lib.jobs.job import Job, Names

NAMES = ["a", "b", "c.1"]


def of_recording(name: str, **input: object) -> Step:
    output = {"made": f"r/recordings/{{recording}}/{name}"}
    log = {"log": f"r/logs/{name}/{{recording}}.log"}
    log["benchmark"] = f"r/benchmarks/{name}/{{recording}}.tsv"
    return Step(name, "recording", frozenset(NAMES), input, output, {"code": name}, log)


@pytest.fixture
def batches() -> Batches:
    """Steps: read, smooth; fit to an arm; predict, which needs the fit; compare with all others."""

    def smoothed(wildcards: SimpleNamespace) -> list[str]:
        return [f"r/recordings/{name}/smooth" for name in NAMES]

    def predicted(wildcards: SimpleNamespace) -> list[str]:
        return [f"r/recordings/{name}/predict" for name in NAMES]

    result = "r/recordings/{recording}/"
    steps = [
        of_recording("compare", others=predicted),
        of_recording("predict", motion=result + "smooth", fit="r/parameters/ur5/fit"),
        of_recording("smooth", frames=result + "read"),
        of_recording("read", raw="raw/{recording}"),
    ]
    output = {"fit": "r/parameters/{robot}/fit"}
    fit = Step("fit", "robot", frozenset(["ur5"]), {"motion": smoothed}, output, {}, {})
    return Batches("r", {step.name: step for step in steps}, {"fit": fit}, NAMES, NAMES)


def test_a_level_ends_where_recordings_wait_for_others(batches: Batches) -> None:
    levels = [[step.name for step in level] for level in batches.levels]
    assert levels == [["read", "smooth"], ["predict"], ["compare"]]


def test_a_batch_needs_raw_files_or_stamps(batches: Batches) -> None:
    of = batches.batch_of
    batch, others = of["a"], [batches.stamp(1, of[name]) for name in NAMES]
    raw = [f"raw/{name}" for name in batches.batches[batch]]
    assert batches.needs(0, batch) == raw
    assert batches.needs(1, batch) == [batches.stamp(0, batch), "r/parameters/ur5/fit"]
    assert batches.needs(2, batch) == [*dict.fromkeys([batches.stamp(1, batch), *others])]
    log = "r/benchmarks/smooth/c.1.tsv"
    assert batches.stamped([log, "raw/a"]) == [batches.stamp(0, of["c.1"]), "raw/a"]


@pytest.mark.parametrize("count", [3, 150, 2443])
def test_another_recording_changes_the_batches_around_it_alone(count: int) -> None:
    names = [f"run {k}" for k in range(count)]
    before = divided(names)
    assert [name for batch in before.values() for name in batch] == names
    assert len(before) <= 2 * NUMBER
    for place in range(0, count + 1, max(1, count // 10)):
        after = divided([*names[:place], "new", *names[place:]])
        assert sum(after.get(key) != batch for key, batch in before.items()) <= 3


def test_a_batch_with_a_missing_file_is_forgotten(
    batches: Batches, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    batch = batches.batch_of["a"]
    stamp, older = Path(batches.stamp(0, batch)), Path(batches.stamp(0, "of others"))
    for file in [*batches.files("output", 0, batch), str(stamp), str(older)]:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).touch()
    batches.forget_incomplete()
    assert stamp.exists()
    assert not older.exists()
    Path("r/recordings/a/smooth").unlink()
    batches.forget_incomplete()
    assert not stamp.exists()


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Job:
    monkeypatch.chdir(tmp_path)
    Path("raw").write_text("1")
    files = Names(raw=["raw"]), Names(made="made")
    return Job("copy", *files, Names(code="1"), "copy.log", "copy.tsv")


def copy(job: Job) -> None:
    Path(job.output.made).write_text(Path(job.input.raw[0]).read_text() + job.params.code)
    Path(job.log).touch()
    Path(job.benchmark).touch()


@pytest.mark.parametrize(
    ("file", "text", "again"), [("raw", "1", False), ("raw", "2", True), ("made", "?", True)]
)
def test_a_step_runs_again_if_what_it_depends_on_has_changed(
    job: Job, file: str, text: str, again: bool
) -> None:
    """To write a file anew with the same content changes nothing."""
    ran, written = run_if_changed(job, copy)
    assert ran
    assert run_if_changed(job, copy) == (False, written)
    Path(file).unlink()
    Path(file).write_text(text)
    assert run_if_changed(job, copy)[0] == again
    assert not run_if_changed(job, copy)[0]
    job.params["code"] = "2"
    assert run_if_changed(job, copy)[0]
    Path("made").unlink()
    assert run_if_changed(job, copy)[0]


def failing(job: Job) -> None:
    raise RuntimeError


def test_a_step_that_failed_runs_again(job: Job) -> None:
    run_if_changed(job, copy)
    job.params["code"] = "2"
    with pytest.raises(RuntimeError):
        run_if_changed(job, failing)
    job.params["code"] = "1"
    assert run_if_changed(job, copy)[0]


def test_a_step_whose_files_were_deleted_is_restored_if_nothing_else_changed(job: Job) -> None:
    run_or_restore(job, copy)
    Path("made").unlink()
    run_or_restore(job, failing)
    assert Path("made").read_text() == "11"
    Path("raw").write_text("2")
    run_or_restore(job, copy)
    assert Path("made").read_text() == "21"


def test_what_was_left_out_is_dropped_from_files_and_settings(job: Job) -> None:
    files = [f"results/s/recordings/{name}/made" for name in NAMES]
    job.input = Names(motion=files, fit="results/s/parameters/b/fit", raw=["logs/b.csv"])
    job.params = Names(recordings=NAMES, dates=[1, 2, 3], terms=["b"], code="b")
    found = without(job, {"b": "b: empty"})
    assert found.input == job.input | {"motion": [files[0], files[2]]}
    assert found.params == job.params | {"recordings": ["a", "c.1"], "dates": [1, 3]}
    assert without(job, {}) == job


def test_stamps_say_what_was_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    stamps = [f"results/s/batches/0/{k}.json" for k in (0, 1)]
    Path(stamps[0]).parent.mkdir(parents=True)
    for stamp, absent in zip(stamps, ({}, {"b": "b: empty"}), strict=True):
        write_stamp(stamp, "12", absent)
    assert left_out([*stamps, "results/s/parameters/ur5/arm.yaml"]) == {"b": "b: empty"}
