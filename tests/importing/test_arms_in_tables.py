"""An arm in the single columns of a table that has other joints too, or another arm."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.entries import in_words, read_recording
from tests.stored_files import JOINTS, Made, made_up_channels
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.tables import channel

UR = [f"{name}_joint" for name in JOINTS]
NUMBERED = [f"joint_{n}" for n in range(1, 7)]
CELLS = {  # joints before the arm's, the arm's, and those behind
    "a gripper": ([], UR, ["finger_joint"]),
    "a gripper first": (["robotiq_85_left_knuckle_joint"], UR, []),
    "a rail": (["rail_joint"], UR, []),
    "an axis": (["linear_axis"], NUMBERED, []),
    "a head": (["head_pan", "torso_t0"], [f"left_ur5_{n}" for n in UR], []),
    "fingers": (["p_finger_joint1"], [f"p_joint{n}" for n in range(1, 7)], ["p_finger_joint2"]),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def columns(
    pattern: str, joints: list[str], q: np.ndarray, qd: np.ndarray
) -> dict[str, np.ndarray]:
    kinds = {"position": q, "velocity": qd}
    return {
        pattern.format(n=name, kind=kind): rows[:, k]
        for kind, rows in kinds.items()
        for k, name in enumerate(joints)
    }


@pytest.mark.parametrize("by_alphabet", [False, True])
@pytest.mark.parametrize("pattern", ["{n}_{kind}", "/joint_states/{kind}/{n}"])
@pytest.mark.parametrize("cell", CELLS)
def test_other_joints_are_no_columns_of_the_arm(
    cell: str, pattern: str, by_alphabet: bool, made: Made, tmp_path: Path
) -> None:
    before, arm, behind = CELLS[cell]
    opening = 0.4 + 0.4 * np.sin(np.outer(made[0], [1.0, 1.1, 1.2]))
    table = columns(pattern, before, opening, 0 * opening)
    table |= columns(pattern, arm, made[1]["actual_q"], made[1]["actual_qd"])
    table |= columns(pattern, behind, opening, 0 * opening)
    names = sorted(table) if by_alphabet else [*table]
    pd.DataFrame({"time": made[0]} | {name: table[name] for name in names}).to_csv(
        tmp_path / "run.csv", index=False
    )
    (one,) = import_files([tmp_path / "run.csv"], UserStatement("ur5"))
    found = read_recording(one.entry).robot.table
    np.testing.assert_allclose(channel(found, "actual_q"), made[1]["actual_q"], atol=1e-9)
    assert all(name in in_words(one.account) for name in before + behind)
