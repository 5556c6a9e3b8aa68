"""The assumed place of a recording's contacts in frame 6, and its source."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from ur5lib.timeseries.arrays import Array

Source = Literal["study", "tool", "tcp_offset", "actual_TCP_pose", "sensor", "payload", "none"]

TOOL_RADIUS = 0.03  # m; of a tool about its tool centre point
TOOL_WEIGHT = 20.0  # the prior on the place has the weight of this many samples of the contact
WRIST_RADIUS = 0.1  # m; of the wrist, without a tool centre point
WRIST_WEIGHT = 1.0
MIN_TCP_DISTANCE = 0.005  # m; a tool centre point closer to the flange counts as never set


@dataclass(frozen=True)
class ContactPlace:
    """The place at which contacts are assumed, as a prior on their place.

    point: [m], frame 6; within: radius [m] about it; weight: of the prior, in samples of a contact;
    source: where the point is from.
    """

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    within: float = WRIST_RADIUS
    weight: float = WRIST_WEIGHT
    source: Source = "none"

    def farther(self, distance: float) -> Self:
        """Return the place moved by a distance [m] along z of frame 6."""
        x, y, z = self.point
        return replace(self, point=(x, y, z + distance))

    def on(self, rotation: Array) -> Array:
        """Return the vector (N, 3) [m] from frame 6 to the place, base axes; rotation: R_6."""
        return np.asarray(rotation @ np.array(self.point))


@dataclass(frozen=True, kw_only=True)
class PlaceRow:
    """A row of contact_place.csv: where contacts of a recording are assumed, in frame 6, by what.

    x_m, y_m, z_m: the place, within_m of it; force_change_n: by how much the force in its alarms
    changes on average where contacts are assumed 5 cm farther along z; sensed_x_m to sensed_z_m:
    the place by the moments of a force sensor, which leave sensed_within_m.
    """

    source: Source
    x_m: float
    y_m: float
    z_m: float
    within_m: float
    force_change_n: float | None = None
    sensed_x_m: float | None = None
    sensed_y_m: float | None = None
    sensed_z_m: float | None = None
    sensed_within_m: float | None = None


def contact_place(
    stated: tuple[Sequence[float], float] | None,
    tools: dict[Source, Sequence[float] | None],
    centers: dict[Source, Sequence[float] | None],
) -> ContactPlace:
    """Return the place of contacts: by the study, else the first tool centre point, else the first
    centre; points [m], frame 6.

    stated: point and radius [m]; tools: tool centre points, ignored on the flange (never set);
    centers: of parts mounted on the flange, with contacts anywhere on the wrist.
    """
    if stated is not None:
        point, within = stated
        return ContactPlace(_point(point), within, TOOL_WEIGHT, "study")
    for source, tool in tools.items():
        if tool is not None and np.linalg.norm(tool[:3]) > MIN_TCP_DISTANCE:
            return ContactPlace(_point(tool), TOOL_RADIUS, TOOL_WEIGHT, source)
    for source, center in centers.items():
        if center is not None:
            return ContactPlace(_point(center), source=source)
    return ContactPlace()


def _point(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = map(float, values[:3])
    return x, y, z
