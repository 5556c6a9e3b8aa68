"""What is assumed of contacts before any measurement."""

from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class ContactPrior:
    """Sizes and durations of contacts, and what motors miss of them.

    Contacts: force [N] and lever [m], the size of a usual contact and how far off the origin of
    frame 6 it acts, which each contact's own data override; sizes, levers: from which the gate
    chooses, as multiples of `force` and in [m]; quiet [N], forces that are no contact, such as a
    hose's; duration, pause: how long pushes and the times between them last [s].

    Gears: efficiency, efficiency_std, the share of a contact's torque that reaches the motors, the
    same throughout a contact; load_friction, by which share each joint differs from that; stiction,
    rubbing, what dry friction may take up of a contact at rest and in motion, as shares of the
    breakaway torque.

    Rest: hunting, by which shares of its breakaway torque a joint may wander after it was touched;
    settling, for how long [s]; unprovoked, how often [1/s] it wanders though nothing touched it.

    resolution [s]: how late or early a force that changes may be told (half of what the 2 Hz
    low-pass blurs); unnoticed: up to how many standard deviations of the force a contact in motion
    stays below the gate, as a factor on the free band.
    """

    force: float = 15.0
    lever: float = 0.03
    sizes: tuple[float, ...] = (1 / 3, 1.0, 3.0, 9.0)
    levers: tuple[float, ...] = (0.0, 0.05, 0.15)
    quiet: float = 1.0
    duration: float = 1.0
    pause: float = 10.0
    efficiency: float = 0.94
    efficiency_std: float = 0.04
    load_friction: float = 0.15
    stiction: float = 0.45
    rubbing: float = 0.2
    hunting: tuple[float, ...] = (0.1, 0.3, 0.9)
    settling: float = 3.0
    unprovoked: float = 1e-4
    resolution: float = 0.05
    unnoticed: float = 2.0

    def usual(self) -> Array:
        """Covariance (6, 6) of the wrench of a usual contact."""
        return wrench_covariance(self.force, self.lever)

    def unknown(self) -> Array:
        """Covariance (6, 6) of a contact of which nothing is known yet: three times as large."""
        return wrench_covariance(3 * self.force, self.lever)

    def when_free(self) -> Array:
        """Covariance (6, 6) of the wrench that is called none."""
        return wrench_covariance(self.quiet, self.lever)

    def bank(self) -> list[Array]:
        """Covariances (6, 6) of all kinds of contacts between which the gate chooses."""
        return [
            wrench_covariance(size * self.force, lever)
            for size in self.sizes
            for lever in self.levers
        ]


def wrench_covariance(force: float, lever: float) -> Array:
    """Covariance (6, 6) of a force [N] in any direction, and its moment by a lever [m]."""
    return np.diag([force**2] * 3 + [max(lever * force, 1e-6) ** 2] * 3)
