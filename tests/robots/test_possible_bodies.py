"""Which inertias a body may have, and the nearest of them, by what defines both."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.command import Command
from tests.robots.test_from_urdf import made_up, planar, saved
from ur5lib.robots.description import load_robot
from ur5lib.robots.exports import urdf
from ur5lib.robots.from_urdf import PHYSICAL, robot_from_urdf
from ur5lib.robots.inertia import WRITTEN_SHARE, rigid_bodies
from ur5lib.robots.possible_bodies import impossibility, nearest_possible
from ur5lib.timeseries.arrays import Array

RANDOM = np.random.default_rng(5)


def of_points(count: int) -> Array:
    """The inertia tensor of mass points about their centre."""
    points = RANDOM.normal(0, 0.1, (count, 3))
    points -= points.mean(axis=0)
    second = points.T @ points
    return np.trace(second) * np.eye(3) - second


def any_symmetric() -> Array:
    entries = RANDOM.normal(0, 0.1, (3, 3))
    return entries + entries.T


def test_what_mass_points_have_is_possible_and_stays() -> None:
    for _ in range(50):
        inertia = of_points(8)
        assert impossibility(1.0, inertia) == ""
        np.testing.assert_allclose(nearest_possible(1.0, inertia), inertia, atol=1e-12)


@pytest.mark.parametrize(
    ("mass", "moments", "named"),
    [
        (0.0, (1, 1, 1), "its mass is 0 kg"),
        (-2.0, (1, 1, 1), "its mass is -2 kg"),
        (1.0, (0, 0, 0), "0, 0, 0 kg m², which must be positive"),
        (1.0, (0.2, 0.2, -0.1), "-0.1, 0.2, 0.2 kg m², which must be positive"),
        (1.0, (0.1, 0.2, 0.31), "0.1, 0.2, 0.31 kg m², the largest above the sum"),
        (1.0, (0.333, 0.333, 0.667), ""),  # of a sheet, rounded
    ],
)
def test_an_impossible_body_is_told_by_its_numbers(
    mass: float, moments: tuple[float, ...], named: str
) -> None:
    axes = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0]
    found = impossibility(mass, axes @ np.diag(moments) @ axes.T)
    assert named in found
    assert bool(named) == bool(found)


def test_the_nearest_is_possible_and_no_other_possible_one_is_nearer() -> None:
    """The angle between what was taken away and any other possible one is blunt."""
    for _ in range(100):
        given = any_symmetric()
        nearest = nearest_possible(1.0, given)
        assert impossibility(1.0, nearest) == ""
        np.testing.assert_allclose(nearest_possible(1.0, nearest), nearest, atol=1e-5)
        margin = 10 * WRITTEN_SHARE * np.abs(np.linalg.eigvalsh(given)).sum()
        for _ in range(20):
            other = of_points(4)
            assert np.sum((given - nearest) * (other - nearest)) <= margin


def test_a_point_becomes_a_small_body() -> None:
    nearest = nearest_possible(2.0, np.zeros((3, 3)))
    assert impossibility(2.0, nearest) == ""
    assert nearest.max() < 1e-7


def with_impossible(name: str, **entries: str) -> bytes:
    root = made_up(3)
    link = next(link for link in root.iter("link") if link.get("name") == name)
    for part in link.iter("inertia"):
        part.attrib |= entries
    return saved(root, Path()).read_bytes()


def test_describe_names_each_impossible_link_and_writes_the_nearest_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    with_impossible("link_2", izz="0.5")
    told = run_ur5("describe", "arm.urdf", "--tip", "tool", "--name", "told").out
    assert told.count("is no possible body") == told.count("by --physical") == 1
    assert "link_2 is no possible body" in told
    mended = run_ur5("describe", "arm.urdf", "--tip", "tool", "--name", "mended", "--physical").out
    assert "0.5 become" in mended
    arms = {name: load_robot(f"robots/{name}.yaml") for name in ("told", "mended")}
    assert [*arms["told"].models] == ["maker"]
    assert [*arms["mended"].models] == ["maker", PHYSICAL]
    assert arms["mended"].chosen_model == PHYSICAL
    assert arms["mended"].models["maker"] == arms["told"].models["maker"]
    head = Path("robots/mended.yaml").read_text().split("\nname")[0]
    assert "0.5 become" in head
    before, after = (rigid_bodies(arms["mended"], name) for name in ("maker", PHYSICAL))
    np.testing.assert_allclose(after.inertia[[0, 2]], before.inertia[[0, 2]], atol=1e-12)
    np.testing.assert_array_equal(after.mass, before.mass)
    np.testing.assert_array_equal(after.center_of_mass, before.center_of_mass)


def test_a_simulator_takes_the_nearest_and_not_the_file(tmp_path: Path) -> None:
    root = planar(3)
    inertia = next(part for part in root.iter("inertia"))
    inertia.set("izz", "0.2")
    path = saved(root, tmp_path)
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_path(str(path))
    robot, _ = robot_from_urdf(path, physical=True)
    written = urdf(robot, rigid_bodies(robot, PHYSICAL), None)
    assert mujoco.MjModel.from_xml_string(written).nv == 3


@pytest.mark.parametrize("mass", ["0", "-2"])
def test_a_link_without_mass_is_told_and_left_out(mass: str, tmp_path: Path) -> None:
    """Its bracket, which is fixed to it, is the body."""
    root = made_up(3)
    whole = robot_from_urdf(saved(root, tmp_path))[0]
    link = next(link for link in root.iter("link") if link.get("name") == "link_2")
    next(link.iter("mass")).set("value", mass)
    robot, remarks = robot_from_urdf(saved(root, tmp_path))
    assert any(f"link_2 is no possible body: its mass is {mass} kg" in line for line in remarks)
    assert 0 < robot.masses[1] < whole.masses[1]
