"""Files of arms with seven joints are imported, those of more than an arm's are refused."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import yaml
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tests.entries import in_words, read_recording
from tests.robots.test_from_urdf import made_up, saved
from tests.stored_files import write_bag
from ur5lib.commands.described import describe_urdf
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement, contents
from ur5lib.importing.files import import_files
from ur5lib.importing.parted_runs import runs_of
from ur5lib.robots.description import load_robot
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import perform
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

TIME = np.arange(500) / 500
FRANKA = """
std_msgs/Header header
float64[7] q
float64[7] dq
float64[7] tau_J
float64[7] tau_ext_hat_filtered
float64[6] O_F_ext_hat_K
float64[16] O_T_EE
"""


def sines(count: int) -> Array:
    return np.sin(np.outer(TIME, 1 + np.arange(count)))


def table(path: Path, names: list[str], rows: Array) -> Path:
    pd.DataFrame(dict(zip(names, rows.T, strict=True))).assign(time=TIME).to_csv(path, index=False)
    return path


PATTERNS = ["q_{}", "q{}", "q[{}]", "joint_pos_{}", "Joint{}_Pos", "panda_joint{}_position"]


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("count", [7, 9])
def test_positions_in_single_columns(pattern: str, count: int, tmp_path: Path) -> None:
    names = [pattern.format(k) for k in range(1, count + 1)]
    path = table(tmp_path / "run.csv", names, sines(count))
    if count == 7:
        assert [block.meaning() for block in contents(path).blocks] == ["actual_q"]
        return
    with pytest.raises(InputError, match="holds 9 joints"):
        contents(path)


def test_six_joints_beside_fingers_are_read(tmp_path: Path) -> None:
    names = [f"actual_q_{k}" for k in range(6)] + [f"gripper_position_{k}" for k in range(7)]
    path = table(tmp_path / "run.csv", names, sines(13))
    assert 6 in {block.rows.shape[1] for block in contents(path).blocks}


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Array]:
    """Motion and torques of a described arm of seven joints, with a tool that nobody declared."""
    monkeypatch.chdir(tmp_path)
    describe_urdf(saved(made_up(7), tmp_path), None, None, "mine")
    robot = load_robot("robots/mine.yaml")
    moving = {"kind": "fourier", "posture": [0.3, -0.4, 0.5, -0.3, 0.4, 0.2, -0.5]}
    tool = {"mass": 0.3}
    plan = {"trajectory": moving, "seconds": 8.0, "undeclared_payload": tool}
    done = perform(robot, SimulatedRecording.model_validate(plan), np.random.default_rng(0))
    sent = frames(done, 0.002, np.random.default_rng(1))
    names = {"q": "actual_q", "dq": "actual_qd", "tau_J": "actual_torque", "tau_J_d": "target_q"}
    return {"t": sent["time"].to_numpy()} | {
        n: np.ascontiguousarray(channel(sent, c, 7)) for n, c in names.items()
    }


def test_arrays_of_a_franka(log: dict[str, Array], tmp_path: Path) -> None:
    with h5py.File("run.h5", "w") as file:
        for name, values in log.items():
            file[f"state/{name}"] = values
        file["state/tau_ext_hat_filtered"] = np.random.default_rng(2).normal(size=log["q"].shape)
    (found,) = import_files([Path("run.h5")])
    assert found.arm == "mine"
    names = {"actual_q": "q", "actual_qd": "dq", "actual_torque": "tau_J", "time": "t"}
    assert found.entry["channels"] == {c: f"state/{name}" for c, name in names.items()}
    assert "the derivative of state/q on 7 joints" in in_words(found.account)


def test_turns_of_motors_are_no_degrees_of_joints(log: dict[str, Array], tmp_path: Path) -> None:
    """Nor does gravity, at such angles, turn a torque round or name another arm."""
    arm = yaml.safe_load(Path("robots/mine.yaml").read_text())
    for motor in arm["motors"].values():
        motor["gear_ratio"] = 100.0
    arm |= {"name": "geared", "drives": {"positions": "motor"}, "effort": "motor_torque"}
    Path("robots/geared.yaml").write_text(yaml.safe_dump(arm))
    names = [f"motor_{kind}_{k}" for kind in ("angle", "torque") for k in range(1, 8)]
    rows = np.column_stack([100 * log["q"], log["tau_J"] / 100])
    counted = pd.DataFrame(dict(zip(names, rows.T, strict=True))).assign(time=log["t"])
    counted.to_csv("run.csv", index=False)
    (found,) = import_files([Path("run.csv")], UserStatement(robot="geared"))
    assert "units" not in found.entry
    assert not {"explains", "sign"} & {*in_words(found.account).split()}


def test_columns_without_names(log: dict[str, Array]) -> None:
    """Positions are what the velocities are the derivative of; gravity proves the torques."""
    order = ("tau_J", "dq", "q")
    rows = np.column_stack([log["t"], *(log[name] for name in order)])
    np.savetxt("run.csv", rows, delimiter=",", fmt="%.8f")
    (found,) = import_files([Path("run.csv")])
    channels = ("actual_torque", "actual_qd", "actual_q")
    assert found.entry["columns"] == ["time", *(f"{c}_{k}" for c in channels for k in range(7))]


def test_numbers_that_import_gave_to_columns_are_no_names(log: dict[str, Array]) -> None:
    """A file of positions beside velocities has no order but that of its columns."""
    state = np.hstack([log["q"], log["dq"]])
    for name, rows in {"time": log["t"], "trajectory": state, "input": log["tau_J"]}.items():
        np.savetxt(f"{name}.csv", rows, delimiter=",")
    files = [Path(f"{name}.csv") for name in ("time", "trajectory", "input")]
    (found,) = import_files(runs_of(files), UserStatement(robot="mine"))
    assert found.entry["channels"]["actual_q"] == [f"trajectory.csv_{k}" for k in range(7)]
    assert "as named in" not in in_words(found.account)


def test_degrees_and_torques_of_the_opposite_sign(log: dict[str, Array]) -> None:
    columns = {"q": np.degrees(log["q"]), "dq": np.degrees(log["dq"]), "tau": -log["tau_J"]}
    table = {f"{n}_{k}": rows[:, k] for n, rows in columns.items() for k in range(7)}
    pd.DataFrame({"time": log["t"]} | table).to_csv("run.csv", index=False)
    (found,) = import_files([Path("run.csv")])
    units = {"actual_q": "deg", "actual_qd": "deg/s", "actual_torque": "opposite"}
    assert found.entry["units"] == units


def test_an_arm_that_is_not_described_is_asked_for(log: dict[str, Array]) -> None:
    Path("robots/mine.yaml").unlink()
    pd.DataFrame({f"q_{k}": log["q"][:, k] for k in range(7)}).assign(
        time=log["t"], **{f"dq_{k}": log["dq"][:, k] for k in range(7)}
    ).to_csv("run.csv", index=False)
    (found,) = import_files([Path("run.csv")])
    assert found.arm == "my_arm"
    assert "`ur5 describe arm.urdf`" in in_words(found.account)


def test_a_force_beside_seven_joints_stays_out_unless_torques_prove_it(
    log: dict[str, Array],
) -> None:
    """Here they cannot: nothing touched the arm."""
    force = 20 * np.sin(np.outer(log["t"], [2.0, 3.1, 4.3]))
    columns = {f"{n}_{k}": log[n][:, k] for n in ("q", "dq", "tau_J") for k in range(7)}
    columns |= {f"F{axis}": force[:, k] for k, axis in enumerate("xyz")}
    pd.DataFrame({"time": log["t"]} | columns).to_csv("run.csv", index=False)
    (found,) = import_files([Path("run.csv")], UserStatement("mine"))
    assert "left out: Fx" in in_words(found.account)
    assert not {"ft_fx", "actual_TCP_force"} & {*found.entry["columns"]}


def test_a_bag_of_franka_states(log: dict[str, Array], tmp_path: Path) -> None:
    path, store = tmp_path / "run.bag", get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg(FRANKA, "franka_msgs/msg/FrankaState"))
    types = store.types
    with Writer(path) as bag:
        kind = "franka_msgs/msg/FrankaState"
        topic = bag.add_connection("/franka_states", kind, typestore=store)
        rows = zip(*log.values(), strict=True)
        for k, (time, q, dq, tau, _) in enumerate(rows):
            stamp = types["builtin_interfaces/msg/Time"](*divmod(round(1e9 * time), 10**9))
            header = types["std_msgs/msg/Header"](k, stamp, "")
            message = types[kind](header, q, dq, tau, 0 * tau, q[:6], np.resize(q, 16))
            bag.write(topic, round(1e9 * time), store.serialize_ros1(message, kind))
    (found,) = import_files([path])
    assert found.entry["channels"]["actual_torque"] == "/franka_states/tau_J"
    assert found.entry["channels"]["actual_q"] == "/franka_states/q"


def test_a_bag_of_joint_states(log: dict[str, Array], tmp_path: Path) -> None:
    channels = {"actual_q": log["q"], "actual_qd": log["dq"], "effort": log["tau_J"]}
    names = [f"axis_{k}" for k in range(1, 8)]
    write_bag(tmp_path / "run.bag", log["t"], channels, names)
    (found,) = import_files([tmp_path / "run.bag"])
    assert found.entry["channels"]["actual_torque"] == "/joint_states/effort"


@pytest.mark.parametrize("named", [True, False])
def test_a_bag_has_the_order_of_the_described_joints(
    named: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the names of the user's own URDF, whatever the message's order; else as it is there."""
    monkeypatch.chdir(tmp_path)
    words = ["waist", "upper", "twist", "bend", "roll", "nod", "turn"]
    urdf = saved(made_up(7), tmp_path)
    text = urdf.read_text()
    for k, word in enumerate(words, 1):
        text = text.replace(f'"axis_{k}"', f'"{word}"')
    urdf.write_text(text)
    describe_urdf(urdf, None, None, "own_names")
    order = [4, 2, 6, 0, 1, 5, 3]
    names = [words[k] if named else "abcdefg"[k] for k in order]
    write_bag(tmp_path / "run.bag", TIME, {"actual_q": sines(7)[:, order]}, names)
    (one,) = import_files([tmp_path / "run.bag"], UserStatement("own_names"))
    table = read_recording(one.entry).robot.table
    expected = sines(7)[:, range(7) if named else order]
    np.testing.assert_allclose(channel(table, "actual_q"), expected)
    told = {row.subject: row.confidence for row in one.account}
    assert told["the joints' order"] == ("assumed" if named else "check")
