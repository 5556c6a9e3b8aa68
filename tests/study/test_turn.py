"""One run of a study at a time, and one writer of a file."""

import fcntl
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ur5lib.errors import InputError
from ur5lib.study.turn import LOCK_FILE, TURN_VARIABLE, reserved, running, share_turn, take_turn

HOLD = "import sys, time; from pathlib import Path; from ur5lib.study.turn import take_turn; "
HOLD += "held = take_turn(Path(sys.argv[1])); print('held', flush=True); time.sleep(60)"


def holding(code: str, path: Path) -> subprocess.Popen[str]:
    """A process that has a lock."""
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_second_run_names_the_first_which_is_not_disturbed(tmp_path: Path) -> None:
    first = holding(HOLD, tmp_path)
    for _ in range(2):
        with pytest.raises(InputError, match=rf"process {first.pid} of .* since 20\d\d-"):
            take_turn(tmp_path)
    first.kill()
    first.wait()
    with take_turn(tmp_path):
        assert running(tmp_path).startswith(f"process {os.getpid()} of ")


def test_who_waits_comes_next(tmp_path: Path) -> None:
    first = take_turn(tmp_path)
    waiting = "from pathlib import Path; from ur5lib.study.turn import take_turn; "
    waiting += f"take_turn(Path({str(tmp_path)!r}), wait=True); print('mine')"
    second = subprocess.Popen(
        [sys.executable, "-c", waiting], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert second.stderr is not None
    assert f"being made by process {os.getpid()} of " in second.stderr.readline()
    with pytest.raises(subprocess.TimeoutExpired):
        second.wait(0.5)
    first.close()
    assert second.communicate(timeout=30)[0] == "mine\n"


@pytest.mark.parametrize("end", ["", "raise RuntimeError", "sys.exit(1)"])
def test_a_run_leaves_nobodys_name_behind(tmp_path: Path, end: str) -> None:
    ended = HOLD.replace("time.sleep(60)", end)
    subprocess.run([sys.executable, "-c", ended, str(tmp_path)], capture_output=True)
    assert [*tmp_path.iterdir()] == []


def test_a_run_leaves_the_name_that_its_jobs_share(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(TURN_VARIABLE, raising=False)
    ended = HOLD.replace("time.sleep(60)", "sys.stdin.read()")
    run = subprocess.Popen(
        [sys.executable, "-c", ended, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert run.stdout is not None
    assert run.stdout.readline() == "held\n"
    job = share_turn(tmp_path)
    run.communicate()
    with pytest.raises(InputError, match=f"being made by process {run.pid}"):
        take_turn(tmp_path)
    job.close()
    (tmp_path / LOCK_FILE).unlink()
    with pytest.raises(InputError, match="has ended"):  # a job that begins after its run
        share_turn(tmp_path)
    assert [*tmp_path.iterdir()] == []


def with_pipes(code: str, folder: Path) -> subprocess.Popen[str]:
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    return subprocess.Popen([sys.executable, "-c", code, str(folder)], text=True, **pipes)


def test_who_waited_for_a_removed_file_still_keeps_others_out(tmp_path: Path) -> None:
    held = HOLD.replace("time.sleep(60)", "sys.stdin.read()")
    second = held.replace("sys.argv[1])", "sys.argv[1]), wait=True")
    first = with_pipes(held, tmp_path)
    assert first.stdout is not None
    assert first.stdout.readline() == "held\n"
    waiting = with_pipes(second, tmp_path)
    assert waiting.stdout is not None
    assert waiting.stderr is not None
    assert "waiting until" in waiting.stderr.readline()
    first.communicate()
    assert waiting.stdout.readline() == "held\n"
    with pytest.raises(InputError, match=f"being made by process {waiting.pid}"):
        take_turn(tmp_path)
    waiting.communicate()
    assert [*tmp_path.iterdir()] == []


def test_jobs_of_a_killed_run_keep_others_out_unless_they_begin_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, job = take_turn(tmp_path), share_turn(tmp_path)
    first.close()
    with pytest.raises(InputError, match=f"being made by process {os.getpid()}"):
        take_turn(tmp_path)
    job.close()
    second = take_turn(tmp_path)
    share_turn(tmp_path).close()
    monkeypatch.setenv(TURN_VARIABLE, "process 1 of somebody, killed before this job began")
    with pytest.raises(InputError, match="the run that submitted this job has ended"):
        share_turn(tmp_path)
    second.close()


RESERVED = "import sys, time; from pathlib import Path; from ur5lib.study.turn import reserved\n"
RESERVED += "with reserved(Path(sys.argv[1])): print('held', flush=True); time.sleep(60)"


def test_a_name_is_of_one_process_until_that_ends_or_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "new" / "arm.xml"
    first = holding(RESERVED, path)
    for _ in range(2):
        with pytest.raises(InputError, match=r"another process is writing .*arm\.xml; wait"):
            reserved(path).__enter__()
    with reserved(path.with_name("other.xml")):  # not of another file
        pass
    first.kill()
    first.wait()
    assert [one.name for one in path.parent.iterdir()] == [".arm.xml.lock"]
    with reserved(path):
        path.write_text("mine")
    assert [*path.parent.iterdir()] == [path]


def test_a_name_whose_owner_ends_while_another_opens_its_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The removed lock is no lock: a third would make its own, and two have the name."""
    path, plain, first = tmp_path / "arm.xml", fcntl.flock, reserved(tmp_path / "arm.xml")
    first.__enter__()

    def late(*asked: Any) -> None:
        monkeypatch.setattr("fcntl.flock", plain)
        first.__exit__(None, None, None)
        plain(*asked)

    monkeypatch.setattr("fcntl.flock", late)
    with reserved(path), pytest.raises(InputError, match="another process is writing"):
        reserved(path).__enter__()


def test_a_name_where_nothing_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"):
        reserved(tmp_path / "file" / "arm.xml").__enter__()
