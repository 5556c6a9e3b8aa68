"""A joint that is counted with another is told by pose or gravity; described, it is read."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import ur5lib
from tests.checks.test_commanded import arm, motion
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.robots.description import Robot, robot_path
from ur5lib.robots.statics import link_frames
from ur5lib.tables import channel, write_text

__all__ = ["arm"]  # a fixture
GAP = 500  # a row without positions


@pytest.mark.parametrize("posed", [True, False])
@pytest.mark.parametrize("sign", [1.0, -1.0, 0.0])
def test_the_coupling_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arm: Robot, posed: bool, sign: float
) -> None:
    table, gravity, rubbing = motion(arm)
    q = channel(table, "actual_q")
    counted = q.copy()
    counted[:, 2] += sign * q[:, 1]
    counted[GAP] = np.nan
    at = 1e3 * link_frames(arm, q)[1][:, -1] if posed else np.empty((len(q), 0))
    names = [f"J{k}" for k in range(1, 7)] + [f"torque_{k}" for k in range(1, 7)]
    rows = np.column_stack([table["time"], np.degrees(counted), gravity + rubbing, at])
    header = ",".join(["time", *names, *(["X", "Y", "Z"] if posed else [])])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=header, comments="", fmt="%.5f")
    (found,) = import_files([tmp_path / "log.csv"], UserStatement("ur5e"))
    told = [row.taken_for for row in found.account if row.subject == "coupled axes"]
    kind = {1.0: "J3 + J2", -1.0: "J3 − J2", 0.0: ""}[sign]
    assert [kind in one for one in told] == [True] * bool(sign)
    if sign:
        assert not any("torque" in str(column) for column in found.entry["columns"])
        [remedy] = [row.reason for row in found.account if row.subject == "coupled axes"]
        monkeypatch.chdir(tmp_path)
        drives = yaml.safe_load(remedy.split("`")[1])
        described = yaml.safe_load(robot_path("ur5e").read_text()) | {"name": "counted"} | drives
        write_text(yaml.safe_dump(described), tmp_path / "robots" / "counted.yaml")
        (found,) = import_files([tmp_path / "log.csv"], UserStatement("counted"))
        assert "coupled axes" not in {row.subject for row in found.account}
        assert "actual_current_as_torque" in found.entry["columns"]
        read = ur5lib.read(tmp_path / "log.csv", "counted")["log"]
        np.testing.assert_allclose(read.q[:GAP], q[:GAP], atol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_an_arm_that_yields_at_rest_is_no_coupling(tmp_path: Path, arm: Robot, seed: int) -> None:
    table, gravity, _ = motion(arm)
    random = np.random.default_rng(seed)
    turns = table["time"].to_numpy()[:, None] * [1.0, 1.0, 1.1, 1.0, 1.0, 1.0]
    pushed = random.uniform(-20, 20, 6) * np.sin(turns)
    yielding = 1e-5 * random.uniform(0.5, 2, 6)  # rad/Nm
    q = channel(table, "actual_q")[0] + yielding * pushed
    q += 1e-6 * random.standard_normal(q.shape)
    names = [f"{name}_{k}" for name in ("actual_q", "actual_current") for k in range(6)]
    constants = np.array(arm.maker_torque_constants())
    rows = np.column_stack([table["time"], q, (gravity[0] + pushed) / constants])
    header = ",".join(["time", *names])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=header, comments="", fmt="%.5f")
    (found,) = import_files([tmp_path / "log.csv"], UserStatement("ur5e"))
    assert "coupled axes" not in {row.subject for row in found.account}
    assert "actual_current" in found.entry["columns"]
