"""Whether the links of an exported arm can exist, as Pinocchio, MuJoCo and an XML parser read them.

Masses are positive, and of principal moments A ≤ B ≤ C about the centre of mass, A is positive and
A + B above C: nowhere is the density of the body negative (Traversaro et al. 2016).
"""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio

from ur5lib.commands.exported import exported

Links = Iterator[tuple[float, np.ndarray]]  # mass [kg], inertia tensor (3, 3) [kg m²]


def check_rigid(robot: str, model: str | None, results: Path | None = None) -> None:
    """Of an arm as it is exported in each format that has masses."""
    for to, read in (("urdf", from_urdf), ("mjcf", from_mjcf), ("sdf", from_sdf)):
        links = [*read(exported(robot, model, to, results, ""))]
        assert len(links) >= 6
        for k, (mass, inertia) in enumerate(links, 1):
            A, B, C = np.linalg.eigvalsh(inertia)
            assert mass > 0, (to, k)
            assert A > 0, (to, k)
            assert A + B > C, (to, k)


def from_urdf(text: str) -> Links:
    for link in [*pinocchio.buildModelFromXML(text).inertias][1:]:
        yield link.mass, link.inertia


def from_mjcf(text: str) -> Links:
    """Of the bodies that move; the tool, fixed to the last link, may weigh nothing."""
    engine = mujoco.MjModel.from_xml_string(text)
    for body in np.flatnonzero(engine.body_jntnum):
        yield engine.body_mass[body], np.diag(engine.body_inertia[body])


def from_sdf(text: str) -> Links:
    for link in ElementTree.fromstring(text).iter("inertial"):
        xx, xy, xz, yy, yz, zz = (float(link.findtext(f"inertia/i{axes}", "")) for axes in PAIRS)
        mass = float(link.findtext("mass", ""))
        yield mass, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


PAIRS = ("xx", "xy", "xz", "yy", "yz", "zz")
