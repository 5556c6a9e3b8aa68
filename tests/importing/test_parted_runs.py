"""Runs with a file for each quantity become one recording, joined by rows or by time."""

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import shared_folder
from tests.entries import in_words, read_and_check, read_recording
from tests.synthetic import poor_log
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.parted_runs import runs_of
from ur5lib.robots.description import Robot
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

ARM = UserStatement("ur5")
QUANTITIES = {"q": "actual_q", "qd": "actual_qd", "i": "actual_current"}


@pytest.fixture(scope="module")
def run(ur5: Robot) -> dict[str, Array]:
    log = poor_log(ur5, 12, seed=2)
    tables = {name: channel(log, its) for name, its in QUANTITIES.items()}
    return {"time": log["time"].to_numpy()} | tables


def saved(folder: Path, prefix: str = "", header: str = "", **tables: Array) -> list[Path]:
    folder.mkdir(exist_ok=True)
    for name, rows in tables.items():
        names = ",".join(f"{header}{k}" for k in range(rows.shape[1])) if header else ""
        np.savetxt(folder / f"{prefix}{name}.csv", rows, delimiter=",", header=names, comments="")
    return sorted(folder.glob(f"{prefix}*"))


def stamped(run: dict[str, Array], name: str, rows: slice = slice(None)) -> Array:
    return np.column_stack([run["time"], run[name]])[rows]


def expect_joined(paths: list[Path], run: dict[str, Array], rows: slice = slice(None)) -> None:
    """One recording with the numbers of the run; rows: those that all files tell."""
    (one,) = import_files(runs_of(paths), ARM)
    table = read_recording(one.entry).robot.table
    for name, its in QUANTITIES.items():
        np.testing.assert_allclose(channel(table, its)[rows], run[name][rows], atol=0.02)
    assert not [row for row in one.account if row.subject == "recording"]


@pytest.mark.parametrize("header", ["", "joint"])
def test_quantities_of_one_run_are_joined_by_their_rows(
    tmp_path: Path, run: dict[str, Array], header: str
) -> None:
    """As files, and as their folder; with the time in each, in a file of its own, or nowhere."""
    rows = {name: run[name] for name in QUANTITIES}
    for folder, tables in {
        "untimed": rows,
        "timed": {name: stamped(run, name) for name in rows},
        "beside": rows | {"time": run["time"][:, None]},
    }.items():
        files = saved(tmp_path / folder, header=header, **tables)
        expect_joined(files, run)
        expect_joined([tmp_path / folder], run)


def test_other_rows_are_joined_by_time(tmp_path: Path, run: dict[str, Array]) -> None:
    late = {"qd": stamped(run, "qd", slice(5, -3)), "i": stamped(run, "i", slice(None, None, 2))}
    files = saved(tmp_path / "run", q=stamped(run, "q"), **late)
    expect_joined(files, run, slice(6, -4, 2))
    (one,) = import_files(runs_of(files), ARM)
    table = read_recording(one.entry).robot.table
    assert np.isnan(channel(table, "actual_qd")[:5]).all()
    assert [row.taken_for for row in one.account if row.subject == "rows"] == ["those of q.csv"]


def test_a_state_an_input_and_a_time_are_one_run(
    tmp_path: Path, run: dict[str, Array], ur5: Robot
) -> None:
    """The last state has no input, as where an integrator wrote the files."""
    state = np.hstack([run["q"], run["qd"]])
    time = run["time"][:, None]
    files = saved(tmp_path / "run", trajectory=state, input=run["i"][:-1], time=time)
    expect_joined(files, {name: rows[:-1] for name, rows in run.items()})
    (one,) = import_files(runs_of(files), ARM)
    assert "input.csv: the last of 1,500 rows is missing" in in_words(one.account)
    found = read_and_check(one.entry, ur5, 0.1).quality.findings
    assert [f.code for f in found if f.severity != "note"] == []


def test_a_folder_of_robots_beside_the_files_hides_none(
    tmp_path: Path, run: dict[str, Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`ur5 describe` makes it where the user is."""
    saved(tmp_path, **{name: stamped(run, name) for name in QUANTITIES})
    (tmp_path / "robots").mkdir()
    monkeypatch.chdir(tmp_path)
    expect_joined([Path()], run)


def test_public_states_inputs_and_times_are_runs() -> None:
    folder = shared_folder("lwa4p-autokoopman", "its PROVENANCE.md names the source")
    both = import_files(runs_of([folder / "measurement_1", folder / "measurement_2"]))
    assert [one.entry["name"] for one in both] == ["measurement_1", "measurement_2"]
    for one in both:
        table = read_recording(one.entry).robot.table
        assert len(table) == 936
        assert np.diff(table["time"]) == pytest.approx(0.004, abs=1e-9)
        assert "in an unknown unit: Nm by habit" in in_words(
            one.account
        )  # of a torque, in no file's name


def test_other_rows_without_time_are_refused(tmp_path: Path, run: dict[str, Array]) -> None:
    files = saved(tmp_path / "run", q=run["q"], qd=run["qd"][5:])
    with pytest.raises(InputError, match=r"differ in rows \(q.csv 1500, qd.csv 1495\).*time"):
        import_files(runs_of(files), ARM)


def test_runs_of_a_folder_stay_apart(tmp_path: Path, run: dict[str, Array]) -> None:
    for prefix in ("run1_", "run2_"):
        saved(tmp_path / "runs", prefix, q=stamped(run, "q"), current=stamped(run, "i"))
    both = import_files(runs_of([tmp_path / "runs"]), ARM)
    assert [one.entry["name"] for one in both] == ["run1", "run2"]
    whole = np.hstack([stamped(run, name) for name in QUANTITIES])
    files = saved(tmp_path / "whole", q=whole, i=stamped(run, "i"))
    assert runs_of(files) == sorted(files)  # a file with more than one quantity is its own run
