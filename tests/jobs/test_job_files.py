"""A step's files by the types of its signature: what it is given, and what it leaves."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from tests.made_records import same, stretch
from ur5lib.errors import InputError
from ur5lib.jobs.files import arguments, write
from ur5lib.records.opened import Opened
from ur5lib.records.table import SegmentedTable
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Payload, Robot, robot_path
from ur5lib.tables import (
    read_csv,
    read_json,
    read_record,
    read_table,
    write_csv,
    write_json,
    write_table,
)
from ur5lib.timeseries.lowpass import Butterworth


@dataclass(frozen=True)
class Load:
    mass: float
    parts: list[float]


LOAD, FRAME = Load(2.0, [1.0, np.nan]), pd.DataFrame({"time": [0.0, 0.008]})


def table(name: str = "") -> SegmentedTable:
    return SegmentedTable(**stretch(np.arange(3.0) + len(name)))


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """Results of recordings a and b, and of an arm."""
    for name in "ab":
        table(name).write(tmp_path / name / "table.parquet")
        write_json(Load(ord(name), []), tmp_path / name / "load.json")
    write_json(LOAD, tmp_path / "load.json")
    write_json({"own": LOAD}, tmp_path / "loads.json")
    write_table(FRAME, tmp_path / "frame.parquet")
    write_csv(FRAME, tmp_path / "frame.csv")
    return tmp_path


# What a step is given


def test_each_file_is_read_by_the_type_of_its_parameter(files: Path) -> None:
    def step(
        arm: Robot,
        table: SegmentedTable,
        load: Load,
        loads: dict[str, Load],
        samples: pd.DataFrame,
        rows: pd.DataFrame,
        file: Path,
        parts: list[Path],
    ) -> None: ...

    names = ("frame.parquet", "frame.csv", "load.json")
    given = arguments(
        step,
        {
            "arm": str(robot_path("ur5")),
            "table": f"{files}/a/table.parquet",
            "load": f"{files}/load.json",
            "loads": f"{files}/loads.json",
            "samples": f"{files}/{names[0]}",
            "rows": f"{files}/{names[1]}",
            "file": f"{files}/{names[2]}",
            "parts": [f"{files}/{name}" for name in names],
            "of_another_step": f"{files}/nowhere.json",
        },
        {},
    )
    assert given["arm"].name == "ur5"
    same(given["table"], table("a"))
    np.testing.assert_equal(vars(given["load"]), vars(LOAD))
    np.testing.assert_equal(vars(given["loads"]["own"]), vars(LOAD))
    for name in ("samples", "rows"):
        pd.testing.assert_frame_equal(given[name], FRAME)
    assert given["file"] == files / "load.json"
    assert given["parts"] == [files / name for name in names]
    assert "of_another_step" not in given


def test_files_of_several_lie_in_the_folders_of_their_names(files: Path) -> None:
    """Each is read when it is used."""

    def step(tables: Mapping[str, SegmentedTable], loads: Mapping[str, Load]) -> None: ...

    tables = [f"{files}/{name}/table.parquet" for name in "ab"]
    given = arguments(step, {"tables": tables, "loads": [f"{files}/b/load.json"]}, {})
    assert [*given["tables"]] == ["a", "b"]
    Path(tables[1]).unlink()
    same(given["tables"]["a"], table("a"))
    with pytest.raises(FileNotFoundError):
        given["tables"]["b"]
    assert given["loads"]["b"].mass == ord("b")
    alone = arguments(step, {"tables": tables[0], "loads": []}, {})
    assert ([*alone["tables"]], dict(alone["loads"])) == (["a"], {})


class Results(Opened):
    """Files of a recording."""

    table: SegmentedTable
    load: Load
    other: Load
    role: str = "fit"


def test_a_record_of_files_opens_each_when_it_is_first_used(files: Path) -> None:
    """And keeps it; an error of a file names it."""

    def step(recording: Results, limit: float) -> None: ...

    given = {name: f"{files}/a/{name}" for name in ("table.parquet", "load.json")}
    named = {Path(name).stem: path for name, path in given.items()}
    with pytest.raises(InputError, match="nothing is given for `other`, which `recording` decl"):
        arguments(step, named, {"limit": 1.0})
    named["other"] = f"{files}/none.json"
    own = arguments(step, named, {"limit": 1.0, "role": "contact"})
    recording = own["recording"]
    assert (own["limit"], recording.role) == (1.0, "contact")
    same(recording.table, table("a"))
    for path in given.values():
        Path(path).write_text("[]")
    same(recording.table, table("a"))
    with pytest.raises(InputError, match=r"a/load\.json"):
        _ = recording.load


def test_records_of_several_have_what_lies_in_the_folders_of_their_names(files: Path) -> None:
    """A field is not that of a parameter of its name."""

    def step(recordings: Mapping[str, Results], other: Load, role: str) -> None: ...

    tables, loads = [f"{files}/{own}/table.parquet" for own in "ab"], [f"{files}/b/load.json"]
    inputs: dict[str, Any] = {"table": tables, "load": loads, "other": f"{files}/load.json"}
    given = arguments(step, inputs, {"role": "validate"})
    recordings = given["recordings"]
    assert [(name, own.name, own.role) for name, own in recordings.items()] == [
        ("a", "a", "fit"),
        ("b", "b", "fit"),
    ]
    same(recordings["b"].table, table("b"))
    assert recordings["b"].load.mass == ord("b")
    assert given["other"].mass == LOAD.mass
    for missing in ("load", "other"):
        with pytest.raises(AttributeError, match=missing):
            getattr(recordings["a"], missing)


def test_what_is_not_there_has_its_default(files: Path) -> None:
    """An optional file is left out by its rule, or an empty list; an optional setting is None."""

    def step(load: Load | None = None, other: Load | None = None, limit: float = 1.0) -> Any:
        return load, other, limit

    assert step(**arguments(step, {"other": []}, {})) == (None, None, 1.0)
    given = arguments(step, {"load": f"{files}/a/load.json", "other": []}, {"limit": 2.0})
    assert step(**given) == (Load(ord("a"), []), None, 2.0)


def test_settings_are_as_their_types_say() -> None:
    """A study's come as plain data."""

    def step(
        payload: Payload | None,
        lowpass: Butterworth,
        untouched: tuple[float, float] | None,
        dates: dict[str, str],
        file: Path | None,
        anything: Any,
    ) -> None: ...

    settings = {
        "payload": {"mass": 1.5},
        "lowpass": [4, 2.0],
        "untouched": [0, 1.5],
        "dates": {"a": ""},
        "file": "way_points.txt",
        "anything": {"as": "it is"},
        "code": "checksum",
    }
    assert arguments(step, {}, settings) == {
        "payload": Payload(mass=1.5),
        "lowpass": Butterworth(4, 2.0),
        "untouched": (0.0, 1.5),
        "dates": {"a": ""},
        "file": Path("way_points.txt"),
        "anything": {"as": "it is"},
    }
    nothing = dict.fromkeys(("payload", "untouched", "file"))
    assert arguments(step, {}, nothing) == nothing


def test_a_file_of_another_kind_is_an_error_of_the_input(files: Path) -> None:
    def step(load: list[float]) -> None: ...

    with pytest.raises(InputError, match=r"load\.json"):
        arguments(step, {"load": f"{files}/load.json"}, {})


# What it leaves


class Several(NamedTuple):
    """Results of each kind."""

    table: SegmentedTable
    frame: pd.DataFrame
    rows: list[Load]
    load: Load
    text: str
    picture: bytes
    aside: Load


SEVERAL = Several(table(), FRAME, [LOAD, LOAD], LOAD, "arm: ur5\n", b"%PDF", LOAD)


def test_several_results_are_written_under_the_names_of_their_fields(tmp_path: Path) -> None:
    """Those that the rule has no output for are not."""

    def step(load: Load) -> Several: ...

    endings = {"table": "parquet", "frame": "csv", "rows": "csv", "load": "json"}
    endings |= {"text": "yaml", "picture": "pdf"}
    output = {name: str(tmp_path / f"{name}.{ending}") for name, ending in endings.items()}
    write(step, SEVERAL, output)
    assert {path.name for path in tmp_path.iterdir()} == {Path(own).name for own in output.values()}
    same(SegmentedTable.read(output["table"]), SEVERAL.table)
    pd.testing.assert_frame_equal(read_csv(output["frame"]), FRAME)
    rows = read_csv(output["rows"])
    assert (rows["mass"].tolist(), [*rows]) == ([2.0, 2.0], ["mass", "parts"])
    np.testing.assert_equal(vars(read_record(Load, output["load"])), vars(LOAD))
    assert Path(output["text"]).read_text() == SEVERAL.text
    assert Path(output["picture"]).read_bytes() == SEVERAL.picture


def test_one_result_is_written_whatever_its_output_is_called(tmp_path: Path) -> None:
    """Also a record that is a mapping, or a tuple whose fields are no outputs."""

    def of_load(load: Load) -> Load: ...
    def of_loads(load: Load) -> dict[str, Load]: ...
    def of_frame(load: Load) -> pd.DataFrame: ...
    def of_nothing(load: Load) -> Load: ...

    write(of_load, LOAD, {"summary": str(tmp_path / "load.json")})
    assert read_json(tmp_path / "load.json") == {"mass": 2.0, "parts": [1.0, None]}
    write(of_loads, {"all": LOAD, "a": LOAD}, {"calibration": str(tmp_path / "loads.json")})
    assert read_json(tmp_path / "loads.json").keys() == {"all", "a"}
    write(of_frame, FRAME, {"samples": str(tmp_path / "frame.parquet")})
    pd.testing.assert_frame_equal(read_table(tmp_path / "frame.parquet"), FRAME)
    write(of_nothing, None, {"raw": str(tmp_path / "written_by_itself")})
    assert not (tmp_path / "written_by_itself").exists()


def test_figures_are_written_with_their_numbers_beside_them(tmp_path: Path) -> None:
    def step(load: Load) -> dict[str, Drawing]: ...

    with mpl.rc_context({"svg.hashsalt": "one"}):
        drawings = {name: Drawing(Figure(), FRAME) for name in ("a", "b", "c")}
        names = {f"{own}{data}" for own in "ab" for data in ("", "_data")}
        endings = {name: "csv" if name.endswith("_data") else "svg" for name in names}
        output = {name: str(tmp_path / f"{name[0]}.{ending}") for name, ending in endings.items()}
        write(step, drawings, output)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "a.svg", "b.csv", "b.svg"]
    pd.testing.assert_frame_equal(read_csv(tmp_path / "a.csv"), FRAME)
