"""Recordings of a finished study as MAT, CSV and MCAP: the same numbers, with units.

They are read back by the formats' own libraries.
"""

import json
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import pinocchio
import pytest
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.json_format import ParseDict
from mcap.reader import make_reader
from scipy.io import loadmat
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from tests.command import Command
from ur5lib import cli
from ur5lib.commands.convert import EXPORTED_TABLES, channels, write_recordings
from ur5lib.commands.foxglove import METRES_PER_NEWTON, from_x_axis
from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.robots.description import load_robot, robot_path, robot_yaml
from ur5lib.robots.statics import flange_kinematics
from ur5lib.tables import columns, write_json, write_table, write_text

START = 1_700_000_000.25
TIME = 0.008 * np.arange(5)
WRENCH = [f"Fmap_{axis}" for axis in ("Fx", "Fy", "Fz", "nx", "ny", "nz")]
UNITS = dict.fromkeys([*WRENCH, *columns("predicted_current")], "N, Nm")

Known = TypeVar("Known")

Tables = dict[str, pd.DataFrame]  # `time` as index, units in attrs["units"]


def from_mat(path: Path, columns: dict[str, list[str]]) -> Tables:
    """columns: of each table, which structures hold channel by channel."""
    content = loadmat(path, simplify_cells=True)
    return {name: _from_structure(content[name], its) for name, its in columns.items()}


def _from_structure(structure: dict[str, Any], columns: list[str]) -> pd.DataFrame:
    values, units = {}, {"time": structure["units"]["time"]}
    for channel, its in channels(columns).items():
        array = structure[channel].reshape(len(structure["time"]), -1)
        values |= dict(zip(its, array.T, strict=True))
        of_halves = structure["units"][channel].split(", ")
        units |= {column: of_halves[k * len(of_halves) // len(its)] for k, column in enumerate(its)}
    table = pd.DataFrame(values, index=pd.Index(structure["time"], name="time"))
    table.attrs["units"] = units
    return table


def from_csv(folder: Path) -> Tables:
    units = pd.read_csv(folder / "units.csv")
    tables = {}
    for name, own in units.groupby("table"):
        tables[str(name)] = pd.read_csv(folder / f"{name}.csv", index_col="time")
        tables[str(name)].attrs["units"] = dict(zip(own["column"], own["unit"], strict=True))
    return tables


def from_mcap(path: Path) -> tuple[Tables, np.ndarray]:
    """The tables, and the stamps [ns] of all messages in the file's order."""
    rows: dict[str, list[dict[str, float]]] = {}
    units: dict[str, dict[str, str]] = {}
    stamps = []
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            stamps.append(message.log_time)
            if not schema.name.startswith("ur5lib."):
                continue
            name = channel.topic.removeprefix("/")
            known = json.loads(schema.data)["properties"]
            units[name] = {key: value["description"] for key, value in known.items()}
            row = json.loads(message.data)
            for key, value in row.items():
                assert isinstance(value, bool) == (known[key]["type"] == "boolean")
            rows.setdefault(name, []).append(row | {"time": 1e-9 * message.log_time})
    tables = {name: pd.DataFrame(its).set_index("time") for name, its in rows.items()}
    for name, table in tables.items():
        table.attrs["units"] = {"time": "s"} | units[name]
    return tables, np.array(stamps)


def assert_as_in_study(tables: Tables, study: StudyFiles, name: str, start: float = 0) -> None:
    """Each table has the study's numbers, and a single unit for each column.

    start: what the time counts from [s].
    """
    for part, table in tables.items():
        expected = study.frame(name, part)
        np.testing.assert_allclose(table.index - start, expected.index, atol=1e-6)
        assert table.attrs["units"].keys() == {"time", *expected}
        for column, unit in table.attrs["units"].items():
            assert unit in expected.attrs["units"][column].split(", ")
        found = table.reindex(columns=expected.columns).to_numpy(float)
        np.testing.assert_allclose(found, expected.to_numpy(float), rtol=1e-10, atol=1e-11)


STUDY = """\
study: mine
title: Two recordings
recordings:
  - {name: pushed, robot: ur5, format: thesis-csv, folder: raw/pushed, role: contact}
  - {name: free, robot: ur5, format: thesis-csv, folder: raw/free, role: fit}
"""


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two recordings: one with forces that are partly unknown, one of which nothing is known."""
    monkeypatch.chdir(tmp_path)
    random = np.random.default_rng(8)
    head = {"time": TIME, "segment": np.zeros(5, dtype=int)}
    q, wrench = random.normal(size=(5, 6)), random.normal(size=(5, 6))
    wrench[1] = np.nan
    flags = {"interpolated": np.array([False, True, False, False, False])}
    signals = head | flags | dict(zip(columns("actual_q"), q.T, strict=True))
    forces = head | dict(zip(WRENCH, wrench.T, strict=True))
    folder = tmp_path / "results" / "mine"
    for name, own in (("pushed", {"signals": signals, "forces": forces}), ("free", {})):
        for table in EXPORTED_TABLES:
            path = folder / "recordings" / name / f"{table}.parquet"
            write_table(pd.DataFrame(own.get(table, head)), path, UNITS)
        (tmp_path / "raw" / name).mkdir(parents=True)
        flange_kinematics_of(q).write(folder / "recordings" / name / "kinematics.parquet")
    write_table(pd.DataFrame(signals), folder / "recordings" / "free" / "signals.parquet")
    write_text(STUDY, folder / "configuration.yaml")
    arm = robot_yaml(load_robot(robot_path("ur5")))
    write_text(arm, folder / "parameters" / "ur5" / "arm.yaml")
    write_json({"start_epoch_s": START}, folder / "recordings" / "pushed" / "quality.json")
    return folder


def flange_kinematics_of(q: np.ndarray) -> Kinematics:
    return Kinematics.of(TIME, *flange_kinematics(load_robot(robot_path("ur5")), q))


def exported(results: Path, to: str) -> Path:
    (path,) = write_recordings(results, ["pushed"], to)
    return path


def test_mat_has_the_study_s_numbers(results: Path) -> None:
    study = StudyFiles(results)
    parts = {part: [*study.frame("pushed", part)] for part in ("signals", "forces")}
    path = exported(results, "mat")
    assert loadmat(path)["start_epoch_s"].item() == START
    tables = from_mat(path, parts)
    assert_as_in_study(tables, study, "pushed")
    assert tables["forces"].attrs["units"]["Fmap_nx"] == "Nm"


def test_csv_has_the_study_s_numbers(results: Path) -> None:
    tables = from_csv(exported(results, "csv"))
    assert tables.keys() == {"signals", "forces"}
    assert_as_in_study(tables, StudyFiles(results), "pushed")


def test_forces_have_the_push_that_would_have_been_found(results: Path) -> None:
    """Along y at rest 68 N, slow more than 100 N, fast 12 N; unknown where the pose is."""
    recording, q = results / "recordings" / "pushed", np.zeros((5, 6))
    speed = np.array([0.0, 0.1, 0.3, 9.0, np.nan])
    kinematics = flange_kinematics_of(q)
    qd = np.zeros((5, 6))
    qd[:, 0] = speed / np.linalg.norm(kinematics.jacobian[0, :3, 0])
    head = {"time": TIME, "segment": np.zeros(5, dtype=int)}
    motion = dict.fromkeys(("q", "q_std", "qd_std", "qdd", "qdd_std"), q) | {"qd": qd}
    Motion(**head, **motion, motor_qd=qd).write(recording / "motion.parquet")
    kinematics.write(recording / "kinematics.parquet")
    forces = head | dict(zip(WRENCH, np.zeros((6, 5)), strict=True))
    untouched = {"if_untouched": np.ones(5, bool)}
    write_table(
        pd.DataFrame(forces | untouched),
        recording / "forces.parquet",
        UNITS | {"if_untouched": "1"},
    )
    pushes = pd.DataFrame({"robot": "ur5", "axis": "y", "motion": ["at rest", "slow", "fast"]})
    pushes = pushes.assign(value=[68.0, 100.0, 12.0], std_error=[10.0, np.nan, 2.0])
    write_text(pushes.to_csv(index=False), results / "tables" / "pushes.csv")
    table = from_csv(exported(results, "csv"))["forces"]
    np.testing.assert_array_equal(table["smallest_push_95_y"], [68.0, 100.0, 12.0, 12.0, np.nan])
    np.testing.assert_array_equal(table["smallest_push_95_y_std"], [10, np.nan, 2, 2, np.nan])
    assert table["smallest_push_95_x"].isna().all()
    assert (table["if_untouched"] == 1).all()


def test_mcap_has_the_study_s_numbers(results: Path) -> None:
    tables, stamps = from_mcap(exported(results, "mcap"))
    assert tables.keys() == {"signals", "forces"}
    assert_as_in_study(tables, StudyFiles(results), "pushed", START)
    assert (np.diff(stamps) >= 0).all()


def test_mcap_has_the_messages_that_foxglove_draws(results: Path) -> None:
    """As its own schemas read them: the arm, its joints' angles, and the force at its flange."""
    read = messages(exported(results, "mcap"))
    ((_, description),) = read["/robot_description"]
    arm = pinocchio.buildModelFromXML(description["data"])
    study = StudyFiles(results)
    q, force = study.signals("pushed"), study.forces("pushed")[WRENCH[:3]].to_numpy()
    flange = study.record(Kinematics, "pushed").origin
    states, scenes = read["/joint_states"], read["/arrow_Fmap"]
    assert len(states) == len(scenes) == len(TIME)
    for sample, (stamp, state) in enumerate(states):
        joints = parsed(state, JointStates).joints
        assert [joint.name for joint in joints] == [*arm.names][1:]
        assert [joint.position for joint in joints] == [*q[columns("actual_q")].iloc[sample]]
        assert state["timestamp"] == {"sec": stamp // 10**9, "nsec": stamp % 10**9}
    for sample, (_, scene) in enumerate(scenes):
        (entity,) = parsed(scene, SceneUpdate).entities
        assert entity.frame_id == arm.frames[1].name
        if sample == 1:  # unknown
            assert not entity.arrows
            continue
        (arrow,) = entity.arrows
        place, turn = arrow.pose.position, arrow.pose.orientation
        np.testing.assert_allclose([place.x, place.y, place.z], flange[sample])
        along = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply([1, 0, 0])
        length = arrow.shaft_length + arrow.head_length
        np.testing.assert_allclose(along * length / METRES_PER_NEWTON, force[sample], atol=1e-12)


def messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Stamps [ns] and contents of all messages by topic."""
    read: dict[str, list[tuple[int, Any]]] = {}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            row = message.log_time, json.loads(message.data)
            read.setdefault(channel.topic, []).append(row)
    return read


def parsed(message: dict[str, Any], kind: type[Known]) -> Known:
    """A message as Foxglove's schema reads it, which refuses what it does not know.

    Protobuf writes times as text.
    """
    return ParseDict(json.loads(json.dumps(message), object_hook=as_protobuf_time), kind())


def as_protobuf_time(value: dict[str, Any]) -> Any:
    if value.keys() != {"sec", "nsec"}:
        return value
    if not any(value.values()):
        return "0s"  # a duration
    return f"{datetime.fromtimestamp(value['sec'], UTC):%Y-%m-%dT%H:%M:%S}.{value['nsec']:09}Z"


@pytest.mark.parametrize("direction", [*np.vstack([np.eye(3), -np.eye(3)]), [0.6, 0, -0.8]])
def test_an_arrow_is_turned_from_the_x_axis(direction: np.ndarray) -> None:
    (turn,) = from_x_axis(np.array([direction]))
    np.testing.assert_allclose(Rotation.from_quat(turn).apply([1, 0, 0]), direction, atol=1e-12)


def test_stamps_count_from_the_start_where_that_is_unknown(results: Path) -> None:
    (path,) = write_recordings(results, ["free"], "mcap")
    _, stamps = from_mcap(path)
    np.testing.assert_allclose(1e-9 * np.unique(stamps), TIME)


@pytest.mark.parametrize(
    ("to", "names"), [("mat", ["free.mat", "pushed.mat"]), ("csv", ["free", "pushed"])]
)
def test_all_recordings_are_written_where_none_is_named(
    results: Path, tmp_path: Path, to: str, names: list[str]
) -> None:
    paths = [*write_recordings(results, [], to, tmp_path / "here")]
    assert paths == [tmp_path / "here" / name for name in names]
    assert all(path.exists() for path in paths)


def test_columns_are_joined_to_channels() -> None:
    names = ["segment", "q_0", "q_1", "ft_fx", "ft_tz", "imu_ax", "imu_ay", "imu_gx", "log_odds_F"]
    joined = {"segment", "q", "ft", "imu_a", "imu_g", "log_odds_F"}
    assert channels(names).keys() == joined
    assert channels(names)["imu_a"] == ["imu_ax", "imu_ay"]


@pytest.mark.parametrize(
    ("names", "to", "message"),
    [
        (["pushd"], "mat", "pushed"),
        ([], "xls", "available: mat, csv, mcap"),
    ],
)
def test_what_is_not_there_is_reported(
    results: Path, names: list[str], to: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        [*write_recordings(results, names, to)]
    assert not (results / "exported").exists()


def test_an_interrupted_export_leaves_nothing(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(path: Path, *_: object, **__: object) -> None:
        path.write_bytes(b"MATLAB")
        raise KeyboardInterrupt

    monkeypatch.setattr("ur5lib.commands.convert.savemat", interrupted)
    with pytest.raises(KeyboardInterrupt):
        exported(results, "mat")
    assert not (results / "exported").exists()


def test_a_second_conversion_at_the_same_time_is_refused(results: Path, run_ur5: Command) -> None:
    """Until the first has written all recordings; then it writes them anew."""
    first = write_recordings(results, [], "mat")
    written = [next(first)]
    before = written[0].read_bytes()
    for name in ("free", "pushed"):
        second = run_ur5("convert", "mine", name)
        assert second.status == 1
        assert re.search(rf"another process is writing \S*{name}\.mat; wait until", second.line)
    assert run_ur5("convert", "mine", "--output", "other").status == 0
    assert written[0].read_bytes() == before
    written += first
    assert {*(results / "exported").iterdir()} == {*written}
    assert run_ur5("convert", "mine").status == 0


def test_a_second_export_into_one_file_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    """While the first reads its study."""
    monkeypatch.chdir(tmp_path)
    command, said = ("export", "--robot", "ur3", "--output", "arm.xml"), list[str]()

    def reading(*asked: object) -> str:
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
        with pytest.raises(InputError) as refused:
            CliRunner().invoke(cli.app, command, catch_exceptions=False)
        said.append(str(refused.value))
        return "first"

    monkeypatch.setattr("ur5lib.commands.exported.exported", reading)
    assert run_ur5(*command).status == 0
    assert said == ["another process is writing arm.xml; wait until it has ended, or name another"]
    assert Path("arm.xml").read_text() == "first\n"
    assert run_ur5(*command).status == 0
    assert Path("arm.xml").read_text().startswith("<robot")
    assert [*tmp_path.iterdir()] == [tmp_path / "arm.xml"]
