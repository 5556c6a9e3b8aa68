"""What a lab wants of every recording: written from a good one, held against others."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.command import Command
from tests.conftest import PROJECT
from tests.in_memory import put_recordings
from tests.synthetic import write_recording
from ur5lib.commands.contract import contract_schema

RATE, ROWS = 125.0, 2500


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """Clock, positions and currents of a simulated arm."""
    folder = tmp_path_factory.mktemp("recorded")
    put_recordings(folder)
    recorded = pd.read_csv(folder / "free1.csv")[:ROWS]
    return recorded.filter(regex=r"^timestamp|^actual_(q|current)_\d")


def write_study(folder: Path, rows: pd.DataFrame, **entry: str) -> Path:
    rows.to_csv(folder / "run.csv", index=False)
    recording = {"name": "run", "robot": "ur5e", "format": "rtde-csv", "folder": str(folder)}
    recording |= {"file": "run.csv", "role": "fit"} | entry
    study = folder / "mine.yaml"
    study.write_text(yaml.safe_dump({"study": "mine", "title": "Mine", "recordings": [recording]}))
    return study


def broken(run_ur5: Command, study: Path) -> list[str]:
    """What a recording breaks, as its findings say."""
    done = run_ur5("check", study, "--contract", "lab.yaml", "--json")
    rows: list[dict[str, Any]] = json.loads(done.out)
    assert done.status == 1
    assert {one["recording"] for one in rows} == {"run"}
    return [one["detail"] for one in rows if one["code"] == "contract"]


def test_a_good_recording_keeps_its_own_contract(
    lab: Path, table: pd.DataFrame, run_ur5: Command
) -> None:
    study = write_study(lab, table)
    assert run_ur5("check", study, "--write-contract", "lab.yaml").status == 0
    contract = yaml.safe_load(Path("lab.yaml").read_text())
    robot = contract["devices"]["robot"]
    assert (contract["robots"], contract["recordings"]) == (["ur5e"], {"fit": 1})
    assert robot["channels"] == ["actual_q", "actual_current"]
    assert 0.85 * RATE < robot["rate_hz"] < RATE
    assert 0.85 * ROWS / RATE < contract["duration_s"] < ROWS / RATE
    assert run_ur5("check", study, "--contract", "lab.yaml").status == 0
    again = run_ur5("check", study, "--write-contract", "lab.yaml")
    assert (again.status, "exists" in again.err) == (1, True)


def test_each_breach_names_channel_found_and_wanted(
    lab: Path, table: pd.DataFrame, run_ur5: Command
) -> None:
    run_ur5("check", write_study(lab, table), "--write-contract", "lab.yaml")
    whole, holed = table, table.copy()
    holed.loc[100:599, "actual_current_2"] = np.nan
    cut = whole[(whole.index < 1000) | (whole.index > 1100)]
    faults = {
        "length: 7.992 s; wanted: 18 s at least": whole[:1000],
        "rate: 62.5 Hz; wanted: 112 Hz at least": whole[::2],
        "gap: 0.816 s; wanted: 0.1 s at most": cut,
        "actual_current: missing in 20.00% of the rows; wanted: in 1.00% at most": holed,
        "actual_current: not recorded; wanted: recorded": whole.filter(regex="time|_q_"),
    }
    five = whole.drop(columns="actual_current_5")
    assert "actual_current: not recorded; wanted: recorded" in broken(
        run_ur5, write_study(lab, five)
    )
    for fault, rows in faults.items():
        assert broken(run_ur5, write_study(lab, rows)) == [fault]
    other = write_study(lab, whole, robot="ur5")
    assert broken(run_ur5, other) == ["robot: ur5; wanted: ur5e"]
    asked = yaml.safe_load(Path("lab.yaml").read_text())
    asked["devices"]["force"] = asked["devices"]["robot"]
    Path("lab.yaml").write_text(yaml.safe_dump(asked))
    assert broken(run_ur5, write_study(lab, whole)) == ["force: no recording; wanted: one"]


def test_a_sensor_has_channels_and_a_rate_of_its_own(lab: Path, run_ur5: Command) -> None:
    write_recording(lab / "raw", seconds=2, seed=0, force_sensor=True)
    entry = "{name: run, robot: ur5, format: thesis-csv, folder: raw, role: fit}"
    study = lab / "mine.yaml"
    study.write_text(f"study: mine\ntitle: Mine\nrecordings: [{entry}]")
    assert run_ur5("check", study, "--write-contract", "lab.yaml").status == 0
    assert run_ur5("check", study, "--contract", "lab.yaml").status == 0
    contract = yaml.safe_load(Path("lab.yaml").read_text())
    assert contract["devices"]["force"]["channels"] == ["ft"]
    contract["devices"]["force"] |= {"channels": ["ft_f", "imu_a"], "rate_hz": 1e4}
    Path("lab.yaml").write_text(yaml.safe_dump(contract))
    rate, channel = broken(run_ur5, study)
    assert rate.endswith("wanted: 10000 Hz at least")
    assert channel == "imu_a: not recorded; wanted: recorded"


def test_a_study_has_recordings_of_each_role(
    lab: Path, table: pd.DataFrame, run_ur5: Command
) -> None:
    run_ur5("check", write_study(lab, table), "--write-contract", "lab.yaml")
    done = run_ur5("check", write_study(lab, table, role="validate"), "--contract", "lab.yaml")
    assert done.status == 1
    assert "recordings with the role fit: 0; wanted: 1 at least" in done.out


@pytest.mark.parametrize(
    ("text", "told"),
    [("contract: lab", "devices"), ("contract: lab\ndevices: {robto: {}}", "robto"),
     ("contract: lab\ndevices: {}\nduration: 3", "duration_s"), ("[", "YAML"),
     ("contract: lab\ndevices: {robot: {rate_hz: -1, gap_s: 1, channels: []}}", "rate_hz")],
)  # fmt: skip
def test_a_wrong_contract_is_told_in_a_sentence(
    text: str, told: str, lab: Path, table: pd.DataFrame, run_ur5: Command
) -> None:
    study = write_study(lab, table)
    Path("lab.yaml").write_text(text)
    done = run_ur5("check", study, "--contract", "lab.yaml")
    assert done.status == 1
    assert "lab.yaml" in done.err
    assert told in done.err


def test_the_committed_schema_is_the_contracts() -> None:
    committed = PROJECT / "workflow" / "contract.schema.json"
    assert committed.read_text() == contract_schema(), "run `make schema`"
