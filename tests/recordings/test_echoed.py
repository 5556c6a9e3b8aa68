"""Messages that a command of ROS printed: in each of its forms, and damaged."""

from pathlib import Path

import numpy as np
import pytest

from tests.stored_files import JOINTS, Made, made_up_channels, write_echo
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.recordings.array_files import LOADERS
from ur5lib.recordings.echo_start import is_echoed
from ur5lib.records.quality import Finding
from ur5lib.study.address import is_study

LOST = "A message was lost!!!\n\ttotal count change:1\n\ttotal count: 1"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"), seconds=2)


@pytest.fixture
def text(tmp_path: Path, made: Made) -> str:
    kept = {n: made[1][n] for n in ("actual_q", "actual_qd", "actual_current")}
    write_echo(tmp_path / "run.yaml", made[0], kept)
    return (tmp_path / "run.yaml").read_text()


def loaded(path: Path, content: str) -> tuple[dict[str, np.ndarray], list[Finding]]:
    path.write_text(content)
    findings: list[Finding] = []
    return LOADERS["ros-echo"](path, None, findings), findings


def test_an_echoed_log_is_no_study(tmp_path: Path, text: str) -> None:
    assert is_echoed(tmp_path / "run.yaml")
    assert not is_study(str(tmp_path / "run.yaml"))
    (tmp_path / "study.yaml").write_text("study: mine\nrobot: ur5\nrecordings: []\n")
    assert is_study(str(tmp_path / "study.yaml"))


def test_forms_of_both_ros_hold_the_same(tmp_path: Path, text: str, made: Made) -> None:
    first = text.replace("    sec:", "    secs:").replace("nanosec:", "nsecs:")
    first = first.replace("header:\n", "header: \n  seq: 7\n").replace("---\n", "---\n" + LOST, 1)
    names = ",".join(JOINTS)
    lines = [
        ",".join([*map(str, divmod(round(1e9 * now), 10**9)), "base", names])
        + "".join(f",{x!r}" for n in ("actual_q", "actual_qd") for x in made[1][n][k].tolist())
        + ",nan" * 6
        for k, now in enumerate(made[0])
    ]
    for ending, content in (("yaml", text), ("txt", first), ("log", "\n".join(lines))):
        arrays, findings = loaded(tmp_path / f"any.{ending}", content)
        assert is_echoed(tmp_path / f"any.{ending}")
        assert findings == []
        np.testing.assert_allclose(arrays["joint_states/stamp"], made[0], atol=1e-6)
        np.testing.assert_allclose(arrays["joint_states/position"], made[1]["actual_q"])


def test_damaged_messages_are_counted(tmp_path: Path, text: str) -> None:
    parts = text.split("---\n")
    parts[3], parts[5] = parts[3][:40] + "\n", "position: [[[[\n"
    parts[-2] = parts[-2][:90]
    parts.pop()
    arrays, (finding,) = loaded(tmp_path / "run.yaml", "---\n".join(parts))
    assert finding.count == 3
    assert len(arrays["joint_states/stamp"]) == text.count("---\n") - 3


def test_kinds_that_are_not_read_are_named(tmp_path: Path) -> None:
    content = "header:\n  stamp:\n    sec: 1\n    nanosec: 2\npose: 3\n---\n" * 3
    with pytest.raises(InputError, match="`pose` are not read; record a bag"):
        loaded(tmp_path / "pose.yaml", content)


def test_names_tell_the_joints_order(tmp_path: Path, made: Made) -> None:
    kept = {n: made[1][n] for n in ("actual_q", "actual_qd")}
    write_echo(tmp_path / "run.yaml", made[0], kept)
    (found,) = import_files([tmp_path / "run.yaml"], UserStatement("ur5"))
    order = next(row for row in found.account if row.subject == "the joints' order")
    assert order.evidence == "name"
