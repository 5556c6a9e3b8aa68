"""Collisions of an arm with itself and its surroundings, by capsules around its links, in MuJoCo.

They are coarse: for a warning before an arm moves, not for planning close to obstacles.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import mujoco
import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Positive, Robot, Vector3
from ur5lib.robots.mjcf import add_arm, add_capsules
from ur5lib.robots.statics import link_frames
from ur5lib.strict import Strict
from ur5lib.timeseries.arrays import Array, Mask

HOUSING_HEIGHT = 0.02  # m; the joints' housings protrude this far from the capsules
# m; links of arms other than UR keep this distance unless they overlap by construction.
MIN_FREE_SPACE = 0.05  # m
OVERLAP_POSTURES = 100  # random ones, to find the parts that overlap by construction
TABLE_NAME = "table"


class Box(Strict):
    """An obstacle near an arm: a box with edges along the base axes [m]."""

    model_config = ConfigDict(allow_inf_nan=False)

    center: Vector3 = Field(description="of the box, base frame [m]")
    size: tuple[Positive, Positive, Positive] = Field(description="lengths of its edges [m]")


class Surroundings(Strict):
    """The obstacles near an arm, in the base frame.

    table: height of a horizontal plane [m], None for none; normal to the described gravity.
    """

    model_config = ConfigDict(allow_inf_nan=False)

    table: float | None = None
    boxes: list[Box] = Field([], max_length=100)


@dataclass(frozen=True)
class Clearances:
    """M pairs of parts of an arm or its surroundings that are near each other along a path.

    sample: at which they are (M,); distance: (M,) [m], negative for overlap; gradient: (M, n)
    [m/rad], of the distance by the joints' angles, zero above the distance `gradient_below` of
    `near`; pairs: (M,), names of the parts.
    """

    sample: NDArray[np.intp]
    distance: Array
    gradient: Array
    pairs: list[tuple[str, str]]


def collisions(robot: Robot, q: Array, table: float | None) -> list[tuple[int, str, str]]:
    """Return the first collision of each pair of parts along a path: sample and both parts.

    q: (N, n) [rad], so dense that no collision is skipped; table: height of a horizontal plane
    above the base frame [m], None for none. Parts, `link_1` to the last one and the plane `table`,
    collide if they are closer than HOUSING_HEIGHT.
    """
    first = dict[tuple[str, str], int]()
    clearances = Capsules(robot, Surroundings(table=table), reach=HOUSING_HEIGHT).near(q)
    for sample, pair in zip(clearances.sample, clearances.pairs, strict=True):
        first.setdefault(pair, int(sample))
    return [(sample, *pair) for pair, sample in first.items()]


class Capsules:
    """A model of an arm as capsules, and of its surroundings, in which parts that are near each
    other are found.
    """

    def __init__(self, robot: Robot, surroundings: Surroundings, reach: float) -> None:
        """Build the model; reach: distance [m] below which two parts count as near."""
        self._model = _capsules(robot, surroundings, reach)
        self._data = mujoco.MjData(self._model)

    def near(self, q: Array, gradient_below: float = -np.inf) -> Clearances:
        """Return the parts that are near each other along a path q (N, n) [rad].

        gradient_below: gradients are computed for parts closer than this distance [m].
        """
        count = np.zeros(len(q), dtype=np.intp)
        distance, slopes, geoms = [np.empty(0)], list[Array](), [np.empty((0, 2), dtype=np.intp)]
        for k, self._data.qpos in enumerate(q):
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_collision(self._model, self._data)
            count[k] = self._data.ncon
            if count[k]:
                contacts = self._data.contact
                distance.append(contacts.dist.copy())
                geoms.append(contacts.geom.copy())
                slopes.append(self._gradients(distance[-1] < gradient_below))
        return Clearances(
            np.repeat(np.arange(len(q)), count),
            np.concatenate(distance),
            np.concatenate([np.empty((0, self._model.nv)), *slopes]),
            self._names(np.concatenate(geoms)),
        )

    def _names(self, geoms: NDArray[np.intp]) -> list[tuple[str, str]]:
        """Return the names of pairs of parts (M, 2), each pair in alphabetical order."""
        names = np.array([self._model.geom(k).name for k in range(self._model.ngeom)])
        return [(first, second) for first, second in np.sort(names[geoms], axis=1).tolist()]

    def _gradients(self, needs_gradient: Mask) -> Array:
        """Return the gradients (M, n) [m/rad] of the contacts' distances by the joints' angles,
        zero if not needed.
        """
        gradients = np.zeros((len(needs_gradient), self._model.nv))
        if needs_gradient.any():
            mujoco.mj_comPos(self._model, self._data)  # needed by Jacobians
        for k in np.flatnonzero(needs_gradient):
            gradients[k] = self._gradient(self._data.contact[k])
        return gradients

    def _gradient(self, contact: mujoco.MjContact) -> Array:
        """Return the gradient ∂distance/∂q (n,) of a contact, e · (J_2 - J_1), with e from the
        first part to the second.
        """
        first, second = (self._jacobian(geom, contact.pos) for geom in contact.geom)
        return np.asarray(contact.frame[:3] @ (second - first))

    def _jacobian(self, geom: int, point: Array) -> Array:
        """Return the Jacobian J_v (3, n) of the velocity of a point [m] fixed to a part."""
        jacobian = np.zeros((3, self._model.nv))
        mujoco.mj_jac(self._model, self._data, jacobian, None, point, self._model.geom_bodyid[geom])
        return jacobian


def _capsules(robot: Robot, surroundings: Surroundings, reach: float) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    add_arm(spec, robot, robot.chosen_model)
    radii = add_capsules(spec, robot)
    _add_surroundings(spec, surroundings, _vertical(robot))
    for first, second in _overlapping_pairs(robot, radii, surroundings.table):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    for geom in spec.geoms:
        geom.margin = reach / 2  # MuJoCo adds the margins of both parts
    return spec.compile()


def _vertical(robot: Robot) -> Array:
    """Return the upward vertical (3,), base frame."""
    return -np.array(robot.gravity) / np.linalg.norm(robot.gravity)


def _overlapping_pairs(
    robot: Robot, radii: Array, table: float | None
) -> Iterator[tuple[str, str]]:
    """Yield the pairs of bodies that always overlap by their construction, so that no collision is
    reported.

    For a UR, these are each link and the next one, in the wrist up to three apart, and link 1 and
    the table. For another arm, these are links with ends near each other in all random postures,
    and links that begin just above the table in all of them. radii: (n,) [m].
    """
    ends = np.clip(robot.position_limits(), -np.pi, np.pi)
    q = np.random.default_rng(0).uniform(ends[:, 0], ends[:, 1], (OVERLAP_POSTURES, len(radii)))
    origins = link_frames(robot, q)[1]  # link k reaches from origin k - 1 to origin k
    for first, second in combinations(range(len(radii)), 2):
        distance = np.linalg.norm(origins[:, first + 1] - origins[:, second], axis=1).max()
        alike = distance < radii[first] + radii[second] + MIN_FREE_SPACE
        if second - first <= (3 if first >= 2 else 1) if robot.is_ur() else alike:
            yield f"link_{first + 1}", f"link_{second + 1}"
    if table is not None:
        height = origins @ _vertical(robot) - table
        for k, radius in enumerate(radii):
            low = (
                height[:, k].min() > -MIN_FREE_SPACE
                and height[:, k].max() < radius + MIN_FREE_SPACE
            )
            if k == 0 or (low and not robot.is_ur()):
                yield "world", f"link_{k + 1}"


def _add_surroundings(spec: mujoco.MjSpec, surroundings: Surroundings, up: Array) -> None:
    """Add the table and the boxes, each a body of its own; up: the vertical (3,), base frame."""
    if surroundings.table is not None:
        plane = spec.worldbody.add_geom(name=TABLE_NAME, type=mujoco.mjtGeom.mjGEOM_PLANE)
        plane.size, plane.pos = [5, 5, 1], surroundings.table * up
        plane.quat = Rotation.align_vectors([up], [[0, 0, 1]])[0].as_quat(scalar_first=True)
    for k, box in enumerate(surroundings.boxes, start=1):
        body = spec.worldbody.add_body(name=f"box_{k}", pos=box.center)
        half = [edge / 2 for edge in box.size]
        body.add_geom(name=f"box_{k}", type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
