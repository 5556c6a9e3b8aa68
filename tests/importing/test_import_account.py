"""Forms that public logs have, and their account: each column has a row that says what it is."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io

from tests.entries import read_and_check, read_recording
from tests.importing.test_import_cases import driven, motion
from tests.stored_files import JOINTS
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.contents import NO_STATEMENT, UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.importing.motion import agreement
from ur5lib.recordings.entries import SKIPPED_COLUMN, expand
from ur5lib.records.account import NOTHING, AccountRow
from ur5lib.records.codes import Found
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

PERIOD = 0.008  # s
TIME = np.arange(0, 20, PERIOD)
ARM = load_robot(robot_path("ur5e"))
MOTORS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")


def moved() -> tuple[Array, Array, Array, Array]:
    """Positions, velocities, currents and torques (N, 6) of an arm all of whose joints move."""
    for seed in range(100):
        random = np.random.default_rng(seed)
        q, qd, qdd = motion(ARM, TIME, random)
        if (np.ptp(q, axis=0) > 0.3).all():
            efforts = driven(ARM, q, qd, qdd, None, random)
            return q, qd, efforts["actual_current"], efforts["actual_current_as_torque"]
    raise AssertionError


Q, QD, CURRENT, TORQUE = moved()
SPEED = np.gradient(QD, PERIOD, axis=0)
TARGET = (  # of a controller: gravity, friction and inertia, without noise but for its rounding
    gravity_torque(ARM, ARM.chosen_model, Q) + 3 * np.tanh(QD / 0.02) + 0.5 * SPEED
) / np.array(ARM.maker_torque_constants()) + 2e-3 * np.random.default_rng(3).normal(size=Q.shape)
MOTION = {"q": Q, "qd": QD, "current": CURRENT}
FORCE = 40 * np.exp(-((TIME - 10) ** 2))[:, None] * np.array([2.0, 1.0, 40.0, 0.2, 0.1, 0.1]) / 40
PACKETS = np.repeat(TIME[::10], 10) + 1e-5 * np.tile(np.arange(10), len(TIME) // 10)


def columns(**blocks: Array) -> dict[str, Array]:
    """Columns named by block and joint."""
    return {f"{name}_{k}": part for name, rows in blocks.items() for k, part in enumerate(rows.T)}


def imported(
    table: dict[str, Array], folder: Path, stated: UserStatement = NO_STATEMENT
) -> list[ImportedRecording]:
    """What import makes of a table, in whose account each column has a row."""
    pd.DataFrame(table).to_csv(folder / "run.csv", index=False)
    recordings = import_files([folder / "run.csv"], stated)
    for recording in recordings:
        subjects = " ".join(row.subject for row in recording.account)
        unnamed = [name for name in table if name.rstrip("0123456789xyz") not in subjects]
        assert unnamed == []
        assert all(row.reason for row in recording.account)
    return recordings


def row_of(recording: ImportedRecording, column: str) -> AccountRow:
    """The row of the account that a column begins, or that is about the file."""
    told = [row for row in recording.account if row.confidence != "evidence"]
    (row,) = [row for row in told if column in row.subject]
    return row


def test_columns_of_our_sensor_are_taken_beside_other_names(tmp_path: Path) -> None:
    axes = dict(zip(("ft_fx", "ft_fy", "ft_fz", "ft_tx", "ft_ty", "ft_tz"), FORCE.T, strict=True))
    (one,) = imported({"time": TIME} | columns(**MOTION) | axes, tmp_path)
    assert [*axes] == one.entry["columns"][-6:]
    assert one.entry["role"] == "contact"
    assert row_of(one, "ft_fx").taken_for == "ft_f"


def test_what_the_entry_reads_is_told_as_read(tmp_path: Path) -> None:
    given = {"ft_raw_wrench": 0.1 * QD, "payload_cog": 0 * QD[:, :3] + 0.01}
    rest = {"target_TCP_speed": QD, "safety_mode": 0 * QD[:, :1] + 1, "payload_inertia": 0 * QD}
    table = columns(actual_q=Q, current=CURRENT, **given, **rest) | {"payload": 0 * TIME + 2}
    (one,) = imported({"time": TIME} | table, tmp_path, UserStatement("ur5e"))
    names = zip(["time", *table], expand(one.entry["columns"]), strict=True)
    kept = {name for name, read_as in names if not read_as.startswith(SKIPPED_COLUMN)}
    assert {"ft_raw_wrench_0", "payload", "payload_cog_0", "payload_inertia_0"} <= kept
    told = [(part.split(" … ")[0], row) for row in one.account for part in row.subject.split(", ")]
    firsts = {name: row.taken_for for name, row in told if name in table}
    assert {name for name, taken_for in firsts.items() if taken_for != NOTHING} == kept & {*firsts}
    assert firsts["payload_cog_0"] == "payload_cog"
    left_out = next(row.reason for name, row in told if name == "target_TCP_speed_0")
    assert "no channel" not in left_out  # there is one


def test_the_order_of_joints_is_told_once(tmp_path: Path) -> None:
    flange = link_frames(ARM, Q)[1][:, -1]
    poses = columns(actual_TCP_pose=np.hstack([flange, np.zeros_like(flange)]))
    for positions, sure in ((Q, "proven"), (Q[:, [2, 1, 0, 3, 4, 5]], "check")):
        table = {"time": TIME} | columns(actual_q=positions) | poses
        (one,) = imported(table, tmp_path, UserStatement("ur5e"))
        assert row_of(one, "the joints' order").confidence == sure


WRENCH = np.hstack([FORCE[:, :3], 0.02 * FORCE[:, 2::-1]])


def saved_as(ending: str, folder: Path, arrays: dict[str, Array]) -> Path:
    """A file of arrays: of NumPy, or a table of lists in cells, below a title or a comment."""
    path = folder / f"run.{ending}"
    if ending == "npz":
        np.savez(path, allow_pickle=False, **arrays)
        return path
    listed = {name: [str(row) for row in rows.tolist()] for name, rows in arrays.items()}
    above = "# of a robot\n" if ending == "tsv" else "Log of robot 7, cell 3\n\n"
    path.write_text(above + pd.DataFrame(listed).to_csv(index=False, sep=";"))
    return path


@pytest.mark.parametrize("ending", ["npz", "csv", "tsv"])
def test_a_wrench_of_one_array_is_a_contact(tmp_path: Path, ending: str) -> None:
    arrays = {"time": TIME, "position": Q, "velocity": QD, "current": CURRENT, "wrench": WRENCH}
    (one,) = import_files([saved_as(ending, tmp_path, arrays)], UserStatement("ur5e"))
    assert one.entry["role"] == "contact"
    told = [row.reason for row in one.account if "wrench" in row.subject]
    assert len(told) == 1
    assert "changes by up to 40 N" in told[0]  # no effort shows the push


def test_velocities_of_numbered_actuators(tmp_path: Path) -> None:
    kinds = {"position": Q, "velocity": QD, "current_motor": CURRENT}
    table = {
        f"actuator_{k + 1}_{kind}": part
        for kind, rows in kinds.items()
        for k, part in enumerate(rows.T)
    }
    pd.DataFrame({"time": TIME} | table).to_csv(tmp_path / "run.csv", index=False)
    (one,) = import_files([tmp_path / "run.csv"], UserStatement("ur5e"))
    assert row_of(one, "actuator_1_velocity").taken_for == "actual_qd"
    assert row_of(one, "actuator_1_current_motor").taken_for == "actual_current"


def test_joints_and_axes_of_one_name_are_two_quantities(tmp_path: Path) -> None:
    axes = {f"{name}_{axis}": 0 * TIME + 1 for name in ("force", "torque") for axis in "xyz"}
    table = {"time": TIME} | columns(q=Q, qd=QD, torque=TORQUE) | axes
    pd.DataFrame(table).to_csv(tmp_path / "run.csv", index=False)
    (one,) = import_files([tmp_path / "run.csv"], UserStatement("ur5e"))
    read = channel(read_recording(one.entry).robot.table, "actual_current_as_torque")
    np.testing.assert_allclose(read, TORQUE)
    assert row_of(one, "torque_x").taken_for == NOTHING


def test_a_second_block_of_a_name_is_left_out_beside_the_first(tmp_path: Path) -> None:
    table = columns(**MOTION, filtered_qd=0.9 * QD, motor_q=100 * Q)
    (one,) = imported({"time": TIME} | table, tmp_path, UserStatement("ur5e"))
    assert row_of(one, "filtered_qd_0").reason == "named like actual_qd, as qd_0 … qd_5 before"
    assert row_of(one, "motor_q_0").reason == "named like actual_q, as q_0 … q_5 before"


def test_positions_that_no_row_holds_have_no_derivative() -> None:
    assert agreement(np.full_like(Q, np.nan), QD, TIME).share == 0.0


def test_a_clock_gives_way_to_the_rate_that_the_user_names(tmp_path: Path) -> None:
    stated = UserStatement("ur5e", rate=125.0)
    (one,) = imported({"time": 2 * TIME} | columns(**MOTION), tmp_path, stated)
    assert row_of(one, "time").reason == "the rows are timed by --rate"
    assert one.entry["rate"] == 125.0


def test_a_title_above_an_index_without_a_name(tmp_path: Path) -> None:
    table = pd.DataFrame({"time": TIME} | columns(**MOTION)).to_csv(sep=";")
    (tmp_path / "run.csv").write_text("Log of robot 7, cell 3\n\n" + table)
    (one,) = import_files([tmp_path / "run.csv"])
    assert row_of(one, "q_0").taken_for == "actual_q"


def test_a_clock_behind_columns_without_names(tmp_path: Path) -> None:
    rows = np.column_stack([Q, QD, CURRENT, TIME])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",")
    (one,) = import_files([tmp_path / "run.csv"], UserStatement("ur5e"))
    assert one.entry["columns"][-1] == "time"


def test_nanoseconds_since_1970_in_whole_numbers(tmp_path: Path) -> None:
    stamps = np.round(1e9 * (1.7e9 + TIME)).astype(np.int64) + 1  # no float64 holds them
    lists = {"time": stamps, "q": [*Q], "qd": [*QD], "ticks": [*stamps[:, None]]}
    pq.write_table(pa.table(lists), tmp_path / "run.parquet")
    (one,) = import_files([tmp_path / "run.parquet"], UserStatement("ur5e"))
    lasts = np.ptp(read_recording(one.entry).robot.table["time"])
    assert lasts == pytest.approx(np.ptp(TIME), abs=1e-5)


def test_states_of_other_joints_than_six(tmp_path: Path) -> None:
    table = pa.table({"timestamp": TIME, "observation.state": [*Q[:, :5]]})
    pq.write_table(table, tmp_path / "run.parquet")
    (one,) = import_files([tmp_path / "run.parquet"])
    assert row_of(one, "observation.state").taken_for == "actual_q"


def test_units_behind_the_names_of_motors(tmp_path: Path) -> None:
    parts = {"pos [deg]": np.degrees(Q), "vel [deg/s]": np.degrees(QD)}
    table = {
        f"{motor}.{part}": rows[:, k]
        for part, rows in parts.items()
        for k, motor in enumerate(MOTORS[:5])
    }
    pd.DataFrame({"timestamp": TIME} | table).to_csv(tmp_path / "run.csv", index=False)
    (one,) = import_files([tmp_path / "run.csv"])
    assert row_of(one, "shoulder_pan.vel").taken_for == "actual_qd [deg/s]"


def test_a_quantity_that_is_left_out_has_no_other_reason() -> None:
    account, block = Account(), ColumnBlock(("torque",), TORQUE, "time")
    account.hold("proven", block, "numbers", "it has the opposite sign")
    account.exclude(block, "nothing tells its unit")
    assert [row.reason for row in account.rows({})] == ["nothing tells its unit"]


def test_names_of_a_polling_script(tmp_path: Path) -> None:
    """Where tq stays near q, it is its target; where it does not, a torque."""
    flange = link_frames(ARM, Q)[1][:, -1]
    pose = np.hstack([flange, np.zeros_like(flange)])
    polled = columns(q=Q, tq=Q + 1e-3, tqd=QD, tcp=pose, tcps=0.1 * pose, tcpf=0.1 * FORCE)
    (one,) = imported({"t": TIME} | polled, tmp_path)
    assert one.entry["robot"] == "ur5e"
    meanings = {name: row_of(one, f"{name}_0").taken_for for name in ("tq", "tqd", "tcp", "tcpf")}
    assert meanings == {
        "tq": "target_q", "tqd": "target_qd", "tcp": "actual_TCP_pose", "tcpf": "actual_TCP_force",
    }  # fmt: skip
    assert "ur16e" in row_of(one, "robot").reason  # the arm that is beaten
    (other,) = imported({"t": TIME} | columns(q=Q, qd=QD, tq=TORQUE), tmp_path)
    assert row_of(other, "tq_0").taken_for == "actual_current_as_torque"


@pytest.mark.parametrize("stamps", [np.floor(1.7e9 + TIME), 1.7e9 + PACKETS, PACKETS])
@pytest.mark.parametrize("measured", [True, False])
def test_rows_of_one_second_or_packet_are_put_at_equal_steps(
    tmp_path: Path, stamps: Array, measured: bool
) -> None:
    blocks = MOTION if measured else {"q": Q, "current": CURRENT}
    (one,) = imported({"timestamp": stamps} | columns(**blocks), tmp_path)
    assert "far shorter than a row" in row_of(one, "timestamp").reason
    assert row_of(one, "current_0").taken_for == "actual_current"
    quality = read_and_check(one.entry, ARM, 0.05).quality
    assert quality.period_s == pytest.approx(PERIOD, rel=5e-3)
    assert quality.frames == pytest.approx(len(TIME), abs=25)


def test_numbers_of_postures_are_no_clock(tmp_path: Path) -> None:
    postures = np.random.default_rng(1).uniform(-1.5, 1.5, (300, 6))
    held = gravity_torque(ARM, ARM.chosen_model, postures)
    table = {"ID": np.arange(300)} | columns(q=postures, torque=held)
    (one,) = imported(table, tmp_path, UserStatement("ur5e"))
    assert one.entry["still"] is True
    assert row_of(one, "ID").reason == "it counts the rows"


def test_currents_without_sign_tell_nothing(tmp_path: Path) -> None:
    (one,) = imported({"time": TIME} | columns(**MOTION | {"current": np.abs(CURRENT)}), tmp_path)
    assert "actual_current" not in one.entry["columns"]
    assert "never negative" in row_of(one, "current_0").reason
    assert row_of(one, "robot").confidence == "check"
    still = MOTION | {"current": np.abs(CURRENT)}
    (one,) = imported({"time": TIME} | columns(q=Q, current=still["current"]), tmp_path)
    assert "never negative" in row_of(one, "current_0").reason


def test_efforts_that_never_change_are_not_measured(tmp_path: Path) -> None:
    (one,) = imported({"time": TIME} | columns(q=Q, qd=QD, torque=0 * Q + 3), tmp_path)
    assert row_of(one, "torque_0").reason == "no number of it changes, so it was not measured"


def test_efforts_that_no_row_has_whole_are_left_out(tmp_path: Path) -> None:
    """Before, `ur5 import` ended in a KeyError, as fuzzing found."""
    gaps = np.arange(CURRENT.size).reshape(CURRENT.shape) % 5 > 0
    torn = columns(**MOTION | {"current": np.where(gaps, np.nan, CURRENT)})
    (one,) = imported({"time": TIME} | torn, tmp_path)
    assert row_of(one, "current_0").reason == "no row has its numbers of all joints"
    assert "actual_current" not in one.entry["columns"]


@pytest.mark.parametrize("filled", [0.0, -5.4e-310])
def test_efforts_that_were_never_filled_are_not_recorded(tmp_path: Path, filled: float) -> None:
    (one,) = imported({"time": TIME} | columns(q=Q, qd=QD, effort=0 * Q + filled), tmp_path)
    assert row_of(one, "effort_0").taken_for == NOTHING


def test_one_factor_for_all_joints_is_offered_as_a_unit(tmp_path: Path) -> None:
    counts = {"time": TIME} | columns(**MOTION | {"current": CURRENT / 2.69e-3})
    (one,) = imported(counts, tmp_path, UserStatement("ur5e"))
    option = row_of(one, "current_0").reason.rpartition("--unit actual_current=")[2]
    assert float(option) == pytest.approx(2.69e-3, rel=0.1)
    (told,) = imported(counts, tmp_path, UserStatement("ur5e", units={"actual_current": option}))
    read = channel(read_recording(told.entry).robot.table, "actual_current")
    np.testing.assert_allclose(read, CURRENT * float(option) / 2.69e-3, rtol=1e-6)


def test_of_several_torques_that_of_the_joints_is_taken(tmp_path: Path) -> None:
    beside = columns(
        motor_torque=TORQUE / 100,
        raw_joint_torque=TORQUE,
        actual_joint_torque=TORQUE,
        external_joint_torque=0.1 * TORQUE,
        gravity_torque=0.9 * TORQUE,
    )
    (one,) = imported({"time": TIME} | columns(q=Q, qd=QD) | beside, tmp_path)
    taken = {
        row.subject: row.taken_for
        for row in one.account
        if "torque" in row.subject and row.confidence != "evidence"
    }
    assert taken.pop("actual_joint_torque_0 … actual_joint_torque_5") == "actual_current_as_torque"
    assert {*taken.values()} == {NOTHING}


def test_the_column_of_a_gripper_is_left_out(tmp_path: Path) -> None:
    opening = np.clip(0.04 * np.sin(TIME), 0, 1)[:, None]
    parts = {"position": Q, "velocity": QD, "effort": CURRENT}
    for place in (3, 6):
        wide = {name: np.insert(rows, place, opening.T, axis=1) for name, rows in parts.items()}
        (one,) = imported({"time": TIME} | columns(**wide), tmp_path, UserStatement("ur5e"))
        table = read_recording(one.entry).robot.table
        np.testing.assert_allclose(channel(table, "actual_q"), Q, atol=1e-9)
        assert f"position_{place}" in row_of(one, f"position_{place}").subject


def test_an_element_of_arrays_is_left_out_alike(tmp_path: Path) -> None:
    arrays = {"t": TIME, "q": np.insert(Q, 6, 0.5, axis=1), "qDot": np.insert(QD, 6, 0.0, axis=1)}
    scipy.io.savemat(tmp_path / "run.mat", arrays)
    (one,) = import_files([tmp_path / "run.mat"], UserStatement("ur5e"))
    table = read_recording(one.entry).robot.table
    np.testing.assert_allclose(channel(table, "actual_q"), Q)
    np.testing.assert_allclose(channel(table, "actual_qd"), QD)


def test_derivatives_as_matlab_spells_them(tmp_path: Path) -> None:
    arrays = {"t": TIME, "q": Q, "qDot": QD, "qDDot": np.gradient(QD, PERIOD, axis=0)}
    scipy.io.savemat(tmp_path / "run.mat", arrays | {"tau": TORQUE})
    (one,) = import_files([tmp_path / "run.mat"])
    assert one.entry["channels"]["actual_qd"] == "qDot"
    assert "accelerations" in row_of(one, "qDDot").reason


def test_velocities_of_motors_are_not_read_under_their_names(tmp_path: Path) -> None:
    blocks = columns(actual_q=Q, actual_qd=100 * QD, actual_current=CURRENT)
    (one,) = imported({"timestamp": TIME} | blocks, tmp_path)
    assert "actual_qd_0" not in read_recording(one.entry).robot.table


def test_rows_of_topics_of_their_own_prove_velocities(tmp_path: Path) -> None:
    """As PlotJuggler exports them: the cells of all other topics are empty."""
    joints = pd.DataFrame({"time": TIME} | columns(q=Q, current=CURRENT))
    speeds = pd.DataFrame({"time": TIME + 1e-3} | columns(qd=QD))
    sparse = pd.concat([joints, speeds]).sort_values("time")
    topics = {
        f"/{name}" if name != "time" else "__time": sparse[name].to_numpy() for name in sparse
    }
    (one,) = imported(topics, tmp_path)
    assert row_of(one, "/qd_0").confidence == "proven"
    findings = read_and_check(one.entry, ARM, 0.05).quality.findings
    assert Found.DAMAGED_LINES not in [one.code for one in findings]  # the header is none
    forces = pd.DataFrame({"time": TIME + 1.1e-3} | columns(force=FORCE))
    warm = pd.DataFrame({"time": TIME + 1.2e-3} | columns(joint_temperatures=FORCE + 30))
    sparse = pd.concat([joints, speeds, forces, warm]).sort_values("time")
    (one,) = imported({name: sparse[name].to_numpy() for name in sparse}, tmp_path)
    assert "far shorter" not in row_of(one, "time").reason  # no bunches of rows
    assert not [row for row in one.account if row.subject == "recording"]


def lerobot(folder: Path, named: bool) -> Path:
    """A data set of two episodes: lists of a state and an action, their names in info.json."""
    (folder / "meta").mkdir(parents=True)
    (folder / "data").mkdir()
    names = [f"{motor}.pos" for motor in MOTORS] if named else None
    features = {"observation.state": {"names": names}, "action": {"names": names}}
    (folder / "meta" / "info.json").write_text(json.dumps({"features": features}))
    table = {
        "observation.state": [*np.degrees(Q)],
        "action": [*np.degrees(Q + 0.01)],
        "timestamp": np.concatenate([TIME[: len(TIME) // 2]] * 2),
        "episode_index": np.repeat([0, 1], len(TIME) // 2),
    }
    pq.write_table(pa.table(table), folder / "data" / "run.parquet")
    return folder / "data" / "run.parquet"


def test_episodes_of_lists_are_entries(tmp_path: Path) -> None:
    first, second = import_files([lerobot(tmp_path, named=False)], UserStatement("ur5e"))
    assert row_of(first, "action").taken_for == "target_q [deg]"
    halves = [read_recording(one.entry).robot.table for one in (first, second)]
    read = np.vstack([channel(half, "actual_q") for half in halves])
    np.testing.assert_allclose(read, Q, atol=1e-9)


def test_names_of_a_data_set_tell_the_gripper(tmp_path: Path) -> None:
    first, _ = import_files([lerobot(tmp_path, named=True)])
    assert first.arm == "my_arm"
    taken = first.entry["channels"]["actual_q"]
    assert taken == [f"observation.state/{motor}.pos" for motor in MOTORS[:5]]
    assert "of a gripper" in row_of(first, "observation.state/gripper.pos").reason


def test_loads_of_servos_have_a_row(tmp_path: Path) -> None:
    by_motor = {f"{motor}.pos": np.degrees(Q[:, k]) for k, motor in enumerate(MOTORS)}
    loads = {f"{motor}.load": 100 * CURRENT[:, k] for k, motor in enumerate(MOTORS)}
    pd.DataFrame({"timestamp": TIME} | by_motor | loads).to_csv(tmp_path / "run.csv", index=False)
    (one,) = import_files([tmp_path / "run.csv"])
    assert row_of(one, "shoulder_pan.load").taken_for == NOTHING
    assert row_of(one, "shoulder_pan.pos").taken_for == "actual_q [deg]"


def test_a_proof_names_what_it_beat(tmp_path: Path) -> None:
    (one,) = imported({"time": TIME} | columns(**MOTION), tmp_path, UserStatement("ur5e"))
    proven = [row for row in one.account if row.confidence == "proven"]
    assert len(proven) >= 2
    for row in proven:
        assert row.evidence == "numbers"
        assert any(character.isdigit() for character in row.reason)
        assert any(word in row.reason for word in ("before", "next", "further", "beside"))


def test_the_account_reaches_the_quality_of_the_recording(tmp_path: Path) -> None:
    from ur5lib.recordings.intake import read_and_repair
    from ur5lib.study.reading import parse_study

    (one,) = imported({"time": TIME} | columns(**MOTION, mode=0 * Q[:, :1] + 7), tmp_path)
    entry = one.as_plain()
    study = parse_study({"study": "s", "title": "S", "recordings": [entry]}, "s")
    quality = read_and_repair(study.recordings[0], ARM, 0.05).quality
    assert quality.account == one.account


def test_a_current_that_its_author_smoothed_is_no_target(tmp_path: Path) -> None:
    """Of two nameless ones, the target follows the model; three runs one after the other, rounded
    positions and copies of blocks are in the way."""
    measured = CURRENT + 0.1 * np.sin(20 * Q)  # ripple of the motors, which no model has
    smoothed = pd.DataFrame(measured).rolling(25, min_periods=1, center=True).mean().to_numpy()
    columns_of = [Q.round(3), QD, smoothed, TARGET, Q.round(3), QD]
    pieces = np.r_[0:800, 1700:2500, 900:1600]
    np.savetxt(tmp_path / "run.csv", np.hstack(columns_of)[pieces], delimiter=",")
    (one,) = import_files([tmp_path / "run.csv"], UserStatement("ur5e"))
    taken = {
        row.subject: row.taken_for
        for row in one.account
        if row.subject.startswith("column") and row.confidence != "evidence"
    }
    assert taken["column 13 … column 18"] == "actual_current"
    assert taken["column 19 … column 24"] == "target_current"
    assert taken["column 7 … column 12"] == "actual_qd"
    assert taken["column 25 … column 30"] == NOTHING


def test_what_no_reader_takes_has_a_row(tmp_path: Path) -> None:
    """Texts and pictures of arrays, and topics of other kinds of messages."""
    import h5py
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    with h5py.File(tmp_path / "run.h5", "w") as file:
        for name, rows in {"t": TIME, "q": Q, "qd": QD, "camera": np.zeros((9, 4, 4))}.items():
            file[name] = rows
        file["label"] = np.array([b"push", b"rest"])
    (one,) = import_files([tmp_path / "run.h5"], UserStatement("ur5e"))
    assert row_of(one, "camera (9 × 4 × 4), label (2)").taken_for == NOTHING
    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types["std_msgs/msg/String"]("ready")
    with Writer(tmp_path / "run", version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        kinds = ("/state", "std_msgs/msg/String"), ("/joint_states", "sensor_msgs/msg/JointState")
        state, joints = (bag.add_connection(*kind, typestore=store) for kind in kinds)
        bag.write(state, 0, store.serialize_cdr(text, kinds[0][1]))
        for time, q, qd in zip(TIME[:500], Q, QD, strict=False):
            stamp = store.types["builtin_interfaces/msg/Time"](*divmod(round(1e9 * time), 10**9))
            header = store.types["std_msgs/msg/Header"](stamp, "")
            told = store.types[kinds[1][1]](header, [*JOINTS], q, qd, np.array([]))
            bag.write(joints, round(1e9 * time), store.serialize_cdr(told, kinds[1][1]))
    (other,) = import_files([tmp_path / "run"], UserStatement("ur5e"))
    assert "not read" in row_of(other, "/state (std_msgs/msg/String, 1)").reason
