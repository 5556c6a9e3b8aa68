"""Which recordings of a study a step runs for: of few all, of many some."""

from pathlib import Path
from typing import Any

import pytest

from ur5lib.study.reading import parse_study
from ur5lib.study.selection import (
    MAX_DRAWN,
    MAX_EXAMINED_WHOLE,
    MAX_ILLUSTRATED,
    OF_THE_STUDY,
    Selection,
)

ROLES = ("fit", "validate", "contact", "validate", "contact")  # in turn
MANY = 3 * MAX_EXAMINED_WHOLE


def entries(folder: Path, count: int) -> list[dict[str, Any]]:
    """Recordings of two arms."""
    return [
        {
            "name": f"run_{k}",
            "robot": ("ur5", "ur10e")[k % 2],
            "format": "thesis-csv",
            "role": ROLES[k % len(ROLES)],
            "folder": str(folder / f"run_{k}"),
        }
        for k in range(count)
    ]


def of(recordings: list[dict[str, Any]]) -> Selection:
    for one in recordings:
        if "simulate" not in one:
            Path(one["folder"]).mkdir(exist_ok=True)
    study = {"study": "made", "title": "Made", "recordings": recordings}
    return Selection(parse_study(study, "made.yaml"))


def test_of_few_recordings_all_are_drawn_and_examined(tmp_path: Path) -> None:
    few = of(entries(tmp_path, MAX_EXAMINED_WHOLE))
    assert few.examined == few.recordings.keys() == few.entries.keys()
    for robot in ("ur5", "ur10e"):
        assert few.drawn(robot) == few.of_arm(robot, "fit", "validate")
        assert {few.arm(name) for name in few.drawn(robot)} == {robot}


def test_of_many_some_are_drawn_by_their_names(tmp_path: Path) -> None:
    """Another recording changes at most one of them, wherever it stands."""
    given = entries(tmp_path, MANY)
    many = of(given)
    drawn = many.drawn("ur5")
    contact_free = many.of_arm("ur5", "fit", "validate")
    assert len(drawn) == MAX_DRAWN < len(contact_free)
    assert drawn == [name for name in contact_free if name in drawn]  # in the study's order
    assert of(given[::-1]).drawn("ur5") == drawn[::-1]
    for name in ("a", "new", "zz"):
        new = {"name": name, "folder": str(tmp_path / name)}
        more = of([given[0] | new, *given]).drawn("ur5")
        assert len({*more} - {*drawn}) <= 1


def test_of_many_those_are_examined_that_are_drawn_shown_or_fitted(tmp_path: Path) -> None:
    given = entries(tmp_path, MANY)
    many = of(given)
    expected = {*many.drawn("ur5"), *many.drawn("ur10e"), *many.illustrated}
    expected |= {entry["name"] for entry in given if entry["role"] == "fit"}
    assert many.examined == expected
    assert many.examined < many.recordings.keys()


@pytest.mark.parametrize("count", [2, 30, MANY])
def test_a_few_of_each_role_are_illustrated(tmp_path: Path, count: int) -> None:
    """With a force sensor before without, and the first, in the order of the study."""
    given = entries(tmp_path, count)
    touched = [one for one in given if one["role"] == "contact"]
    for one in touched[-2:]:
        (tmp_path / one["name"]).mkdir()
        (tmp_path / one["name"] / "log_force_sensor.csv").touch()
    shown = of(given).illustrated
    roles = [one["role"] for one in given if one["name"] in shown]
    assert shown == [one["name"] for one in given if one["name"] in shown]
    assert shown[0] == "run_0"
    for role in ("contact", "validate"):
        among = [one["name"] for one in given if one["role"] == role]
        assert roles.count(role) == min(MAX_ILLUSTRATED, len(among))
    assert {one["name"] for one in touched[-2:]} <= {*shown}


def test_postures_at_rest_are_no_recordings_in_motion(tmp_path: Path) -> None:
    names = [f"{name}_{j}" for name in ("actual_q", "actual_current") for j in range(6)]
    at_rest = {"name": "rest", "format": "table-csv", "folder": str(tmp_path), "file": "rest.csv"}
    at_rest |= {"columns": names, "still": True}
    given = entries(tmp_path, 2)
    found = of([*given, given[0] | at_rest])
    assert found.at_rest == ["rest"]
    assert [*found.recordings] == ["run_0", "run_1"]
    assert found.of_arm("ur5", "fit") == ["run_0"]
    assert found.of_arm("ur5", "fit", at_rest=True) == ["rest"]


def test_a_truth_is_that_of_the_stand_or_a_file_of_the_recording(tmp_path: Path) -> None:
    given = entries(tmp_path, 3)
    plan = {"trajectory": {"kind": "fourier", "period_s": 10}, "seconds": 10}
    del given[0]["folder"]
    given[0]["simulate"] = plan
    given[1] |= {"format": "rtde-csv", "file": "a.csv", "truth": "known"}
    Path(given[1]["folder"]).mkdir()
    for suffix in (".parquet", ".json"):
        Path(given[1]["folder"], f"known{suffix}").touch()
    found = of(given)
    assert found.simulated == ["run_0"]
    known = {"run_0": "results/made/truth/run_0", "run_1": f"{tmp_path}/run_1/known"}
    assert found.truths("results/made") == known
    assert all(not Path(path).exists() for path in found.raw_files("run_0"))  # but will be made


def test_a_reader_is_given_nothing_of_the_use_in_the_study(tmp_path: Path) -> None:
    """So that a recording is not read again when its role changes, nor its tool."""
    given = entries(tmp_path, 1)
    used = {"role": "contact", "date": "2026-03-09", "payload": {"mass": 1.0}}
    used |= {"gravity": [0, 0, 9.81], "untouched": [0, 1]}
    one, other = of(given), of([given[0] | used])
    assert one.entry_to_read("run_0") == other.entry_to_read("run_0")
    assert not one.entry_to_read("run_0").keys() & {*OF_THE_STUDY}
    assert (one.gravity("run_0"), other.gravity("run_0")) == (None, [0, 0, 9.81])
    assert other.gravities(["run_0"]) == {"run_0": [0, 0, 9.81]}
    assert (one.date("run_0"), other.date("run_0")) == ("", "2026-03-09")
    assert one.payload("run_0") is None
    payload = other.payload("run_0")
    assert payload is not None
    assert payload["mass"] == 1.0
    assert one.sensor_mounting("run_0") == [None, None]
