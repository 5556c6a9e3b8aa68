"""What a step declares, and that it uses nothing else."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.errors import InputError
from ur5lib.jobs import code
from ur5lib.jobs.declared import Declared, declared

POWER = '''\
"""A recording's mean power."""

from collections.abc import Mapping

from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.step import step
from ur5lib.robots.description import Robot


class Inputs(AlignedRecording):
    """What is read of a recording."""

    currents: Currents


@step("arm", "power.csv loss=lost_power.csv", recordings="fit", arm="described")
def measure_power(recordings: Mapping[str, Inputs], arm: Robot, cutoff_hz: float) -> list[float]:
    """Return the mean power [W] of each recording."""
    return [mean_power(recording, arm) for recording in recordings.values()]


def mean_power(recording: Inputs, arm: Robot) -> float:
    return float((recording.torques.measured["C"] * recording.motion.qd).sum(axis=1).mean())
'''
UNDECLARED = POWER.replace("recording.motion.qd", "recording.motion.qd + recording.forces.time")


@pytest.fixture
def of_power(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The module of a step, in a library of its own."""
    monkeypatch.setattr(code, "PACKAGE", tmp_path)
    path = tmp_path / "steps" / "measure_power.py"
    path.parent.mkdir()
    path.write_text(POWER)
    declared.cache_clear()
    return path


def test_a_declaration_is_the_signature_and_what_it_does_not_say(of_power: Path) -> None:
    """The fields of a record count as parameters, and so do those of the record that it extends."""
    reads = {name: name for name in ("name", "signals", "motion", "torques", "currents")}
    reads |= {"arm": "described", "cutoff_hz": "cutoff_hz"}
    writes = {"power": "power.csv", "loss": "lost_power.csv"}
    several = frozenset(reads) - {"arm", "cutoff_hz"}
    assert declared("measure_power") == Declared(
        "measure_power", "arm", "fit", reads, several, writes
    )


def test_a_field_that_is_not_declared_is_refused(of_power: Path) -> None:
    """Before any job, and by a type checker."""
    assert declared("measure_power") is not None
    of_power.write_text(UNDECLARED)
    declared.cache_clear()
    with pytest.raises(InputError) as refused:
        declared("measure_power")
    assert str(refused.value) == (
        "measure_power uses `forces` of a recording, which it does not declare; add it to `Inputs` "
        "in measure_power.py"
    )
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-error-summary", str(of_power)],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert '"Inputs" has no attribute "forces"' in checked.stdout
    assert checked.stdout.count("error:") == 1
