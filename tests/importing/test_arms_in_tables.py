"""An arm in the single columns of a table that has other joints too, or another arm."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.entries import in_words, read_recording
from tests.stored_files import JOINTS, Made, made_up_channels
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

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


def columns(pattern: str, joints: list[str], q: Array, qd: Array) -> dict[str, Array]:
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


def both_arms(made: Made) -> dict[str, tuple[Array, Array]]:
    """Positions and velocities of two arms, of which one goes the way of the other backwards."""
    q, qd = made[1]["actual_q"], made[1]["actual_qd"]
    return {"left": (q, qd), "right": (q[::-1].copy(), -qd[::-1])}


@pytest.mark.parametrize("joints", [UR, NUMBERED])
@pytest.mark.parametrize(
    "pattern",
    [
        *("{side}_{{n}}_{{kind}}", "{{kind}}_{side}_{{n}}"),
        *("/joint_states/{{kind}}/{side}_{{n}}", "/{side}/state/{{kind}}/{{n}}"),
    ],
)
def test_each_of_two_arms_has_an_entry(
    pattern: str, joints: list[str], made: Made, tmp_path: Path
) -> None:
    table = {"time": made[0]}
    for side, (q, qd) in both_arms(made).items():
        table |= columns(pattern.format(side=side), joints, q, qd)
    pd.DataFrame(table).to_csv(tmp_path / "run.csv", index=False)
    expect_both(tmp_path / "run.csv", made)


def test_each_of_two_groups_of_arrays_has_an_entry(made: Made, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["time"] = made[0]
        for side, (q, qd) in both_arms(made).items():
            file[f"{side}_arm/q"], file[f"{side}_arm/dq"] = q, qd
    expect_both(tmp_path / "run.h5", made)


def test_an_arm_that_is_refused_leaves_the_others(made: Made, tmp_path: Path) -> None:
    """With three fingers, whose names nothing tells."""
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["time"] = made[0]
        for side, (q, _) in both_arms(made).items():
            file[f"{side}_arm/q"] = q if side == "left" else np.hstack([q, q[:, :3]])
            file[f"{side}_arm/mode"] = np.round(made[0])
    files = import_files([tmp_path / "run.h5"])
    assert [one.entry["name"] for one in files] == ["run_left"]
    assert not files.refused
    assert "check: right: nothing: arm right of" in in_words(files[0].account)


def expect_both(path: Path, made: Made) -> None:
    found = import_files([path], UserStatement("ur5"))
    assert [one.entry["name"] for one in found] == ["run_left", "run_right"]
    for one, (q, _) in zip(found, both_arms(made).values(), strict=True):
        read = channel(read_recording(one.entry).robot.table, "actual_q")
        np.testing.assert_allclose(read, q, atol=1e-9)


@pytest.mark.parametrize("other", ["observer", "desired", "filtered"])
def test_an_arm_s_state_counts_before_what_is_computed(
    other: str, made: Made, tmp_path: Path
) -> None:
    q, qd = made[1]["actual_q"], made[1]["actual_qd"]
    with h5py.File(tmp_path / "run.h5", "w") as file:
        for name, error in ((f"a_{other}/joint_states", 0.01), ("joint_states", 0.0)):
            file[f"{name}/stamp"] = made[0]
            file[f"{name}/position"], file[f"{name}/velocity"] = q + error, qd + error
    (one,) = import_files([tmp_path / "run.h5"], UserStatement("ur5"))
    channels = one.entry["channels"]
    assert channels["actual_q"] == "joint_states/position"
    assert channels["actual_qd"] == "joint_states/velocity"


def test_what_import_writes_of_two_arms_in_one_file_is_checked(
    made: Made, tmp_path: Path, run_ur5: Command
) -> None:
    """Each entry has positions of its own, so that no frame counts twice."""
    table = {"time": made[0]}
    for arm, shift in (("left", 0), ("right", 700)):
        own = (np.roll(made[1][name], shift, axis=0) for name in ("actual_q", "actual_qd"))
        table |= columns("{n}_{kind}", [f"{arm}_{name}" for name in UR], *own)
    pd.DataFrame(table).to_csv(tmp_path / "run.csv", index=False)
    study = tmp_path / "study.yaml"
    assert run_ur5("import", tmp_path / "run.csv", "-o", study).status == 0
    assert "`my_arm` stands for an arm" in run_ur5("check", study).line
    text = study.read_text().replace("my_arm", "ur5")
    study.write_text(text)
    assert run_ur5("check", study).status == 0
    copy = text[text.index("- name: ") : text.index("- name: run_right")]
    study.write_text(text + copy.replace("name: run_left", "name: again"))
    assert "run_left and again use the same" in run_ur5("check", study).line
