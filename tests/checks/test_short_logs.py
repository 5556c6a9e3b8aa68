"""A short log of an arm without described gravity tells no sign: any links would explain it."""

from dataclasses import replace

import pytest

from tests.conftest import shared_folder
from ur5lib.checks.checked import Checked
from ur5lib.checks.devices import checked_intake
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import load_robot, robot_path

SKIPPED = ["-"] * 6


@pytest.mark.parametrize("file", ["A", "B", "C"])
def test_no_part_of_a_right_log_is_stopped(file: str) -> None:
    folder = shared_folder("kuka-kr300/raw-4ms", "docs/benchmark.md names their source")
    arm = load_robot(robot_path("kuka-kr300"))
    columns = ["time", "actual_q", *SKIPPED, "actual_torque", *SKIPPED, "-", "-", "-"]
    place = {"format": "table-csv", "folder": str(folder), "file": f"{file}.csv"}
    entry = ENTRY.validate_python(place | {"columns": columns})
    table = checked_intake(read_and_repair(entry, arm, 0.1), arm).robot
    whole = Checked(table, arm, None, None, True, cutoff=2.0)
    for rows in (800, 1000, 1250, 1500, 2000, len(table)):
        for part in (table[:rows], table[-rows:]):
            assert stop_signs(replace(whole, robot=part.reset_index(drop=True))) == [], rows
