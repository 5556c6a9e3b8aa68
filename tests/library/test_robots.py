"""Arms as data."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from ur5lib.errors import InputError
from ur5lib.robots.description import Robot, load_robot, robot_names, robot_path
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.urdf import urdf


def test_every_described_arm_loads() -> None:
    assert "ur5" in robot_names()
    for name in robot_names():
        assert load_robot(robot_path(name)).name == name


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("masses: [3.7,", "masses: [-3.7,"),
        ("masses:", "mases:"),
        ("joints: [big,", "joints: [huge,"),
        ("axis: y", "axis: w"),
        ("gravity: [0,", "gravity: ["),
        ("name: ur5", "name: [ur5"),
    ],
)
def test_a_wrong_description_is_refused(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "arm.yaml"
    text = robot_path("ur5").read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="does not describe an arm"):
        load_robot(path)


def test_urdf_carries_masses_limits_and_names(ur5: Robot) -> None:
    model = pinocchio.buildModelFromXML(urdf(ur5, rigid_bodies(ur5, "C")))
    assert [*model.names][1:] == [f"joint_{k}" for k in range(1, 7)]
    np.testing.assert_allclose([body.mass for body in model.inertias][1:], ur5.masses)
    np.testing.assert_allclose(model.effortLimit, [150] * 3 + [28] * 3)  # Table 4.1


def test_copied_gains_are_erratum_14(ur5: Robot) -> None:
    """Equations C.2 and C.3: four of Model A's velocity gains are four of Model B's gains."""
    a, b = ur5.closed_loop_gains["A"], ur5.closed_loop_gains["B"]
    assert a.velocity[2:] == (*b.position[4:], *b.velocity[:2])
