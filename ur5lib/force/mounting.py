"""Whether a force sensor is mounted as it is read: by the motor currents, and by its tool."""

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.force.sensor import SensorOffset
from ur5lib.timeseries.arrays import Array

# Correlation of sensor and estimate along an axis: 0.55 to 1 on six recordings, three of them real,
# and the opposite of it where the sensor is turned.
OPPOSITE = -0.5
LEAST = 1.0  # N, root mean square along an axis that tells something
SHARE = 0.05  # of the squared force: along other axes, an estimate shows what leaks into them
LIGHTEST = 0.01  # kg


def opposite_axes(sensor: Array, estimate: Array, rotation: Array) -> list[str]:
    """Axes of frame 6 along which a sensor and an estimate from currents say the opposite.

    sensor, estimate: forces on the arm, (N, 3) [N], base axes; rotation: R_6, (N, 3, 3). Axes
    along which hardly any force acts are not judged.
    """
    both = finite_rows(sensor) & finite_rows(estimate)
    if not both.any():
        return []
    read, told = (
        np.einsum("nji,nj->ni", rotation[both], force[both]) for force in (sensor, estimate)
    )
    power, its_power = (read**2).mean(axis=0), (told**2).mean(axis=0)
    acts = (power > LEAST**2) & (power > SHARE * power.sum())
    opposite = (read * told).mean(axis=0) < OPPOSITE * np.sqrt(power * its_power)
    return [axis for axis, wrong in zip("xyz", acts & opposite, strict=True) if wrong]


def mounting_doubt(offset: SensorOffset, opposite: list[str]) -> str | None:
    """Why the sensor seems turned, upside down or of the opposite sign; None where it does not."""
    reasons = []
    if opposite:
        reasons.append(
            f"along {', '.join(opposite)} of frame 6 it says the opposite of the motor currents"
        )
    if offset.mass < -max(LIGHTEST, 3 * offset.mass_std):
        reasons.append(f"its tool pulls upwards ({offset.mass:.2g} ± {offset.mass_std:.1g} kg)")
    if not reasons:
        return None
    return (
        f"{' and '.join(reasons)}: it may be upside down or of the opposite sign; "
        "turn its readings into the axes of frame 6"
    )
