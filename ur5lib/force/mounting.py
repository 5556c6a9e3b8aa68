"""Check of a force sensor's mounting against the motor currents and the weight of its tool."""

import numpy as np

from ur5lib.errors import Remark, remark
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.sensor import SensorOffset
from ur5lib.timeseries.arrays import Array

# Correlation of sensor and estimate along an axis: 0.55 to 1 on six recordings, three of them real,
# and of opposite sign if the sensor is turned.
OPPOSITE = -0.5
LEAST = 1.0  # N, root mean square along an axis that is judged
SHARE = 0.05  # of the squared force: along weaker axes, the estimate is mostly cross-talk
LIGHTEST = 0.01  # kg


def opposite_axes(sensor: Array, estimate: Array, rotation: Array) -> list[str]:
    """Return the axes of frame 6 along which sensor and estimate from currents are opposite.

    sensor, estimate: forces on the arm, (N, 3) [N], base axes; rotation: R_6, (N, 3, 3). Axes
    with hardly any force are not judged.
    """
    both = finite_rows(sensor) & finite_rows(estimate)
    if not both.any():
        return []
    read, estimated = (
        np.einsum("nji,nj->ni", rotation[both], force[both]) for force in (sensor, estimate)
    )
    power, estimated_power = (read**2).mean(axis=0), (estimated**2).mean(axis=0)
    acts = (power > LEAST**2) & (power > SHARE * power.sum())
    # correlation without subtracting the means
    opposite = (read * estimated).mean(axis=0) < OPPOSITE * np.sqrt(power * estimated_power)
    return [axis for axis, wrong in zip("xyz", acts & opposite, strict=True) if wrong]


def mounting_doubt(offset: SensorOffset, opposite: list[str]) -> Remark | None:
    """Return why the sensor's mounting is doubtful: turned or of opposite sign; else None."""
    reasons = []
    if opposite:
        reasons.append(remark("opposite force", axes=opposite))
    if offset.mass < -max(LIGHTEST, 3 * offset.mass_std):
        reasons.append(remark("negative weight", mass=offset.mass, std=offset.mass_std))
    return remark("turned sensor", reasons=reasons) if reasons else None
