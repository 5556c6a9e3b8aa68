"""Inertia tensors of the thesis's models: printed values, and what must hold for any cylinder."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import (
    cylinder_inertia,
    rigid_bodies,
    rigid_inertia,
    shift_inertia,
    tensor,
)

# Diagonals printed in Equations 5.7 and 5.8 [kg m²].
PRINTED_A_AND_B = [
    [0.0084, 0.0064, 0.0084],
    [0.0078, 0.2100, 0.2100],
    [0.0016, 0.0462, 0.0462],
    [0.0016, 0.0016, 0.0009],
    [0.0016, 0.0016, 0.0009],
    [0.0001, 0.0001, 0.0001],
]
PRINTED_C = [
    [0.0067, 0.0064, 0.0067],
    [0.0149, 0.3564, 0.3553],
    [0.0025, 0.0551, 0.0546],
    [0.0012, 0.0012, 0.0009],
    [0.0012, 0.0012, 0.0009],
    [0.0001, 0.0001, 0.0001],
]
sizes = st.floats(0.01, 10)


@pytest.mark.parametrize(
    ("model", "diagonals", "products"),
    [("A", PRINTED_A_AND_B, {}), ("B", PRINTED_A_AND_B, {}), ("C", PRINTED_C, {2: 0.0034})],
)
def test_tensors_are_the_printed_ones(
    ur5: Robot, model: str, diagonals: list, products: dict
) -> None:
    printed = np.stack([np.diag(diagonal) for diagonal in diagonals])
    for link, product in products.items():
        printed[link, 0, 2] = printed[link, 2, 0] = product
    assert np.array_equal(np.round(rigid_bodies(ur5, model).inertia, 4) + 0.0, printed)


@pytest.mark.parametrize("model", ["A", "B", "C"])
def test_tensors_are_those_of_a_body(ur5: Robot, model: str) -> None:
    """Positive definite, and no principal moment above the sum of the other two."""
    for inertia in rigid_bodies(ur5, model).inertia:
        moments = np.linalg.eigvalsh(inertia)
        assert moments[0] > 0
        assert moments[2] <= moments[:2].sum() * (1 + 1e-12)


NANO_UNITS = st.integers(-(10**9), 10**9).map(lambda count: count * 1e-9)  # kg m²


@given(entries=st.lists(NANO_UNITS, min_size=6, max_size=6))
def test_any_tensor_becomes_that_of_a_body(entries: list[float]) -> None:
    given = tensor(entries)
    rigid = rigid_inertia(given, 1e-5)
    moments = np.linalg.eigvalsh(rigid)
    assert moments[0] > 0
    assert moments[2] < moments[:2].sum()
    np.testing.assert_allclose(rigid - given, (rigid - given)[0, 0] * np.eye(3), atol=1e-15)
    assert rigid_inertia(rigid, 1e-6) is rigid


@given(mass=sizes, height=sizes, radius=sizes, share=st.floats(0.1, 0.9))
def test_a_cylinder_cut_in_two_keeps_its_inertia(
    mass: float, height: float, radius: float, share: float
) -> None:
    whole = cylinder_inertia("x", mass, height, radius)
    cut = share * height
    parts = [(share * mass, cut, cut / 2), ((1 - share) * mass, height - cut, (cut + height) / 2)]
    sum_of_parts = sum(
        shift_inertia(cylinder_inertia("x", m, h, radius), m, np.array([x - height / 2, 0, 0]))
        for m, h, x in parts
    )
    np.testing.assert_allclose(sum_of_parts, whole, rtol=1e-9)


@pytest.mark.parametrize(
    ("link", "axis", "height"),  # heights of the whole links: Table C.1
    [(0, 1, 0.130), (3, 2, 0.105), (4, 2, 0.105)],
)
def test_heights_of_table_c3_have_the_given_center(
    ur5: Robot, link: int, axis: int, height: float
) -> None:
    """h1 = 2 x_M - h m2 / M and h2 = h - h1 (2.54, 2.55), x_M measured from the heavy end."""
    first, second = ur5.models["C"].cylinders[link]
    shift = ur5.models["C"].centers_of_mass[link][axis]
    centroid = ur5.models["A"].centers_of_mass[link][axis]
    center = height / 2 - abs(shift - centroid)
    cut = 2 * center - height * second.mass / (first.mass + second.mass)
    np.testing.assert_allclose([cut, height - cut], [first.height, second.height], atol=5e-6)


def test_cylinders_of_model_c_leave_link_2_off_center(ur5: Robot) -> None:
    """Erratum 15: 0.93 mm, where the text says that both centres are equal."""
    parts = ur5.models["C"].cylinders[1]
    masses = np.array([part.mass for part in parts])
    center = masses @ np.array([part.offset for part in parts]) / masses.sum()
    np.testing.assert_allclose(1000 * center, [0, 0, -0.93], atol=0.005)
