"""What is found of a recording's files."""

import numpy as np

from tests.made_records import signals_of
from ur5lib.checks.files import findings, moving_joints
from ur5lib.records.account import NOTHING, AccountRow
from ur5lib.records.codes import Found
from ur5lib.records.quality import Quality


def test_each_column_that_is_left_out_is_noted() -> None:
    """Those that are taken for a channel are not."""
    account = [
        AccountRow("a, b", NOTHING, "name", "left out"),
        AccountRow("c, d", "actual_q, rad", "name", "proven"),
    ]
    noted = [
        one.place
        for one in findings(Quality(account=account))
        if one.code == Found.COLUMNS_NOT_USED
    ]
    assert noted == ["a", "b"]


def test_files_count_where_their_device_is_used() -> None:
    quality = Quality(devices=["robot"], files={"robot": "1", "imu": "2"})
    counts = {one.device: one.count for one in findings(quality) if one.code == Found.SAME_FILE}
    assert counts == {"robot": 1, "imu": 0}


def test_a_joint_moves_if_its_path_ends_more_than_a_fiftieth_apart() -> None:
    """Of a radian, wherever it is; what was not read does not count."""
    q = np.linspace(0, 1, 50)[:, None] * [0.0, 0.019, 0.021, -0.021, 3.0, 0.0]
    q[:, 5] = np.pi
    q[7] = np.nan
    assert moving_joints(signals_of(0.01 * np.arange(50), q)) == [3, 4, 5]
