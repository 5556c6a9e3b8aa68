"""`ur5 import` of logs in the forms that public data sets and loggers have."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io

from tests.entries import in_words, read_recording
from tests.stored_files import JOINTS, Channels, Made, frame, made_up_channels, write_hdf5
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.written import imported_files
from ur5lib.tables import channel

MOVED = ("actual_q", "actual_qd", "actual_current")
EPOCH = 1_700_000_000


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def imported(path: Path) -> tuple[dict[str, Any], str]:
    """The entry of a file of a UR5, and its account in words."""
    (one,) = import_files([path], UserStatement("ur5"))
    return one.entry, in_words(one.account)


def chosen(channels: Channels, *names: str) -> Channels:
    return {name: channels[name] for name in names or MOVED}


def rtde(made: Made, *names: str, **more: np.ndarray) -> pd.DataFrame:
    """A table with RTDE's names, and other channels."""
    table = frame(made[0], chosen(made[1], *names) | more)
    return table.rename(columns={"time": "timestamp"})


def saved(table: pd.DataFrame, path: Path) -> Path:
    table.to_csv(path, index=False)
    return path


def test_what_was_commanded_is_not_what_was_measured(tmp_path: Path, made: Made) -> None:
    """As in DROID, where the commands of a policy come first and are named like the state."""
    time, channels = made
    late = {name: np.roll(channels[name], -5, axis=0) for name in ("actual_q", "actual_qd")}
    state = chosen(channels, "actual_q", "actual_qd", "actual_current", "target_moment")
    names = "joint_position", "joint_velocity"
    commands = {f"action/{n}": v for n, v in zip(names, late.values(), strict=True)}
    names += "motor_torques_measured", "joint_torques_computed"
    torques = [10 * v if n == "actual_current" else v for n, v in state.items()]
    arrays = {f"state/{n}": v for n, v in zip(names, torques, strict=True)}
    write_hdf5(tmp_path / "run.h5", time, commands | arrays)
    entry, _ = imported(tmp_path / "run.h5")
    assert entry["channels"] == {"time": "run/time"} | {
        "actual_q": "run/state/joint_position",
        "actual_qd": "run/state/joint_velocity",
        "target_q": "run/action/joint_position",
        "target_qd": "run/action/joint_velocity",
        "actual_current_as_torque": "run/state/motor_torques_measured",
        "target_moment": "run/state/joint_torques_computed",
    }


def test_each_of_two_arms_in_a_file_has_an_entry(tmp_path: Path, made: Made) -> None:
    time, channels = made
    both = {f"{side}/{n}": channels[n] for side in ("left", "right") for n in MOVED[:2]}
    write_hdf5(tmp_path / "run.h5", time, both | {"left/actual_current": channels[MOVED[2]]})
    left, right = import_files([tmp_path / "run.h5"])
    assert [one.entry["name"] for one in (left, right)] == ["run_left", "run_right"]
    assert "actual_current" in left.entry["channels"]
    assert "actual_current" not in right.entry["channels"]


def test_targets_in_degrees_have_their_unit(tmp_path: Path, made: Made) -> None:
    q, qd = made[1]["actual_q"], made[1]["actual_qd"]
    qdd = np.gradient(qd, made[0], axis=0)
    turned = {"actual_q": q, "actual_qd": qd, "target_q": q, "target_qd": qd, "target_qdd": qdd}
    table = rtde(made, "actual_current", **{n: np.degrees(v) for n, v in turned.items()})
    entry, _ = imported(saved(table, tmp_path / "run.csv"))
    units = dict.fromkeys(("actual_q", "target_q"), "deg") | {"target_qdd": "deg/s2"}
    assert entry["units"] == units | dict.fromkeys(("actual_qd", "target_qd"), "deg/s")


def test_microseconds_under_the_names_of_rtde(tmp_path: Path, made: Made) -> None:
    """What RTDE names and nothing here has to prove stays."""
    table = rtde(made)
    table["timestamp"] = np.round(1e6 * (table["timestamp"] + EPOCH)).astype(np.int64)
    entry, _ = imported(saved(table.assign(payload=0.5), tmp_path / "run.csv"))
    assert entry["columns"] == ["time", *MOVED, "payload"]
    assert (entry["units"], entry["time"]) == ({"time": "us"}, "epoch_s")


def test_a_pose_in_millimetres_is_left_out(tmp_path: Path, made: Made) -> None:
    table = rtde(made, *MOVED, actual_TCP_pose=1e3 * made[1]["actual_TCP_pose"])
    entry, told = imported(saved(table, tmp_path / "run.csv"))
    assert entry["columns"] == ["time", *MOVED, *["-"] * 6]
    assert "in mm, it puts the flange of ur5 within 0.0 mm" in told


def test_stamps_of_a_busy_computer_jitter(tmp_path: Path, made: Made) -> None:
    table = rtde(made)
    late = np.abs(np.random.default_rng(1).normal(0, 0.003, len(table)))
    table["timestamp"] = np.sort(table["timestamp"] + late)
    assert imported(saved(table, tmp_path / "run.csv"))[0]["format"] == "rtde-csv"


BY_NAME = [2, 1, 0, 3, 4, 5]  # joints in the order of ROS 1: by their names


def in_ros(made: Made, names: str) -> pd.DataFrame:
    """Columns of `sensor_msgs/JointState` as text, numbered; names: pattern of the columns."""
    fields = zip(("position", "velocity", "effort"), MOVED, strict=True)
    values = [(field, made[1][name][:, BY_NAME]) for field, name in fields]
    columns = {names.format(f, k): v[:, k] for f, v in values for k in range(6)}
    return pd.DataFrame({"stamp": made[0] + EPOCH} | columns)


@pytest.mark.parametrize("tool", ["rostopic", "bagpy"])
def test_names_of_joints_in_columns_of_text_order_the_numbers(
    tmp_path: Path, made: Made, tool: str
) -> None:
    """As `rostopic echo -p` writes them, with a header that begins with %, and as bagpy does."""
    joints = [f"{JOINTS[k]}_joint" for k in BY_NAME]
    if tool == "rostopic":
        table = in_ros(made, "field.{}{}").assign(
            **{f"field.name{k}": joint for k, joint in enumerate(joints)}
        )
        table["stamp"] = np.round(1e9 * table["stamp"]).astype(np.int64)
        table = table.rename(columns={"stamp": "%time"})
    else:
        seconds = np.floor(in_ros(made, "{}_{}")["stamp"])
        table = in_ros(made, "{}_{}").assign(secs=seconds, name=str(joints), frame_id="base")
    entry, told = imported(saved(table, tmp_path / "run.csv"))
    assert "check: the joints' order" not in told
    assert entry["time"] == "epoch_s"
    raw = read_recording(entry).robot.table
    for name in MOVED:
        np.testing.assert_allclose(channel(raw, name), made[1][name], rtol=1e-6)


def test_a_header_of_numpy_is_no_comment(tmp_path: Path, made: Made) -> None:
    table = rtde(made)
    head = "made by a lab\n" + ",".join(table.columns)
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header=head)
    entry, _ = imported(tmp_path / "run.csv")
    assert entry["format"] == "rtde-csv"
    raw = read_recording(entry).robot.table
    np.testing.assert_allclose(channel(raw, "actual_q"), made[1]["actual_q"])


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%fZ"])
def test_dates_are_stamps_and_text_is_left_out(tmp_path: Path, made: Made, form: str) -> None:
    table = rtde(made).rename(columns={"timestamp": "Time"})
    dates = pd.to_datetime((table["Time"] + EPOCH) * 1e9)
    table = table.assign(Time=dates.dt.strftime(form), robot_mode="RUNNING", pressed=True)
    entry, _ = imported(saved(table, tmp_path / "run.csv"))
    assert entry["columns"] == ["time", *MOVED, "-", "-"]
    record = read_recording(entry).robot
    assert record.start.seconds == pytest.approx(EPOCH)
    np.testing.assert_allclose(record.table["time"], made[0] - made[0][0], atol=1e-5)


def test_a_channel_that_holds_text_is_no_number(tmp_path: Path, made: Made) -> None:
    path = saved(rtde(made).assign(actual_q_2="0.1 rad"), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"line 2: expected 19 numbers \('0.1 rad' is not a"):
        import_files([path], UserStatement("ur5"))


@pytest.mark.parametrize("printed", [np.ndarray.tolist, list])
def test_lists_in_cells_are_read(tmp_path: Path, made: Made, printed: Callable[..., Any]) -> None:
    """As Python prints them, or NumPy, without commas and on several lines."""
    table = pd.DataFrame({"time": made[0]} | {n: printed(made[1][n]) for n in MOVED})
    entry, _ = imported(saved(table, tmp_path / "run.csv"))
    assert entry["columns"] == ["time", *MOVED]
    q = channel(read_recording(entry).robot.table, "actual_q")
    np.testing.assert_allclose(q, made[1]["actual_q"], atol=1e-8)


def test_an_arm_that_the_pose_excludes_is_told(tmp_path: Path, made: Made) -> None:
    path = saved(rtde(made, *MOVED, "actual_TCP_pose"), tmp_path / "run.csv")
    (one,) = import_files([path], UserStatement("ur10e"))
    assert one.entry["robot"] == "ur10e"
    assert "robot: ur10e: the recorded pose is the flange of ur5" in in_words(one.account)


def test_an_arm_that_nothing_tells_is_my_arm(tmp_path: Path, made: Made) -> None:
    """Where gravity tells no known constants, as of a log without efforts, or in another unit."""
    table = rtde(made)
    efforts = [name for name in table if name.startswith("actual_current")]
    scaled = table.assign(**{name: 1.6 * table[name] for name in efforts})
    for one in (table.drop(columns=efforts), scaled):
        (found,) = import_files([saved(one, tmp_path / "run.csv")])
        assert found.arm == "my_arm"
        assert "check: robot: my_arm" in in_words(found.account)


NAMES = {  # of positions, velocities and currents
    "{joint}_{kind}": ("pos", "vel", "cur"),
    "J{n} {kind}": ("pos [°]", "vel [°/s]", "current [A]"),
    "{kind}": ("Axis{n}.Position", "Axis{n}.Speed", "Axis{n}.Current"),
    "{panel} {kind}": ("Position", "Speed", "Current"),
}
PANEL = ["Base", "Shoulder", "Elbow", "Wrist 1", "Wrist 2", "Wrist 3"]


@pytest.mark.parametrize(("pattern", "kinds"), NAMES.items())
def test_names_of_joints_and_units(
    tmp_path: Path, made: Made, pattern: str, kinds: tuple[str, ...]
) -> None:
    columns = {"t": made[0]}
    for kind, name in zip(kinds, MOVED, strict=True):
        factor = 180 / np.pi if "°" in kind else 1.0
        for k in BY_NAME:
            words = {"joint": PANEL[k].lower().replace(" ", ""), "panel": PANEL[k], "n": k + 1}
            title = pattern.format(kind=kind, **words).format(**words)
            columns[title] = factor * made[1][name][:, k]
    entry, _ = imported(saved(pd.DataFrame(columns), tmp_path / "run.csv"))
    raw = read_recording(entry).robot.table
    for name in MOVED:
        np.testing.assert_allclose(channel(raw, name), made[1][name])


def test_structures_with_stamps_of_their_own(tmp_path: Path, made: Made) -> None:
    """As Simulink saves signals: in each, the time and below it the values."""
    parts = zip(("joint_pos", "joint_vel", "joint_current"), MOVED, strict=True)
    run = {n: {"time": made[0], "signals": {"values": made[1][name]}} for n, name in parts}
    scipy.io.savemat(tmp_path / "run.mat", run)
    entry, _ = imported(tmp_path / "run.mat")
    assert entry["channels"]["actual_current"] == "joint_current/signals/values"


def test_what_a_file_lacks_is_said(tmp_path: Path, made: Made) -> None:
    table = rtde(made)
    slow, told = imported(saved(table.iloc[::125], tmp_path / "slow.csv"))
    assert slow["robot"] == "ur5"
    assert "check: columns: as named: too short" in told
    unknown = {f"actual_{n}": f"{c}" for n, c in (("q", "j"), ("qd", "v"), ("current", "c"))}
    names = {f"{n}_{k}": f"{c}{k}" for n, c in unknown.items() for k in range(6)}
    path = saved(table.rename(columns=names), tmp_path / "run.csv")
    assert "check: the joints' order: base to wrist" in imported(path)[1]
    (tmp_path / "states.txt").write_text('{"q": [0.1, 0.2], "time": 1}\n' * 20)
    with pytest.raises(InputError, match="holds JSON"):
        import_files([tmp_path / "states.txt"])
    lone = table[["timestamp", "actual_current_0"]].rename(columns={"actual_current_0": "i"})
    with pytest.raises(InputError, match=r"none is named like them .*; it holds i \(1\)"):
        import_files([saved(lone, tmp_path / "lone.csv")])


@pytest.mark.parametrize("named", [True, False])
def test_a_log_without_a_clock_has_the_rate_of_its_velocities(
    tmp_path: Path, made: Made, named: bool
) -> None:
    table = rtde(made).drop(columns="timestamp").iloc[::4]
    table.to_csv(tmp_path / "run.txt", sep=" ", index=False, header=named)
    entry, _ = imported(tmp_path / "run.txt")
    assert entry["columns"] == [*MOVED]
    assert entry["rate"] == pytest.approx(31.25, rel=0.01)
    assert "time" not in entry
    (one,) = import_files([tmp_path / "run.txt"], UserStatement("ur5", rate=31.25))
    assert one.entry["rate"] == 31.25


def test_a_rate_that_nothing_tells_is_asked_for(tmp_path: Path, made: Made) -> None:
    table = rtde(made, "actual_q", "actual_current").drop(columns="timestamp")
    _, told = imported(saved(table, tmp_path / "run.csv"))
    assert "check: rate: 125 Hz: no clock" in told


def test_the_user_names_columns_and_units(tmp_path: Path, made: Made) -> None:
    table = rtde(made).assign(note=1.0)
    table.to_csv(tmp_path / "run.csv", header=False, index=False)
    stated = UserStatement("ur5", ("time", *MOVED, "-"), units={"actual_current": "A"})
    (one,) = import_files([tmp_path / "run.csv"], stated)
    assert one.entry["columns"] == ["time", *MOVED, "-"]
    assert "units" not in one.entry  # SI units
    write_hdf5(tmp_path / "run.h5", made[0], {"a": made[1]["actual_q"], "b": made[1]["actual_qd"]})
    stated = UserStatement("ur5", ("actual_q=run/a", "actual_qd=run/b"))
    (one,) = import_files([tmp_path / "run.h5"], stated)
    assert one.entry["channels"] == {
        "time": "run/time", "actual_q": "run/a", "actual_qd": "run/b"
    }  # fmt: skip


def test_desired_motion_of_libfranka_is_not_what_was_measured(tmp_path: Path, made: Made) -> None:
    """Its `logToCSV` also names the commands like the desired state, with other numbers."""
    q, qd, current = (made[1][name] for name in MOVED)
    blocks = {"q_d": np.roll(q, -3, axis=0), "q": q, "dq_d": np.roll(qd, -3, axis=0), "dq": qd}
    blocks |= {"current": current, "q_d ": 0 * q}
    columns = {f"{n}[{k}]": v[:, k] for n, v in blocks.items() for k in range(6)}
    table = pd.DataFrame({"duration": np.round(1e3 * made[0])} | columns)
    text = table.to_csv(index=False).replace("q_d [", "q_d[")
    (tmp_path / "run.csv").write_text(text)
    entry, told = imported(tmp_path / "run.csv")
    names = ["time", "target_q", "actual_q", "target_qd", "actual_qd", "actual_current"]
    assert entry["columns"] == names + ["-"] * 6
    assert "q_d[4], q_d[5]: nothing: its name appears twice in the header" in told


def test_a_target_that_nothing_follows_is_left_out(tmp_path: Path, made: Made) -> None:
    """As velocities that a lab calls q_d."""
    table = rtde(made, *MOVED, q_d=made[1]["actual_qd"])
    entry, told = imported(saved(table, tmp_path / "run.csv"))
    assert entry["format"] == "rtde-csv"  # which ignores them
    assert "left out: q_d_0 … q_d_5: nothing: what moves does not follow it" in told


def test_columns_without_names_are_left_out(tmp_path: Path, made: Made) -> None:
    """An index, and what a spreadsheet program appends; silent channels need no other format."""
    table = rtde(made, *MOVED, target_qdd=0 * made[1]["actual_q"])
    text = table.to_csv().splitlines()
    (tmp_path / "run.csv").write_text("".join(f"{line},,,\n" for line in text))
    entry, told = imported(tmp_path / "run.csv")
    assert entry["format"] == "rtde-csv"
    assert "twice" not in told


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"", "is empty"),
        (b"%PDF-1.4\n", "PDF"),
        (b"7z\xbc\xaf\x27\x1c", "7z"),
        (b"\x80\x04]", "pickle"),
    ],
)
def test_what_is_no_table_is_named(tmp_path: Path, content: bytes, kind: str) -> None:
    (tmp_path / "run.csv").write_bytes(content)
    with pytest.raises(InputError, match=kind):
        import_files([tmp_path / "run.csv"])


def test_a_unit_of_a_channel_that_no_column_became_is_refused(tmp_path: Path, made: Made) -> None:
    path = saved(rtde(made).rename(columns={"timestamp": "time"}), tmp_path / "run.csv")
    stated = UserStatement("ur5", units={"actual_current": "A"})
    assert imported_files([path], stated)
    with pytest.raises(InputError, match="no column became"):
        imported_files([path], replace(stated, units={"target_qdd": "deg"}))


def test_positions_with_efforts_are_the_arm_s(tmp_path: Path, made: Made) -> None:
    """Of several topics with positions; the others say that their stamps are different."""
    time, channels = made
    bare = {"states/actual_q": channels["actual_q"][:-5], "states/time": time[:-5]}
    whole = {f"signals/{name}": channels[name] for name in MOVED}
    with h5py.File(tmp_path / "run.h5", "w") as file:
        for name, values in (bare | whole | {"signals/time": time}).items():
            file[name] = values
    entry, told = imported(tmp_path / "run.h5")
    assert entry["channels"]["actual_q"] == "signals/actual_q"
    assert "actual_current" in entry["channels"]
    assert "left out: states/actual_q: nothing: its stamps are not those" in told
