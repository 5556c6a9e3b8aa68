"""Files of arms with other than six joints are refused with their number of joints."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ur5lib.errors import InputError
from ur5lib.importing.contents import contents
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


@pytest.mark.parametrize(
    "pattern", ["q_{}", "q{}", "q[{}]", "joint_pos_{}", "Joint{}_Pos", "panda_joint{}_position"]
)
@pytest.mark.parametrize("count", [7, 9])
def test_positions_in_single_columns(pattern: str, count: int, tmp_path: Path) -> None:
    names = [pattern.format(k) for k in range(1, count + 1)]
    path = table(tmp_path / "run.csv", names, sines(count))
    with pytest.raises(InputError, match=f"holds {count} joints"):
        contents(path)


def test_six_joints_beside_fingers_are_read(tmp_path: Path) -> None:
    names = [f"actual_q_{k}" for k in range(6)] + [f"gripper_position_{k}" for k in range(7)]
    path = table(tmp_path / "run.csv", names, sines(13))
    assert 6 in {block.rows.shape[1] for block in contents(path).blocks}


def test_arrays_of_a_franka(tmp_path: Path) -> None:
    """Torques are named; a file without a clock is of seven joints all the same."""
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        for name in ("q", "dq", "tau_J", "tau_ext_hat_filtered"):
            file[f"state/{name}"] = sines(7)
    with pytest.raises(InputError, match=r"7 joints: state/q .*state/tau_J"):
        contents(path)


def test_a_bag_of_franka_states(tmp_path: Path) -> None:
    path, store = tmp_path / "run.bag", get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg(FRANKA, "franka_msgs/msg/FrankaState"))
    types = store.types
    with Writer(path) as bag:
        kind = "franka_msgs/msg/FrankaState"
        topic = bag.add_connection("/franka_states", kind, typestore=store)
        for k, (time, row) in enumerate(zip(TIME, sines(7), strict=True)):
            stamp = types["builtin_interfaces/msg/Time"](0, int(1e9 * time))
            header = types["std_msgs/msg/Header"](k, stamp, "")
            message = types[kind](header, row, row, row, row, row[:6], np.resize(row, 16))
            bag.write(topic, int(1e9 * time), store.serialize_ros1(message, kind))
    with pytest.raises(InputError, match=r"7 joints: /franka_states/q .*/franka_states/tau_J"):
        contents(path)
