"""Arms as data."""

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from tests.robots.test_arm_family import by_pinocchio
from ur5lib.cli import app
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import mount, rigid_bodies


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
        ("rotor_inertias: [1.61,", "rotor_inertias: [-1.61,"),
    ],
)
def test_a_wrong_description_is_refused(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "arm.yaml"
    text = robot_path("ur5").read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="is not a valid description of an arm"):
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


# Models with rotors and payloads


def test_rotors_are_a_model_more(ur5: Robot) -> None:
    bare, geared = rigid_bodies(ur5, "C"), rigid_bodies(ur5, "C+rotors")
    np.testing.assert_array_equal(bare.inertia, geared.inertia)
    assert not bare.rotor_inertia.any()
    assert geared.rotor_inertia.tolist() == [1.61, 1.62, 1.89, 0.159, 0.159, 0.160]


def test_model_names_survive_as_parts_of_column_names() -> None:
    for name in robot_names():
        assert not [model for model in load_robot(robot_path(name)).models if "_" in model]


def test_payloads_join_to_one(ur5: Robot) -> None:
    """In either order as one rigid body; none is none."""
    one = Payload(mass=0.5, center_of_mass=(0.0, 0.01, 0.02), inertia=(1e-3, 2e-3, 2e-3, 0, 0, 0))
    other = Payload(mass=1.5, center_of_mass=(0.1, -0.05, 0.03), inertia=(3e-3,) * 3 + (1e-4,) * 3)
    bodies = [
        rigid_bodies(arm, "C")
        for arm in (
            ur5.carrying(one).carrying(other),
            ur5.carrying(other.joined(one)),
            ur5.model_copy(update={"models": {"C": ur5.models["C"]}}).carrying(one.joined(other)),
        )
    ]
    point_by_point = mount(mount(rigid_bodies(ur5, "C"), one), other)
    for found in bodies:
        for part in ("mass", "center_of_mass", "inertia"):
            expected = getattr(point_by_point, part)
            np.testing.assert_allclose(getattr(found, part), expected, atol=1e-14)
    assert ur5.carrying(None) is ur5
    assert one.joined(None) is one


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -8.9), (0.0, 0.0, 10.6), (np.nan, 0.0, 9.81)])
def test_a_gravity_that_is_not_the_earth_s_is_refused(ur5: Robot, gravity: Any) -> None:
    with pytest.raises(ValidationError, match=r"a magnitude of 9 to|finite number"):
        Robot.model_validate(ur5.model_dump() | {"gravity": gravity})
    assert ur5.mounted((0, 9.81, 0)).gravity == (0, 9.81, 0)
    assert ur5.mounted(None) is ur5


def test_a_payload_and_the_flange_become_one_body(ur5: Robot) -> None:
    payload = Payload(
        mass=2, center_of_mass=(0.01, 0.02, 0.1), inertia=(0.1, 0.2, 0.15, 0.01, 0.02, 0.03)
    )
    bare, loaded = (rigid_bodies(robot, "C") for robot in (ur5, ur5.carrying(payload)))
    tensor = [[0.1, 0.01, 0.02], [0.01, 0.2, 0.03], [0.02, 0.03, 0.15]]
    flange, mounted, whole = (
        pinocchio.Inertia(mass, np.array(center), np.array(inertia))
        for mass, center, inertia in [
            (bare.mass[5], bare.center_of_mass[5], bare.inertia[5]),
            (2, payload.center_of_mass, tensor),
            (loaded.mass[5], loaded.center_of_mass[5], loaded.inertia[5]),
        ]
    )
    assert whole.isApprox(flange + mounted, 1e-14)
    np.testing.assert_array_equal(bare.inertia[:5], loaded.inertia[:5])


# Other arms, other engines

A_NEW_ARM = """\
name: bent
gravity: [0, 3, -9]
denavit_hartenberg:
  - {a: 0.1, d: 0.2, alpha: 0.3}
  - {a: 0.4, d: 0.1, alpha: -1.2}
  - {a: 0, d: 0, alpha: 1.5707963267948966}
  - {a: -0.2, d: 0.3, alpha: 3.141592653589793}
  - {a: 0, d: 0.1, alpha: -1.5707963267948966}
  - {a: 0.05, d: 0.1, alpha: 0.7}
joints: [any, any, any, any, any, any]
motors: {any: {position_max: 6, velocity_max: 3, torque_max: 100}}
masses: [5, 4, 3, 2, 1, 1]
chosen_model: only
models:
  only:
    description: nothing at right angles
    centers_of_mass: [[0.1, 0.2, 0.3], [0, 0.1, 0], [0, 0, 0.1], [0, 0, 0], [0.1, 0, 0], [0, 0, 0]]
    inertias:
      - &any [0.02, 0.03, 0.04, 0.001, 0.002, 0.003]
      - *any
      - *any
      - *any
      - *any
      - *any
    rotor_inertias: [1, 1, 1, 0.1, 0.1, 0.1]
    payload: {mass: 1, center_of_mass: [0, 0.1, 0.1]}
"""


def test_a_new_arm_is_a_file_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "bent.yaml").write_text(A_NEW_ARM)
    robot = load_robot(tmp_path / "bent.yaml")
    given = np.random.default_rng(0).uniform(-3, 3, (3, 100, 6))
    theirs = by_pinocchio(robot, rigid_bodies(robot, "only"), given)
    ours = LinkModel(robot, "only").inverse_dynamics(*given)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--robot", "ur6", "--model", "C"], "no description of `ur6`; docs/robots.md"),
        (["--robot", "UR12e"], r"no description of `UR12e` \(did you mean `ur10e`\?\)"),
        (["--robot", "my/arm.urdf"], r"describe it first, by a name: ur5 describe my/arm\.urdf"),
        (["--robot", "UR-5e"], r"no description of `UR-5e` \(did you mean `ur5e`\?\)"),
        (["--robot", "ur5", "--model", "D"], "no link model 'D'; available: A, B, C"),
        (
            ["--robot", "ur5", "--model", "C", "--format", "usd"],
            r"unknown format 'usd' \(did you mean `sdf`\?\); available: urdf",
        ),
    ],
)
def test_export_says_what_there_is(arguments: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        CliRunner().invoke(app, ["export", *arguments], catch_exceptions=False)
