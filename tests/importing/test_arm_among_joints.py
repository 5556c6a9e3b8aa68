"""An arm among other joints: grippers, rails, heads and other arms in one message, and JSON."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

from tests.recordings.test_bags import write_messages
from ur5lib.errors import InputError
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import FileClocks
from ur5lib.importing.contents import FileContents, TableHeader, UserStatement, arm_labels
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.recordings.arm_joints import arms_among
from ur5lib.recordings.array_files import LOADERS

CASES = Path(__file__).parents[3] / "shared" / "cases-6"
UR_NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
UR = [f"{name}_joint" for name in UR_NAMES]
SEVEN = ("e0", "e1", "s0", "s1", "w0", "w1", "w2")
BAXTER = [f"{side}_{name}" for side in ("left", "right") for name in SEVEN]
FORMS: dict[str, tuple[list[str], list[Any]]] = {
    "gripper first": (["finger_joint", *UR], [("", UR)]),
    "alphabetical": (sorted([*UR, "finger_joint"]), [("", UR)]),
    "prefix": ([f"left_ur5_{n}" for n in UR], [("left_ur5", [f"left_ur5_{n}" for n in UR])]),
    "two arms": (
        [f"{side}_{n}" for n in UR for side in ("a", "b")],
        [(side, [f"{side}_{n}" for n in UR]) for side in ("a", "b")],
    ),
    "two arms, one without prefix": (
        [*UR, *(f"b_{n}" for n in UR)],
        [("", UR), ("b", [f"b_{n}" for n in UR])],
    ),
    "three fingers": ([*UR, *(f"finger_{k}_joint_1" for k in "abc")], [("", UR)]),
    "a rail": (["linear_axis_joint", *UR], [("", UR)]),
    "head and torso": (
        ["head_pan", *BAXTER, "torso_t0"],
        [
            (side, [f"{side}_{n}" for n in ["s0", "s1", "e0", "e1", "w0", "w1", "w2"]])
            for side in ("left", "right")
        ],
    ),
    "numbers": (
        [*(f"p_finger_joint{k}" for k in (1, 2)), *(f"p_joint{k}" for k in range(1, 8))],
        [("p", [f"p_joint{k}" for k in range(1, 8)])],
    ),
    "TIAGo": (
        [*(f"arm_{k}_joint" for k in range(1, 8)), "head_1_joint", "torso_lift_joint"],
        [("arm", [f"arm_{k}_joint" for k in range(1, 8)])],
    ),
    "words": (["waist", "shoulder", "upper", "fore", "gripper"], [("", 4 * [None])]),
    "no names": ([], []),
    "empty names": (["", "", "", "", "", ""], []),
}


@pytest.mark.parametrize("form", FORMS)
def test_arms_are_found_by_their_joints_names(form: str) -> None:
    names, arms = FORMS[form]
    found = arms_among(names)
    assert [(arm.label, len(arm.names)) for arm in found] == [(n, len(own)) for n, own in arms]
    for arm, (_, own) in zip(found, arms, strict=True):
        assert None in own or list(arm.names) == own


def case(name: str, stated: UserStatement | None = None) -> list[ImportedRecording]:
    if not (CASES / name).is_file():
        pytest.skip(f"no {name}")
    return import_files([CASES / name], *([stated] if stated else []))


@pytest.mark.parametrize(
    ("name", "entries", "left_out"),
    [
        ("01_arm_and_fingers.bag", [""], ["panda_finger_joint1", "panda_finger_joint2"]),
        ("02_two_publishers.bag", ["_left", "_right"], ["/joint_states/right/position"]),
        ("17_foxglove_json.mcap", [""], []),
        ("21_ur_and_finger.bag", [""], ["finger_joint"]),
    ],
)
def test_cases_have_an_entry_for_each_arm(
    name: str, entries: Sequence[str], left_out: Sequence[str]
) -> None:
    found = case(name)
    assert [one.entry["name"] for one in found] == [name.split(".")[0] + end for end in entries]
    subjects = " ".join(r.subject for r in found[0].account if r.confidence == "left out")
    assert all(one in subjects for one in left_out)
    assert all({"actual_q", "actual_qd"} <= {*one.entry["channels"]} for one in found)


def test_the_user_names_the_joints_or_the_arm() -> None:
    (one,) = case("21_ur_and_finger.bag", UserStatement(joint_names=UR))
    assert one.entry["channels"]["actual_q"] == [f"/joint_states/position/{n}" for n in UR]
    (one,) = case("02_two_publishers.bag", UserStatement(prefix="right_"))
    assert one.entry["channels"]["actual_q"] == "/joint_states/right/position"
    assert one.entry["channels"]["time"] == "/joint_states/right/stamp"


@pytest.mark.parametrize("prefix", ["left_", ""])
def test_columns_of_a_table_are_chosen_by_the_arm(tmp_path: Path, prefix: str) -> None:
    time = np.arange(0, 10, 0.02)
    header, rows = ["time"], [time]
    for side in ("right", "left"):
        for k in range(6):
            header += [f"{side}_j{k}_pos", f"{side}_j{k}_vel"]
            rows += [np.sin(time + k), np.cos(time + k)]
    table = np.column_stack(rows)
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=",".join(header), comments="")
    joints = () if prefix else [f"left_j{k}" for k in range(6)]
    (one,) = import_files([tmp_path / "a.csv"], UserStatement(joint_names=joints, prefix=prefix))
    columns = one.entry["columns"]
    assert columns[1:13] == ["-"] * 12
    assert columns[13:15] == ["actual_q_0", "actual_qd_0"]


def test_joints_that_a_file_lacks_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,q_0\n0,0\n1,1\n2,2\n")
    for stated in (UserStatement(joint_names=["elbow"]), UserStatement(prefix="left_")):
        with pytest.raises(InputError) as refused:
            import_files([tmp_path / "a.csv"], stated)
        assert "its columns are time, q_0" in str(refused.value)


def test_a_gripper_s_joint_is_no_column_of_the_arm(tmp_path: Path) -> None:
    names = ["finger_joint", *UR]
    arrays = LOADERS["rosbag"](write_messages(tmp_path / "run", [(names, 7, 7, 7)]), None, [])
    stamp = arrays["/joint_states/stamp"]
    np.testing.assert_allclose(arrays["/joint_states/position"][0] - stamp[0], np.arange(1, 7))


def write_json(path: Path, schema: str, message: dict[str, object]) -> Path:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel(
            "/a", "json", writer.register_schema(schema, "jsonschema", b"{}")
        )
        for k in range(20):
            writer.add_message(channel, k * 10**7, json.dumps(message).encode(), k * 10**7, k)
        writer.finish()
    return path


def test_json_of_another_schema_is_named(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap", "foxglove.Log", {"text": "hello"})
    with pytest.raises(InputError) as refused:
        import_files([path])
    assert "JSON messages of schema" in str(refused.value)
    assert "foxglove.Log" in str(refused.value)


def test_numbers_in_json_are_columns(tmp_path: Path) -> None:
    message = {"actual_q_0": 1.5, "interpolated": True}
    path = write_json(tmp_path / "a.mcap", "ur5lib.signals", message)
    arrays = LOADERS["rosbag"](path, None, [])
    np.testing.assert_array_equal(arrays["/a/actual_q_0"], np.full(20, 1.5))
    np.testing.assert_array_equal(arrays["/a/interpolated"], np.ones(20))


def test_a_fault_of_ours_is_no_damage_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ur5lib.recordings.messages.rows_of", lambda *_: [][0])
    monkeypatch.setattr("ur5lib.recordings.array_files.OWN_CODE", Path(__file__).parent)
    with pytest.raises(InputError) as refused:
        LOADERS["rosbag"](write_messages(tmp_path / "run", [(UR, 6, 6, 6)]), None, [])
    assert "a fault of ur5 and not of the file" in str(refused.value)
    assert str(tmp_path) in str(refused.value)


@pytest.mark.parametrize(
    ("places", "labels"),
    [
        (["/joint_states/left", "/joint_states/right"], ["left", "right"]),
        (["/ur/joint_states/arm_1", "/ur/joint_states/arm_2"], ["arm_1", "arm_2"]),
        (["/joint_states", "/motion"], []),
        (["/ur/joint_states", "/ur/motion"], []),
    ],
)
def test_topics_are_no_arms_of_one(places: list[str], labels: list[str]) -> None:
    rows = np.zeros((5, 6))
    blocks = [ColumnBlock((f"{place}/position",), rows, f"{place}/stamp") for place in places]
    file = FileContents(
        Path("run.bag"), "rosbag", TableHeader(), blocks, [], FileClocks({}, {}, {}), []
    )
    assert arm_labels(file) == labels
