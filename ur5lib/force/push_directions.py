"""The smallest push that is detected in each direction, at postures of an arm."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import JointState
from ur5lib.force.gate import TorqueVariances
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.trial_contacts import Untouched, trial_pushes, unit_along
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.pushes import SPEEDS, YOURS, PushDirection
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries.arrays import Array

PLANES = {"horizontal": (0, 1), "vertical": (0, 2)}  # their axes of the base
ANGLES = np.arange(0.0, 360.0, 5.0)  # °, from the first axis of a plane


class Place(NamedTuple):
    """A time and posture of a trial push.

    recording: its name, "" of the user's own; time: [s]; q: joints (n,) [rad]; flange: (3,) [m], in
    the base; motion: name of the arm's motion then; information: A (3, 3) [1/N²], Fᵀ A F is the
    squared size of a force in standard deviations of the torques.
    """

    recording: str
    time: float
    q: Array
    flange: Array
    motion: str
    information: Array

    @property
    def reach(self) -> float:
        """Return the distance [m] of the flange from the base's origin."""
        return float(np.linalg.norm(self.flange))

    @property
    def largest_unit(self) -> float:
        """Return the force [N] of one standard deviation of the torques, in the direction that
        joints feel least.
        """
        least, *_ = np.linalg.eigvalsh(self.information)
        return float(least**-0.5) if least > 0 else np.inf


# Each is the place with the largest value; arguments: the place, and the push [N] that is detected
# in its hardest direction.
POSTURES: dict[str, Callable[[Place, float], float]] = {
    "stretched out": lambda place, _: place.reach,
    "folded": lambda place, _: -place.reach,
    "easiest": lambda _, push: -push,
    "hardest": lambda _, push: push,
}


class Needed(NamedTuple):
    """The push that is detected with 95 % probability, in units of its place, and its standard
    error.
    """

    units: float
    std_error: float


def places_of(name: str, run: Untouched, motion: Motion, kinematics: Kinematics) -> Iterator[Place]:
    """Yield the places of the first round of trial pushes in a recording."""
    _, places = trial_pushes(len(run.jacobian), run.period)
    for place, speed in run.free(places):
        middle, information = sum(place) // 2, run.information(place)
        at = motion.time[middle], motion.q[middle], kinematics.origin[middle]
        if np.isfinite(information).all():
            yield Place(name, *at, motion_at(speed), information)


def at_rest(arm: Robot, posture_deg: Sequence[float], model: ResidualModel) -> Place:
    """Return the place of an arm that rests in a posture [°]."""
    q = np.radians([posture_deg])
    _, flange, jacobian = flange_kinematics(arm, q)
    still = np.full(q.shape, JointState.STILL)
    hiding = TorqueVariances.of(still, model, np.zeros_like(q)).hiding()
    felt = jacobian[0, :3] / hiding @ jacobian[0, :3].T  # J S⁻¹ Jᵀ
    return Place("", float("nan"), q[0], flange[0], motion_at(0.0), felt)


def motion_at(speed: float) -> str:
    """Return the name of the motion (rest, slow, fast) of a flange with a speed [m/s]."""
    return SPEEDS[max(least for least in SPEEDS if least <= speed)]


def push_directions(
    places: list[Place],
    needed: Mapping[str, Needed],
    felt: float,
    most: float,
    yours: Place | None = None,
) -> Iterator[PushDirection]:
    """Yield the push that is found, by direction in each plane, at each of POSTURES, and at the
    user's own.

    needed: the push that is found, and its standard error, in standard deviations of the force, by
    motion; places in another motion are ignored. No push is stated where two standard deviations
    exceed `felt` [N], or where it exceeds `most`, the largest trial [N].
    """
    own = [(YOURS, yours)] if yours is not None and yours.motion in needed else []
    for posture, place in [*postures(places, needed), *own]:
        for plane, axes in PLANES.items():
            units = unit_along(place.information, directions(axes))
            for angle, unit in zip(ANGLES, units, strict=True):
                push, std = (float(unit) * number for number in needed[place.motion])
                is_stated = 2 * unit <= felt and push <= most
                yield PushDirection(
                    posture=posture,
                    recording=place.recording,
                    time_s=float(place.time) if place.recording else None,
                    posture_deg=" ".join(f"{joint:z.1f}" for joint in np.degrees(place.q)),
                    motion=place.motion,
                    plane=plane,
                    angle_deg=float(angle),
                    unit=float(unit) if np.isfinite(unit) else None,
                    value=push if is_stated else None,
                    std_error=std if is_stated else None,
                )


def postures(places: list[Place], needed: Mapping[str, Needed]) -> Iterator[tuple[str, Place]]:
    """Yield each of POSTURES with the place that has its largest value; a place serves only the
    first posture that selects it.
    """
    left = [place for place in places if place.motion in needed]
    pushes = [needed[place.motion].units * place.largest_unit for place in left]
    for posture, of in POSTURES.items() if len(left) >= len(POSTURES) else ():
        values = [of(place, push) for place, push in zip(left, pushes, strict=True)]
        chosen = int(np.argmax(values))
        pushes.pop(chosen)
        yield posture, left.pop(chosen)


def directions(axes: tuple[int, int]) -> Array:
    """Return the directions (K, 3) of ANGLES in the plane of two axes."""
    first, second = np.eye(3)[[*axes]]
    angles = np.radians(ANGLES)[:, None]
    return np.round(np.cos(angles) * first + np.sin(angles) * second, 15)  # exact along axes
