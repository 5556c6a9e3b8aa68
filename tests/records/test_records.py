"""Typed records: what they hold comes back from a table, with its units."""

import math
from dataclasses import Field, fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.made_records import same
from ur5lib.force.force_input import force_input
from ur5lib.records.accelerations import Accelerations
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.motion import FusedMotion, Motion, motions_before
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.records.table import SegmentedTable, Table
from ur5lib.stand.truth import Truth
from ur5lib.tables import column_unit, read_table

RECORDS: list[type[Table]] = [
    *(Signals, Kinematics, Motion, FusedMotion, Torques, Currents),
    *(Forces, FurtherForces, SensorWrenches, Accelerations, Truth),
]
SomeTable = TypeVar("SomeTable", bound=Table)
KEYS = ("C", "C+rotors", "identified")  # of families that may have any; one begins as another does


def is_family(own: Field[Any]) -> bool:
    return bool(own.metadata["channel"].several)


def is_needed(own: Field[Any]) -> bool:
    return not own.metadata["channel"].optional and not is_family(own)


def of_six(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of a sample of an arm of six joints."""
    return tuple(6 if size < 0 else size for size in shape)


def whole(record: type[SomeTable], count: int = 4) -> SomeTable:
    """A record that has all there may be, each element another number."""
    counter = iter(range(10**9))

    def array(own: Field[Any]) -> np.ndarray:
        shape = count, *of_six(own.metadata["channel"].shape)
        flat = [next(counter) for _ in range(math.prod(shape))]
        return np.array(flat).reshape(shape).astype(own.metadata["channel"].dtype)

    values: dict[str, Any] = {}
    for own in fields(record):
        keys = own.metadata["channel"].keys or KEYS
        values[own.name] = {key: array(own) for key in keys} if is_family(own) else array(own)
    return record(**values)


def test_of_several_channels_only_those_that_are_used_are_loaded(tmp_path: Path) -> None:
    made, path = whole(Torques), tmp_path / "torques.parquet"
    made.write(path)
    read = Torques.read(path)
    assert read.measured.keys() == made.measured.keys()
    first, *others = made.measured
    np.testing.assert_array_equal(read.measured[first], made.measured[first])
    path.unlink()
    assert read.measured[first] is read.measured[first]
    with pytest.raises(FileNotFoundError):
        read.measured[others[0]]


@pytest.mark.parametrize("record", RECORDS)
def test_a_record_comes_back(record: type[Table], tmp_path: Path) -> None:
    """Whole, without samples, and with none or one of what may be absent: of a family, one key."""
    made, path = whole(record), tmp_path / "table.parquet"
    known = {own.name: getattr(made, own.name) for own in fields(record)}
    needed = {own.name: known[own.name] for own in fields(record) if is_needed(own)}
    parts: list[dict[str, Any]] = [{}, *({name: known[name]} for name in known.keys() - needed)]
    for own in filter(is_family, fields(record)):
        parts += [{own.name: {key: values}} for key, values in known[own.name].items()]
    for one in (made, whole(record, 0), *(record(**needed | part) for part in parts)):
        one.write(path)
        same(record.read(path), one)
        same(record.from_table(read_table(path)), one)


@pytest.mark.parametrize("record", RECORDS)
def test_every_column_has_its_unit(record: type[Table], tmp_path: Path) -> None:
    made = whole(record)
    made.write(tmp_path / "whole.parquet")
    units = {column.name: column.metadata[b"unit"].decode()
             for column in pq.read_schema(tmp_path / "whole.parquet")}  # fmt: skip
    expected = {
        name: column_unit(name, own.metadata["channel"].unit)
        for own in fields(made)
        for name, _ in own.metadata["channel"].named_arrays(getattr(made, own.name))
    }
    assert units == expected
    assert all(units.values())
    assert units["time"] == "s"


@pytest.mark.parametrize("record", RECORDS)
def test_a_missing_column_is_named(record: type[Table], tmp_path: Path) -> None:
    """Of those that are not optional; a table may have columns that no record knows."""
    path = tmp_path / "whole.parquet"
    whole(record).write(path)
    table = read_table(path).assign(unknown=0.0)
    same(record.from_table(table), whole(record))
    needed = [own for own in fields(record) if is_needed(own)]
    assert {own.name for own in needed} >= {"time"}
    for own in needed:
        name = own.metadata["channel"].name
        last = own.metadata["channel"].columns(name)[-1]
        with pytest.raises(KeyError, match=name):
            record.from_table(table.drop(columns=last))


def test_a_channel_is_read_when_it_is_used(tmp_path: Path) -> None:
    """Once, and the others not at all."""
    path = tmp_path / "signals.parquet"
    whole(Signals).write(path)
    signals = Signals.read(path)
    assert signals.payload_cog is signals.payload_cog
    path.unlink()
    assert signals.payload_cog is not None
    with pytest.raises(FileNotFoundError):
        _ = signals.actual_q
    with pytest.raises(AttributeError, match="nothing"):
        _ = signals.nothing  # type: ignore[attr-defined]


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize("rows", [None, np.array([0, 2])])
def test_a_table_is_opened_anew_with_all_rows_or_some(
    record: type[Table], rows: np.ndarray | None, tmp_path: Path
) -> None:
    """From its file or from memory: both hold the same."""
    made = whole(record)
    made.write(tmp_path / "table.parquet")
    read = record.read(tmp_path / "table.parquet")
    same(read.anew(rows), made.anew(rows))
    assert len(made.anew(rows).time) == (4 if rows is None else 2)
    again = read.anew(rows).anew()
    same(again, made)  # all rows, from its file


def test_what_a_table_holds_is_not_held_by_the_one_opened_anew(tmp_path: Path) -> None:
    """So that a long recording can be freed; one in memory is itself."""
    made = whole(Motion)
    made.write(tmp_path / "motion.parquet")
    read = Motion.read(tmp_path / "motion.parquet")
    assert read.q is read.q
    assert read.anew().q is not read.q
    assert made.anew() is made


def test_a_record_s_arrays_are_its_own() -> None:
    """Nobody who changes them changes the table."""
    table = pd.DataFrame({"time": np.arange(3.0), "segment": 0, "Fmap_Fx": 1.0})
    SegmentedTable.from_table(table).time[:] = 9.0
    assert table["time"].tolist() == [0.0, 1.0, 2.0]


def test_signals_are_read_under_the_names_of_rtde(tmp_path: Path) -> None:
    whole(Signals).write(tmp_path / "signals.parquet")
    columns = {*read_table(tmp_path / "signals.parquet")}
    rtde = {"actual_q_0", "target_moment_5", "actual_TCP_force_3", "payload", "payload_cog_2"}
    assert columns >= rtde | {*SENSOR_COLUMNS["force"], *SENSOR_COLUMNS["imu"]}


def test_what_was_not_recorded_is_no_array_of_nothing() -> None:
    empty = {"time": np.zeros(1), "segment": np.zeros(1, np.int64)}
    joints = {"interpolated": np.zeros(1, bool), "actual_q": np.zeros((1, 6))}
    with pytest.raises(ValueError, match="no IMU"):
        _ = Signals(**empty, **joints).imu


def test_truth_is_a_line_between_its_samples_and_unknown_outside() -> None:
    time, names = np.arange(4) * 0.5, [own.name for own in fields(Truth) if own.name != "time"]
    slopes = {name: np.arange(6) + 10.0 * k for k, name in enumerate(names)}
    truth = Truth(time=time, **{name: np.outer(time, slope) for name, slope in slopes.items()})
    at = np.array([-0.1, 0.0, 0.3, 1.25, 1.5, 1.6])
    there, inside = truth.at(at), slice(1, -1)
    np.testing.assert_array_equal(there.time, at)
    for name, slope in slopes.items():
        values = getattr(there, name)
        np.testing.assert_allclose(values[inside], np.outer(at[inside], slope), atol=1e-12)
        assert np.isnan(values[[0, -1]]).all()


def test_a_force_estimate_is_given_one_recording_s_motion_and_torque() -> None:
    motion, currents = whole(Motion), whole(Currents)
    assert isinstance(motion, Motion)
    assert isinstance(currents, Currents)
    assert currents.external_torque is not None
    one = force_input(motion, currents.external_torque, currents, 2.0)
    assert (one.q is motion.q, one.qd is motion.motor_qd) == (True, True)
    assert (one.torque is currents.external_torque, one.doubt is currents.load_doubt) == (True,) * 2
    assert one.period == motion.period
    assert one.states.shape == motion.q.shape


def from_to(*postures: float) -> Any:
    """A motion of one joint through some postures [rad]."""
    return SimpleNamespace(q=np.array(postures)[:, None])


def test_a_chain_is_known_from_the_last_motion_on_after_which_nothing_is_missing() -> None:
    own, postures = from_to(4, 5), [(0, 1), (1, 2), (2, 3), (3 + 5e-5, 4 - 5e-5)]
    motion = {name: from_to(*ends) for name, ends in zip("abcd", postures, strict=True)}
    assert motions_before(own, "abcd", motion) == [*motion.values()]
    unread = {name: motion[name] for name in "acd"}
    assert motions_before(own, "abcd", unread) == [motion["c"], motion["d"]]
    moved = motion | {"c": from_to(2, 3 + 3e-4)}
    assert motions_before(own, "abcd", moved) == [motion["d"]]
    assert motions_before(own, "abc", motion) == []
    assert motions_before(own, "", motion) == []
