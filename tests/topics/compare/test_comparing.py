"""`ur5 compare`: what changed by more than its error, and nothing else."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from ur5lib.cli import app
from ur5lib.errors import InputError
from ur5lib.topics.compare.comparison import (
    CHANGE_COLUMNS,
    TOPICS,
    compare,
    lines,
    rows,
    write_junit,
)

STD = 0.5
PARAMETERS = ["torque_constant", "offset", "coulomb", "viscous", "load"]


def results(folder: Path, seed: int = 0, coulomb_3: float = 0.0, error: float = 1.0) -> Path:
    """Tables of a study; seed: of the parameters' errors, 0 for none; others: what changes."""
    (folder / "tables").mkdir(parents=True)
    random = np.random.default_rng(seed)

    def write(name: str, rows: pd.DataFrame) -> None:
        rows.to_csv(folder / "tables" / f"{name}.csv", index=False)

    rows = pd.DataFrame(
        [{"robot": "ur5", "joint": j, "parameter": p} for j in range(1, 7) for p in PARAMETERS]
    )
    value = 10 + (STD * random.normal(size=len(rows)) if seed else 0.0)
    changed = (rows["joint"] == 3) & (rows["parameter"] == "coulomb")
    value = value + coulomb_3 * changed
    bounds = {"low": value - 1.96 * STD, "high": value + 1.96 * STD}
    write("friction", rows.assign(value=value, std_error=STD, determined="yes", **bounds))
    names = [f"beta_{k}" for k in range(20)]
    base = pd.DataFrame({"robot": "ur5", "parameter": names, "determined": "yes"})
    write("parameters", base.assign(value=random.normal(size=20) if seed else 0.0, std_error=1.0))
    joints = pd.DataFrame({"robot": "ur5", "joint": range(1, 7), "value": 1.6, "std_error": 0.01})
    write("rotor_inertia", joints)
    load = {"recording": ["run"], "mass": [2.7], "std_error": [0.1]}
    write("payload", pd.DataFrame(load))
    current = {
        "model": "fitted",
        "recording": "run",
        "joint": range(1, 7),
        "rmse_lowpassed": 0.1 * error,
    }
    write("current_rmse", pd.DataFrame(current))
    force = {"recording": "run", "kind": "compensated", "estimate": "Fmap", "during": "contact"}
    axes = {"component": ["Fx", "Fy", "Fz"], "mae": 3.0, "mae_low": 2.5, "mae_high": 3.5}
    write("force_mae", pd.DataFrame(force | axes))
    finding = {"recording": ["run"], "device": ["robot"], "finding": ["lost frames"]}
    count = {"severity": ["warning"], "count": [86 * int(error)]}
    write("quality", pd.DataFrame(finding | count))
    write("recordings", pd.DataFrame({"recording": ["run"]}))
    return folder


def changed(before: Path, after: Path) -> list[str]:
    return [one.name for one in compare(before, after) if one.changed]


def test_a_study_is_equal_to_itself(tmp_path: Path) -> None:
    one = results(tmp_path / "a", seed=1)
    found = compare(one, one)
    assert {one.topic for one in found} == set(TOPICS)
    assert not any(one.differs or one.changed for one in found)


def test_noise_alone_changes_nothing(tmp_path: Path) -> None:
    """Of the single comparisons, one in twenty lies beyond its error, as it should."""
    differ, changes, compared = 0, 0, 0
    for seed in range(1, 41, 2):
        pair = tuple(results(tmp_path / str(seed + k), seed=seed + k) for k in range(2))
        found = [one for topic in ("friction", "model") for one in TOPICS[topic](pair)]
        differ += sum(one.differs for one in found)
        changes += len([one for one in found if one.changed])
        compared += len(found) - 6  # rotors without noise
    assert differ / compared == pytest.approx(0.05, abs=0.02)
    assert changes <= 4  # 5 % in each of 2 topics in 20 pairs: 2 are expected


def test_what_was_raised_is_named_and_nothing_else(tmp_path: Path) -> None:
    before = results(tmp_path / "a", seed=1)
    after = results(tmp_path / "b", seed=2, coulomb_3=6 * STD)
    assert changed(before, after) == ["ur5, joint 3, coulomb"]


def test_larger_errors_and_new_findings_are_named(tmp_path: Path) -> None:
    before, after = results(tmp_path / "a"), results(tmp_path / "b", error=2.0)
    names = changed(before, after)
    assert names[0] == "run, robot: lost frames"
    assert names[1:] == [f"run, joint {joint}" for joint in range(1, 7)]
    texts = [*lines(compare(before, after))]
    assert "  run, robot: lost frames: 86 before, 172 now" in texts
    assert "  run, joint 1: 0.1 A before, 0.2 A now" in texts


def test_findings_of_recordings_that_one_study_has_alone_are_not_compared(tmp_path: Path) -> None:
    before, after = results(tmp_path / "a"), results(tmp_path / "b")
    for name in ("quality", "recordings"):
        table = after / "tables" / f"{name}.csv"
        table.write_text(table.read_text().replace("run", "other"))
    assert not [one for one in compare(before, after) if one.topic == "data"]


def test_results_before_an_update_are_compared_with_those_after(tmp_path: Path) -> None:
    before, after = results(tmp_path / "a"), results(tmp_path / "b", error=2)
    table = before / "tables" / "current_rmse.csv"
    table.write_text(table.read_text().replace("rmse_lowpassed", "rmse_2hz"))
    assert len([name for name in changed(before, after) if "joint" in name]) == 6


@pytest.mark.parametrize(
    ("stated", "damaged", "reason"),
    [
        ("std_error", "error", "it has no column std_error"),
        ("parameter,", "name,", "it has no column parameter"),
        ("yes", "maybe", "determined is neither yes nor no"),
        ("1.0", "one", "could not convert string to float"),
    ],
)
def test_a_damaged_table_is_named_before_anything_is_printed(
    tmp_path: Path, stated: str, damaged: str, reason: str
) -> None:
    folders = results(tmp_path / "a"), results(tmp_path / "b")
    table = folders[1] / "tables" / "parameters.csv"
    table.write_text(table.read_text().replace(stated, damaged))
    done = CliRunner().invoke(app, ["compare", *map(str, folders)])
    assert isinstance(done.exception, InputError)
    assert f"{table} is damaged ({reason}" in str(done.exception)
    assert done.stdout == ""


@pytest.mark.parametrize(("topics", "status"), [("currents,force", 1), ("force", 0), ("", 0)])
def test_the_exit_status_is_that_of_the_topics_asked_for(
    tmp_path: Path, topics: str, status: int
) -> None:
    folders = results(tmp_path / "a"), results(tmp_path / "b", error=2.0)
    command = ["compare", *map(str, folders), "--fail-on", topics]
    assert CliRunner().invoke(app, command).exit_code == status


def test_an_unknown_topic_is_refused(tmp_path: Path) -> None:
    one = str(results(tmp_path / "a"))
    done = CliRunner().invoke(app, ["compare", one, one, "--fail-on", "tea"])
    assert "unknown topic 'tea'; available: data, model" in str(done.exception)


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="b has no table 'quality'; `ur5 run` its study"):
        compare(results(tmp_path / "a"), tmp_path / "b")


@pytest.mark.parametrize(("empty", "compared"), [("*", 0), ("parameters", 47)])
def test_tables_without_rows_have_nothing_to_compare(
    tmp_path: Path, empty: str, compared: int
) -> None:
    """Nor do they hinder the tables beside them, as without base parameters those of rotors."""
    folders = results(tmp_path / "a"), results(tmp_path / "b")
    for path in (path for f in folders for path in (f / "tables").glob(f"{empty}.csv")):
        path.write_text(path.read_text().partition("\n")[0] + "\n")
    assert len(compare(*folders)) == compared


def test_a_row_of_the_report_says_what_the_command_says(tmp_path: Path) -> None:
    found = compare(results(tmp_path / "a"), results(tmp_path / "b", error=2.0))
    reported = [*rows("monday", found)]
    assert [*reported[0]] == CHANGE_COLUMNS
    assert [row["name"] for row in reported if row["changed"] == "yes"] == [
        one.name for one in found if one.changed
    ]


def test_results_that_are_not_whole_are_refused(tmp_path: Path) -> None:
    whole, other = results(tmp_path / "a"), results(tmp_path / "b")
    (other / "tables" / "payload.csv").unlink()
    with pytest.raises(InputError, match=r"no table 'payload'.*ur5 run"):
        compare(whole, other)


def test_junit_counts_what_changed(tmp_path: Path) -> None:
    found = compare(results(tmp_path / "a"), results(tmp_path / "b", error=2.0))
    write_junit(found, tmp_path / "junit.xml")
    suites = {
        suite.get("name"): suite for suite in ElementTree.parse(tmp_path / "junit.xml").getroot()
    }
    assert {name: suite.get("failures") for name, suite in suites.items()} == {
        "data": "1", "model": "0", "friction": "0", "payload": "0", "currents": "6", "force": "0",
    }  # fmt: skip
    told = [line.strip() for line in lines(found)]
    assert suites["currents"][0][0].get("message") in told
