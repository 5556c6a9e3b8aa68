"""Drawings of arms: outlines of bodies, the arm's height, all inside the frame, frames in place."""

import numpy as np
import pytest

from ur5lib.dynamics.flange import link_frames
from ur5lib.report.arm_figures import (
    UPRIGHT,
    MassModel,
    cylinder_outline,
    ellipsoid_outline,
    frame_panels,
    mass_panels,
    placed,
)
from ur5lib.robots.description import Cylinder, Robot

HEIGHT = 1.04  # m, of the UR5 in position 2 of Figure 4.1


@pytest.fixture(scope="module")
def models(ur5: Robot) -> dict[str, MassModel]:
    rotation, origin = (part[0] for part in link_frames(ur5, np.array([UPRIGHT])))
    return {name: placed(ur5, name, rotation, origin) for name in ("A", "B", "C")}


def all_outlines(model: MassModel) -> np.ndarray:
    return np.concatenate([body for link in model.outlines for body in link])


def test_a_ball_is_drawn_with_its_radius() -> None:
    outline = ellipsoid_outline(2.0, 0.4 * 2.0 * 0.3**2 * np.eye(3), np.array([9.0, 1.0, 2.0]))
    assert np.hypot(*(outline - [1.0, 2.0]).T) == pytest.approx(0.3)


@pytest.mark.parametrize(("axis", "seen"), [("x", [0.4, 0.4]), ("y", [1, 0.4]), ("z", [0.4, 1])])
def test_a_cylinder_is_drawn_with_its_height_and_diameter(axis: str, seen: list[float]) -> None:
    part = Cylinder(axis=axis, mass=1, height=1, radius=0.2, offset=(0, 0.1, 0))  # type: ignore[arg-type]
    outline = cylinder_outline(part, np.array([0.0, 1.0, 2.0]), np.eye(3))
    assert np.ptp(outline, axis=0) == pytest.approx(seen)
    assert (outline.min(axis=0) + outline.max(axis=0)) / 2 == pytest.approx([1.1, 2.0])


@pytest.mark.parametrize("name", ["A", "B", "C"])
def test_the_cylinders_are_as_high_as_the_arm(models: dict[str, MassModel], name: str) -> None:
    assert all_outlines(models[name]).max(axis=0)[1] == pytest.approx(HEIGHT, abs=0.005)


def test_every_cylinder_lies_inside_the_frame(ur5: Robot, models: dict[str, MassModel]) -> None:
    origin = link_frames(ur5, np.array([UPRIGHT]))[1][0]
    counts = {name: sum(map(len, model.outlines)) for name, model in models.items()}
    assert counts == {"A": 6, "B": 6, "C": 17}
    for axis, model in zip(mass_panels(origin, models).figure.axes, models.values(), strict=True):
        (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
        outline = all_outlines(model)
        assert (outline > [left, low]).all()
        assert (outline < [right, high]).all()


def test_an_undetermined_link_does_not_shrink_the_arm(models: dict[str, MassModel]) -> None:
    astray = models["C"]._replace(outlines=[[50 + body for body in models["C"].outlines[0]]] * 6)
    low, high = (
        mass_panels(np.zeros((7, 3)), {"C": models["C"], "astray": astray})
        .figure.axes[0]
        .get_ylim()
    )
    assert high - low < 1.5


def test_the_frames_are_those_of_the_arm(ur5: Robot) -> None:
    rotation, origin = (part[0] for part in link_frames(ur5, np.array([UPRIGHT])))
    data = frame_panels(rotation, origin, ur5.denavit_hartenberg).data
    assert data[["x [m]", "y [m]", "z [m]"]].to_numpy() == pytest.approx(origin)
    assert data.filter(like="z axis").to_numpy() == pytest.approx(rotation[:, :, 2])
    assert data["d [m]"][1:].tolist() == [0.08916, 0, 0, 0.10915, 0.09465, 0.0823]  # Table 5.2
