"""Prior assumptions about contacts."""

from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class ContactPrior:
    """Magnitudes and durations of contacts, and losses between the contact and the motors.

    Contacts: force [N] and lever [m], magnitude of a typical contact and its distance from the
    origin of frame 6, both refined by each contact's own data; sizes: the magnitudes [N] among
    which the gate chooses, whatever is typical; quiet [N]: forces that do not count as contact,
    such as a hose's; duration, pause: mean duration of contacts and of the
    pauses between them [s].

    Gears: load_friction: relative deviation of each joint's torque, or of joints 1 to 6 (6,), from
    the part of a contact that gears transmit according to the fit; friction_std: relative deviation
    of each joint's friction in one run from that of the fit; stiction, rubbing: part of a contact
    that dry friction may absorb at rest and in motion, as shares of the breakaway torque.

    Rest: hunting: amplitudes of a joint's wandering after it was touched, as shares of the
    breakaway torque; settling: its time constant [s]; unprovoked: rate [1/s] of hunting that
    follows no contact.
    """

    force: float = 15.0
    lever: float = 0.03
    sizes: tuple[float, ...] = (5.0, 15.0, 45.0, 135.0)
    quiet: float = 1.0
    duration: float = 1.0
    pause: float = 10.0
    load_friction: float | Array = 0.1
    friction_std: float = 0.2
    stiction: float = 0.45
    rubbing: float = 0.2
    hunting: tuple[float, ...] = (0.1, 0.3, 0.9)
    settling: float = 3.0
    unprovoked: float = 1e-4

    def usual(self) -> Array:
        """Return the covariance (6, 6) of the wrench of a typical contact."""
        return wrench_covariance(self.force, self.lever)

    def unknown(self) -> Array:
        """Return the covariance (6, 6) of an unknown contact: three times the typical force."""
        return wrench_covariance(3 * self.force, self.lever)

    def when_free(self) -> Array:
        """Return the covariance (6, 6) of the wrench on an arm that counts as free."""
        return wrench_covariance(self.quiet, self.lever)

    def bank(self) -> list[Array]:
        """Return the covariances (6, 6) of all kinds of contacts among which the gate chooses."""
        return [wrench_covariance(size, self.lever) for size in self.sizes]


def wrench_covariance(force: float, lever: float) -> Array:
    """Return the covariance (6, 6) of a force [N] in any direction and a moment by a lever [m]."""
    return np.diag([force**2] * 3 + [max(lever * force, 1e-6) ** 2] * 3)
