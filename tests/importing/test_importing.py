"""`ur5 import`: the entry of a recording is found and proven, or refused; never wrong."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.conftest import shared_folder
from tests.entries import in_words, read_and_check, read_recording
from tests.stored_files import (
    JOINTS,
    Made,
    made_up_channels,
    thesis_channels,
    write_bag,
    write_hdf5,
    write_mat,
)
from tests.synthetic import poor_log
from ur5lib import cli
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.readings import IMPOSSIBLE_MOTION_PENALTY, in_order, readings
from ur5lib.errors import InputError
from ur5lib.importing.blocks import ColumnBlock, grouped
from ur5lib.importing.contents import NIST_COLUMNS, UserStatement
from ur5lib.importing.files import import_files
from ur5lib.recordings.entries import expand
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import geometric_jacobian, gravity_torque, link_frames
from ur5lib.study.reading import parse_study
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

ORDER = np.array([2, 1, 0, 3, 4, 5])  # elbow, lift, pan, as a lab records them


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def thesis(thesis_data: Path) -> Made:
    return thesis_channels(thesis_data / "Movement_No8_Singularity_Free_1")


@pytest.fixture(scope="module")
def ur5e_data() -> Path:
    return shared_folder("ur5e", "they are recordings of real UR5e arms")


def entry_and_account(*paths: Path, robot: str = "") -> tuple[dict[str, Any], str]:
    """The entry of the first file, and its account in words."""
    (one, *_) = import_files(paths, UserStatement(robot))
    return one.entry, in_words(one.account)


def shuffled(made: Made, order: np.ndarray) -> Made:
    """The recording with the joints' columns in another order."""
    time, channels = made
    kept = {name: v if "TCP" in name else v[:, order] for name, v in channels.items()}
    return time, kept


# Made-up recordings


def test_what_names_and_numbers_tell_becomes_the_entry(tmp_path: Path, made: Made) -> None:
    write_hdf5(tmp_path / "run.h5", *made)
    entry, told = entry_and_account(tmp_path / "run.h5")
    assert entry["robot"] == "ur5"
    assert entry["format"] == "hdf5"
    assert entry["channels"] == {"time": "run/time"} | {name: f"run/{name}" for name in made[1]}
    assert "joints" not in entry
    assert "proven: run/actual_qd: actual_qd: the derivative of run/actual_q on 6 joints" in told
    assert "it puts the flange of ur5 within" in told


@pytest.mark.parametrize("known", [6, 3])
def test_another_order_of_the_joints_is_found_by_the_pose(
    tmp_path: Path, made: Made, known: int
) -> None:
    """Also by the position alone."""
    time, channels = shuffled(made, ORDER)
    channels |= {"actual_TCP_pose": channels["actual_TCP_pose"][:, :known]}
    write_hdf5(tmp_path / "run.h5", time, channels)
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert "it puts the flange of ur5 within" in told
    assert entry["joints"] == [3, 2, 1, 4, 5, 6]
    assert "elbow, shoulder lift, shoulder pan, wrist 1" in told
    table = read_recording(entry).robot.table
    np.testing.assert_allclose(table["actual_q_0"], made[1]["actual_q"][:, 0])


def bare(made: Made, **more: Array) -> Made:
    """Positions, velocities and poses of a recording, and other arrays."""
    kept = {name: made[1][name] for name in ("actual_q", "actual_qd", "actual_TCP_pose")}
    return made[0], kept | more


def currents_read(entry: dict[str, Any]) -> Array:
    return channel(read_recording(entry).robot.table, "actual_current")


@pytest.mark.parametrize(
    ("factor", "channel", "unit"),
    [
        (1.0, "actual_current", None),
        (1e3, "actual_current", "mA"),
        (-1.0, "actual_current", "opposite"),
        (10.0, "actual_current_as_torque", None),
    ],
)
def test_the_unit_and_sign_of_efforts_are_told_by_gravity(
    tmp_path: Path, made: Made, factor: float, channel: str, unit: str | None
) -> None:
    write_hdf5(tmp_path / "run.h5", *bare(made, effort=factor * made[1]["actual_current"]))
    entry, _ = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert entry["channels"][channel] == "run/effort"
    assert entry.get("units") == ({channel: unit} if unit else None)
    if channel == "actual_current":
        np.testing.assert_allclose(currents_read(entry), made[1]["actual_current"])


def test_constants_of_a_driver_are_told_by_the_rounding_of_currents(
    tmp_path: Path, made: Made
) -> None:
    """A driver multiplied currents of three decimals by constants of its own, sign included."""
    current = made[1]["actual_current"].round(3)
    constants = np.array([-12.925, -13.088, -9.358, -4.572, -4.572, -4.548])
    time, channels = bare(made, effort=constants * current)
    write_hdf5(tmp_path / "run.h5", *shuffled((time, channels), ORDER))
    entry, _ = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert entry["joints"] == [3, 2, 1, 4, 5, 6]
    np.testing.assert_allclose(entry["units"]["actual_current"], 1 / constants[ORDER], rtol=1e-6)
    np.testing.assert_allclose(currents_read(entry), current, atol=1e-6)
    names = expand(["time", "actual_q", "actual_qd", "actual_TCP_pose", "actual_current"])
    table = np.hstack([time[:, None], *channels.values()])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=",".join(names), comments="")
    units = entry_and_account(tmp_path / "a.csv", robot="ur5")[0]["units"]
    np.testing.assert_allclose(units["actual_current"], 1 / constants, rtol=1e-6)


def test_gravity_is_added_to_torques_without_it(tmp_path: Path, made: Made, ur5: Robot) -> None:
    """As UR's driver gives them; a current is never without gravity."""
    free = np.tanh(made[1]["actual_qd"] / 0.02) + 0.5 * made[1]["actual_qd"]
    write_hdf5(tmp_path / "run.h5", *bare(made, effort=free))
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert entry["channels"]["actual_torque_less_gravity"] == "run/effort"
    assert "check: run/effort: actual_torque_less_gravity: in Nm, less gravity" in told
    taken = read_and_check(entry, ur5, 0.1)
    torque = free + gravity_torque(ur5, ur5.chosen_model, made[1]["actual_q"])
    current = torque / np.array(ur5.maker_torque_constants())
    np.testing.assert_allclose(channel(taken.robot, "actual_current"), current, atol=1e-6)
    write_hdf5(tmp_path / "run.h5", *bare(made, current=free))
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert "check: run/current: actual_current: in A" in told


def at_rest(made: Made) -> Made:
    time, channels = made
    return time, {name: 0 * values + values[:1] for name, values in channels.items()}


def test_names_decide_where_nothing_moves(tmp_path: Path, made: Made) -> None:
    time, channels = at_rest(made)
    names = [
        f"{joint}_{kind}" for kind in ("position", "velocity", "current_mA") for joint in JOINTS
    ]
    values = [channels["actual_q"], 0 * channels["actual_q"], 1e3 * channels["actual_current"]]
    values[2] = values[2] + np.random.default_rng(1).normal(0, 5, values[2].shape)
    table = np.hstack([time[:, None], *values])
    head = ",".join(["time", *names])
    np.savetxt(tmp_path / "ur5_a.csv", table, delimiter=",", header=head, comments="", fmt="%.6f")
    entry, told = entry_and_account(tmp_path / "ur5_a.csv")
    assert entry["robot"] == "ur5"
    assert entry["units"] == {"actual_current": "mA"}
    assert "assumed: robot: ur5: by the name of file" in told
    assert "actual_current [mA]: in mA" in told


def test_a_bad_file_stops_no_other(
    tmp_path: Path, made: Made, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    write_hdf5(tmp_path / "good.h5", *made)
    (tmp_path / "bad.h5").write_text("nothing")
    study = tmp_path / "mine.yaml"
    files = [str(tmp_path / name) for name in ("bad.h5", "good.h5")]
    words = ["ur5", "import", *files, "--robot", "ur5", "--output", str(study)]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    assert stopped.value.code not in (0, None)
    assert "bad.h5" in capsys.readouterr().err + str(stopped.value.code)
    read = parse_study(yaml.safe_load(study.read_text()), "written").recordings
    assert [recording.name for recording in read] == ["good"]


@pytest.mark.parametrize(
    "names",
    [
        ["Fx", "Fy", "Fz", "Mx", "My", "Mz"],
        ["wrench_fx", "wrench_fy", "wrench_fz", "wrench_tx", "wrench_ty", "wrench_tz"],
        ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"],
        ["Fx [N]", "Fy [N]", "Fz [N]", "Tx [Nm]", "Ty [Nm]", "Tz [Nm]"],
        [f"wrench_{k}" for k in range(6)],
    ],
)
def test_columns_of_a_force_are_known_by_many_names(names: list[str]) -> None:
    blocks = [ColumnBlock(own, np.zeros((9, len(own))), "time") for own in grouped(names)]
    assert [block.meaning() for block in blocks] in (["force", "torque"], ["wrench"])
    assert [name for block in blocks for name in block.names] == names


@pytest.mark.parametrize("frame", ["base", "flange"])
def test_a_wrench_in_a_table_has_its_columns(
    tmp_path: Path, made: Made, ur5: Robot, frame: str
) -> None:
    time, channels = touched(made, ur5, frame)
    joints = expand(["time", "actual_q", "actual_qd", "actual_current"])
    names = [*joints, "Fx", "Fy", "Fz", "Mx", "My", "Mz"]
    values = [channels[n] for n in ("actual_q", "actual_qd", "actual_current", "force", "torque")]
    table = np.hstack([time[:, None], *values])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=",".join(names), comments="")
    entry, _ = entry_and_account(tmp_path / "a.csv", robot="ur5")
    assert entry["role"] == "contact"
    sensed = expand(["time", "ft"])[1:]
    assert entry["columns"][4:] == (sensed if frame == "flange" else ["actual_TCP_force"])


def touched(made: Made, ur5: Robot, frame: str) -> tuple[Array, dict[str, Array]]:
    """Time and channels of a pushed arm, with the wrench in a frame and of the channel's sign.

    The base's: the arm on its surroundings; the flange's: these on the arm.
    """
    time, channels = made
    rotation, origin = link_frames(ur5, channels["actual_q"])
    axes, lever = rotation[:, :6, :, 2], origin[:, 6:] - origin[:, :6]
    force = 20 * np.sin(np.outer(time, [2.0, 3.1, 4.3]))
    torque = np.einsum("nji,ni->nj", np.cross(axes, lever), force)  # by the arm, base frame
    pushed = channels | {"actual_current": channels["actual_current"] + torque / 10}
    sensed = force if frame == "base" else -np.einsum("nji,nj->ni", rotation[:, 6], force)
    return time, pushed | {"force": sensed, "torque": 0 * sensed + 1e-6}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("frame", ["base", "flange"])
def test_the_frame_of_a_wrench_is_the_one_that_explains_the_efforts(
    tmp_path: Path, made: Made, ur5: Robot, frame: str, sign: int
) -> None:
    """Of four; ROS drivers publish flange axes and the force of the arm on its surroundings."""
    time, channels = touched(made, ur5, frame)
    write_hdf5(tmp_path / "run.h5", time, channels | {"force": sign * channels["force"]})
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert entry["role"] == "contact"
    assert f"in the {frame}'s frame" in told
    turned = {} if sign == 1 else {"units": dict.fromkeys(("ft_f", "ft_t"), "opposite")}
    if frame == "base":
        assert entry["channels"]["actual_TCP_force"] == ["run/force", "run/torque"]
        assert ("actual_TCP_force" in entry.get("units", {})) == (sign == -1)
    else:
        its = {"time": "run/time", "ft_f": "run/force", "ft_t": "run/torque"}
        assert entry["force_sensor"] == {"channels": its} | turned
        read = read_recording(entry).sensors["force"].table
        np.testing.assert_allclose(read["ft_fx"], touched(made, ur5, frame)[1]["force"][:, 0])


def dragged(ur5: Robot, along: float, borne: float) -> Made:
    """Time and channels of an arm with a force on it along its flange's motion, in flange axes.

    along: 1 where a hand leads, -1 where the arm rubs along something; borne: the share of the
    force that the drives bear, negative where they help the hand.
    """
    log = poor_log(ur5, 16, seed=3)
    time, names = log["time"].to_numpy(), ("actual_q", "actual_qd", "actual_current")
    channels = {name: channel(log, name) for name in names}
    q, qd = channels["actual_q"], channels["actual_qd"]
    jacobian = geometric_jacobian(ur5, q)[:, :3]
    velocity = np.einsum("nij,nj->ni", jacobian, qd)
    across = 6 * np.sin(np.outer(time, [2.0, 3.1, 4.3]))
    force = along * 40 * np.tanh(velocity / 0.05) + across
    motor = -borne * np.einsum("nij,ni->nj", jacobian, force) / ur5.maker_torque_constants()
    rotation = link_frames(ur5, q)[0][:, -1]
    sensed = np.einsum("nji,nj->ni", rotation, force)
    more = {"force": sensed, "torque": 0 * sensed + 1e-6}
    return time, channels | {"actual_current": channels["actual_current"] + motor} | more


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("along", "borne", "sure"),
    [(1, -0.4, "check"), (1, 1.0, "proven"), (-1, 1.0, "check")],
    ids=["a hand that drives help", "a hand against the drives", "the arm rubs along"],
)
def test_a_hand_that_leads_puts_work_in(
    tmp_path: Path, ur5: Robot, sign: int, along: float, borne: float, sure: str
) -> None:
    time, channels = dragged(ur5, along, borne)
    write_hdf5(tmp_path / "run.h5", time, channels | {"force": sign * channels["force"]})
    (one,) = import_files([tmp_path / "run.h5"], UserStatement("ur5"))
    turned = {} if sign == 1 else {"units": dict.fromkeys(("ft_f", "ft_t"), "opposite")}
    its = {"time": "run/time", "ft_f": "run/force", "ft_t": "run/torque"}
    assert one.entry["force_sensor"] == {"channels": its} | turned
    assert [row.confidence for row in one.account if row.subject == "run/force"] == [sure]


@pytest.mark.parametrize("frame", ["base", "flange"])
def test_a_sensor_may_have_forces_alone(tmp_path: Path, made: Made, ur5: Robot, frame: str) -> None:
    """In a table and in arrays; in the base's frame, there is no channel of forces alone."""
    time, channels = touched(made, ur5, frame)
    del channels["torque"]
    force = channels.pop("force")
    write_hdf5(tmp_path / "run.h5", time, channels | {"force": force})
    columns = {f"{name}_{k}": rows[:, k] for name, rows in channels.items() for k in range(6)}
    columns |= {f"F{axis}": force[:, k] for k, axis in enumerate("xyz")}
    table = pd.DataFrame({"timestamp": time} | columns)
    table.to_csv(tmp_path / "run.csv", index=False)
    arrays, stated = entry_and_account(tmp_path / "run.h5", robot="ur5")
    named, told = entry_and_account(tmp_path / "run.csv", robot="ur5")
    kept = frame == "flange"
    sensed = [name for name in named.get("columns", []) if name.startswith("ft_")]
    assert sensed == (["ft_fx", "ft_fy", "ft_fz"] if kept else [])
    assert arrays.get("force_sensor") == (
        {"channels": {"time": "run/time", "ft_f": "run/force"}} if kept else None
    )
    for words in (stated, told):
        assert f"in the {frame}'s frame" in words
        assert ("left out: " in words) != kept


def test_a_wrench_without_efforts_proves_no_frame(tmp_path: Path, made: Made, ur5: Robot) -> None:
    """Noise of a sensor, of which the efforts know nothing."""
    time, channels = touched(made, ur5, "flange")
    random = np.random.default_rng(2).normal(0, 5, channels["force"].shape)
    write_hdf5(tmp_path / "run.h5", time, made[1] | {"force": random, "torque": random / 50})
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert "actual_TCP_force" not in entry["channels"]
    assert "force_sensor" not in entry
    assert "left out: run/force, run/torque" in told


def test_zeros_of_channels_that_were_not_there_are_left_out(tmp_path: Path, made: Made) -> None:
    time, channels = made
    write_hdf5(tmp_path / "run.h5", time, channels | {"target_qdd": 0 * channels["actual_q"]})
    entry, told = entry_and_account(tmp_path / "run.h5", robot="ur5")
    assert "target_qdd" not in entry["channels"]
    assert "run/target_qdd: nothing: zero throughout, so not recorded" in told


def test_names_that_appear_twice_are_read_once(tmp_path: Path, made: Made) -> None:
    time, channels = made
    names = expand(["time", "actual_q", "actual_qd", "actual_TCP_pose"])[1:]
    values = [channels[n] for n in ("actual_q", "actual_qd", "actual_TCP_pose")]
    table = np.column_stack([time, *values, channels["actual_q"][:, 0]])
    head = ",".join(["timestamp", *names, "actual_q_0"])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header=head, comments="", fmt="%.6f")
    entry, told = entry_and_account(tmp_path / "run.csv", robot="ur5")
    assert entry["columns"] == ["time", "actual_q", "actual_qd", "actual_TCP_pose", "-"]
    assert "actual_q_0: nothing: its name appears twice" in told


def test_velocities_in_another_order_are_left_out(tmp_path: Path, made: Made) -> None:
    time, channels = made
    write_hdf5(tmp_path / "run.h5", time, channels | {"actual_qd": channels["actual_qd"][:, ORDER]})
    entry, told = entry_and_account(tmp_path / "run.h5")
    assert "actual_qd" not in entry["channels"]
    assert "check: run/actual_qd: nothing: not the derivative of run/actual_q" in told


def test_names_outdo_gravity_which_doubts_them(tmp_path: Path, made: Made) -> None:
    time, channels = shuffled(made, ORDER)
    kept = {name: channels[name] for name in ("actual_q", "actual_qd", "actual_current")}
    write_bag(tmp_path / "run.db3", time, kept)
    entry, told = entry_and_account(tmp_path / "run.db3", robot="ur5")
    assert "joints" not in entry
    assert "check: the joints' order: as named" in told
    assert "or elbow, shoulder lift, shoulder pan, wrist 1, wrist 2, wrist 3: gravity" in told


def test_an_arm_that_nothing_tells_is_asked_for(tmp_path: Path, made: Made) -> None:
    kept = {name: made[1][name] for name in ("actual_q", "actual_qd")}
    write_bag(tmp_path / "run.db3", made[0], kept)
    assert "check: robot: " in entry_and_account(tmp_path / "run.db3")[1]
    entry, told = entry_and_account(tmp_path / "run.db3", robot="ur5")
    assert entry["robot"] == "ur5"
    assert "assumed: robot: ur5: as given" in told
    assert "check: robot:" not in told


@pytest.mark.parametrize(("farthest", "lead"), [(6.2, 0.0), (9.0, IMPOSSIBLE_MOTION_PENALTY)])
def test_an_arm_that_cannot_turn_so_far_is_unlikely(farthest: float, lead: float) -> None:
    """Joint 6 of a UR3 turns without limit."""
    q = np.linspace(-1.0, 1.0, 50)[:, None] * [1, 1, 1, 1, 1, farthest]
    ur3 = load_robot(robot_path("ur3"))
    torque = gravity_torque(ur3, ur3.chosen_model, q)
    means = BlockMeans(q, np.zeros_like(q), np.zeros_like(q), None, {"effort0": torque})
    ending = ur3.model_copy(update={"name": "ending", "endless_joints": None})
    likely = readings(means, [ur3, ending], [in_order(ur3)])
    assert likely[0].score - likely[1].score == pytest.approx(lead)


def test_columns_of_nist_are_known(tmp_path: Path, made: Made) -> None:
    time, channels = made
    targets = {name.replace("actual", "target"): values for name, values in channels.items()}
    columns = {name: (targets | channels).get(name) for name in NIST_COLUMNS}
    blocks = [time[:, None]] + [
        np.zeros((len(time), 6)) if columns[name] is None else columns[name]
        for name in NIST_COLUMNS[1:]
    ]
    np.savetxt(tmp_path / "run.csv", np.hstack(blocks), delimiter=",", fmt="%.6f")
    entry, told = entry_and_account(tmp_path / "run.csv", robot="ur5")
    assert {"time", "actual_q", "target_moment"} <= {*entry["columns"]}
    assert "NIST" in told
    rows = zip(*(block.tolist() for block in blocks), strict=True)
    lines = [", ".join([str(stamp), *map(str, groups)]) for (stamp,), *groups in rows]
    (tmp_path / "run.csv").write_text(
        "\n".join(lines) + "\n"
    )  # as NIST_COLUMNS's own files group them
    assert entry_and_account(tmp_path / "run.csv", robot="ur5")[0] == entry


def test_three_commands_are_named(
    tmp_path: Path, made: Made, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """Printed entries can be pasted into a study; a written study can be read."""
    write_hdf5(tmp_path / "run.h5", *made)
    words = ["ur5", "import", str(tmp_path / "run.h5"), "--robot", "ur5"]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit, match="0"):
        cli.main()
    raw = {"study": "mine", "title": "Mine", "recordings": yaml.safe_load(capsys.readouterr().out)}
    assert parse_study(raw, "pasted").recordings[0].name == "run"
    study = tmp_path / "mine.yaml"
    monkeypatch.setattr("sys.argv", [*words, "--output", str(study)])
    with pytest.raises(SystemExit, match="0"):
        cli.main()
    assert "next: ur5 check" in capsys.readouterr().out
    assert parse_study(yaml.safe_load(study.read_text()), "written").study == "mine"


# Real recordings


def test_demonstrations_of_a_ur5e(ur5e_data: Path) -> None:
    """Two layouts; the wrench is the controller's, in the base's frame, or too weak to tell."""
    for path in sorted(ur5e_data.glob("*.h5")):
        entry, told = entry_and_account(path)
        assert entry["robot"] == "ur5e"
        assert "joints" not in entry
        assert entry["channels"]["actual_current"].endswith("joint_effort")
        weak = "2019" in path.name or "2020-07" in path.name
        assert ("actual_TCP_force" in entry["channels"]) == (not weak)
        assert entry["role"] == ("fit" if weak else "contact")
        assert ("record a push" in told) == weak


def test_bag_and_table_of_one_run_of_a_ur3_agree() -> None:
    """A lab's driver multiplied the currents in the bag (ROS 1) by constants of its own."""
    folder = shared_folder("ur3-cb", "they are recordings of a real UR3")
    files = [folder / f"_2019-11-27-20-59-11.{end}" for end in ("bag", "csv")]
    both = [import_files([file])[0].entry for file in files]
    for key in ("name", "robot", "role"):
        assert both[0][key] == both[1][key]
    bag, table = (read_recording(one).robot.table for one in both)
    assert [*bag] == [*table]
    assert both[0]["robot"] == "ur3"
    np.testing.assert_allclose(bag, table, atol=2e-6)


def test_a_bag_of_a_ur10() -> None:
    folder = shared_folder("ur10-bag", "it is a bag of a real UR10")
    entry, told = entry_and_account(folder / "ur10_exciting_trajectory.db3")
    assert entry["robot"] == "ur10"
    assert entry["channels"]["actual_current_as_torque"] == "/joint_states/effort"
    assert "actual_current_as_torque: in Nm: gravity tells Nm" in told


@pytest.mark.parametrize("kind", ["mat", "mcap"])
def test_thesis_recordings_in_other_files(tmp_path: Path, thesis: Made, kind: str) -> None:
    time, channels = thesis
    path = tmp_path / f"ur5_log.{kind}"
    if kind == "mat":
        named = {"q_actual": "actual_q", "qd_actual": "actual_qd", "i_actual": "actual_current"}
        named |= {"m_target": "target_moment", "tool_vector": "actual_TCP_pose"}
        write_mat(path, time, {name: channels[its] for name, its in named.items()})
    else:
        write_bag(path, time, {n: channels[n] for n in ("actual_q", "actual_qd", "actual_current")})
    entry, _ = entry_and_account(path)
    assert entry["robot"] == "ur5"
    assert "actual_current" in entry["channels"]
    assert "joints" not in entry


def test_logs_without_names(ur10e_data: Path) -> None:
    """Those at rest, or in which one joint moves, are read like one that moves; each has a role."""
    names = ["02_19_14harm50sec", "01_17-p1", "01_22-push_pose_1", "01_22-joint_1", "01_31-load"]
    imported = import_files([ur10e_data / f"ur-20_{name}.csv" for name in names])
    columns = ["time", "actual_q", "actual_qd", "actual_current", "target_current", "target_moment"]
    assert [one.entry["columns"] for one in imported] == [columns] * 5
    roles = ["fit", "fit", "fit", "fit", "validate"]
    assert [one.entry["role"] for one in imported] == roles
    stated = [[r.taken_for for r in one.account if r.subject == "role"] for one in imported]
    assert stated == [[role] for role in roles]
    assert {one.entry["robot"] for one in imported} == {"ur10e"}
    why = "the arm does not move, .* give a log that moves with it, or .* --columns time,actual_q,"
    with pytest.raises(InputError, match=why):
        import_files([ur10e_data / "ur-20_01_17-p1.csv"])


def test_a_log_without_names_is_refused_by_what_it_lacks(tmp_path: Path, made: Made) -> None:
    """Motion; a mode of each joint is no posture."""
    time, channels = at_rest(made)
    current = made[1]["actual_current"]
    parts = [channels["actual_q"], np.full_like(current, 253.0)]
    for name, part in zip(("resting", "moded"), parts, strict=True):
        table = np.column_stack([time, part, current])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", fmt="%.6f")
    found = dict[str, str]()
    for path in tmp_path.iterdir():
        with pytest.raises(InputError) as refused:
            import_files([path])
        found[path.stem] = str(refused.value)
    assert "if column 2 … column 7 are its joints' angles" in found["resting"]
    assert "is the derivative of another" in found["moded"]


WHOLE = ["actual_current", "target_current", "target_moment"]


@pytest.mark.parametrize(("joint", "robot"), [(1, "ur10e"), (6, "")])
def test_runs_of_one_joint(ur10e_data: Path, joint: int, robot: str) -> None:
    """What they do not prove is assumed: the order from base to wrist, the folder's arm.

    By itself, no effort of joint 1 has a unit, as gravity does not change.
    """
    entry, told = entry_and_account(ur10e_data / f"ur-20_01_22-joint_{joint}.csv", robot=robot)
    assert entry["robot"] == "ur10e"
    assert entry["columns"][:3] == ["time", "actual_q", "actual_qd"]
    assert entry["columns"][3:] == (WHOLE if joint > 1 else ["-"] * 18)
    assert joint == 6 or "check: the joints' order: base to wrist" in told


def test_a_run_of_joint_1_has_the_columns_of_another_run(ur10e_data: Path) -> None:
    paths = [ur10e_data / f"ur-20_01_22-joint_{joint}.csv" for joint in (1, 2)]
    one, other = import_files(paths, UserStatement("ur10e"))
    assert one.entry["columns"] == other.entry["columns"]
    assert other.entry["columns"][3:] == WHOLE
    assert one.entry["file"] != other.entry["file"]
    assert "columns, units and robot are those" in in_words(one.account)


def test_two_rows_without_names_are_no_recording(tmp_path: Path) -> None:
    """Between which no column has a slope to compare."""
    path = tmp_path / "torn.csv"
    path.write_text("0.0,0.1,0.2,0.3,0.4,0.5,0.6\n0.1,0.2,0.3,0.4,0.5,0.6,0.7\n")
    with pytest.raises(InputError, match=r"torn\.csv"):
        import_files([path])
