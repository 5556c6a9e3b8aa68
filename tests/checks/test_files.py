"""What is found of a recording's files."""

from ur5lib.checks.files import findings
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
