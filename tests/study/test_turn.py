"""One run of a study at a time."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ur5lib.errors import InputError
from ur5lib.study.turn import TURN_VARIABLE, share_turn, take_turn

HOLD = "import sys, time; from pathlib import Path; from ur5lib.study.turn import take_turn; "
HOLD += "held = take_turn(Path(sys.argv[1])); print('held', flush=True); time.sleep(60)"


def test_a_second_run_names_the_first_which_is_not_disturbed(tmp_path: Path) -> None:
    first = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert first.stdout is not None
    assert first.stdout.readline() == "held\n"
    for _ in range(2):
        with pytest.raises(InputError, match=rf"process {first.pid} of .* since 20\d\d-"):
            take_turn(tmp_path)
    first.kill()
    first.wait()
    assert take_turn(tmp_path)


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
