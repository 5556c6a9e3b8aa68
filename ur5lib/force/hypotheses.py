"""Free, or in contact: what the external torque looks like under either."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ur5lib.force.external_torque import RESTING, STATES, Mask, States, finite_rows
from ur5lib.force.map_estimate import Posterior, regularised_wrench
from ur5lib.force.residual_model import ResidualModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactPrior:
    """What is known of contacts before any measurement.

    force: standard deviation of each force component [N], for hands that push with 10 to 30 N;
    lever: how far off the origin of frame 6 it pushes [m], 0 for "force only"; quiet: forces that
    are no contact [N], such as a hose's or a cable's; duration, pause: how long pushes and the
    times between them last [s]; loss: share of a contact's torque that may not reach the motors
    (harmonic drives have an efficiency of about 80 %).
    """

    force: float = 10.0
    lever: float = 0.05
    quiet: float = 1.0
    duration: float = 1.0
    pause: float = 5.0
    loss: float = 0.2

    def share(self) -> float:
        """Of the time, that is contact."""
        return self.duration / (self.duration + self.pause)

    def in_contact(self) -> Array:
        """Covariance (6, 6) of the wrench of a contact."""
        return self._covariance(self.force)

    def when_free(self) -> Array:
        """Covariance (6, 6) of the wrench that is called none."""
        return self._covariance(self.quiet)

    def _covariance(self, force: float) -> Array:
        return np.diag([force**2] * 3 + [(self.lever * force) ** 2] * 3)


@dataclass(frozen=True)
class Hypotheses:
    """Covariances of the external torque at each sample (N, 6, 6) [Nm²].

    quick: of the quick part; sticking: what stiction may take up of a contact at rest (erratum
    12), as much as the spread of the torque at rest; lost: what the gears may take up.
    """

    prior: ContactPrior
    jacobian: Array
    resting: Mask  # (N,), no joint moves
    quick: Array
    sticking: Array
    lost: Array

    @classmethod
    def of(cls, jacobian: Array, states: States, model: ResidualModel, prior: ContactPrior) -> Self:
        """From a recording's Jacobian (N, 6, 6) and joint states (N, 6)."""
        still = states % STATES == RESTING
        stuck = np.where(still, model.deviation(model.spread, states) ** 2, 0.0)
        torque = jacobian.mT @ prior.in_contact() @ jacobian
        lost = prior.loss**2 * np.diagonal(torque, axis1=1, axis2=2)
        return cls(
            prior=prior,
            jacobian=jacobian,
            resting=still.all(axis=1),
            quick=model.covariance(model.change, states),
            sticking=stuck[:, :, None] * np.eye(6),
            lost=lost[:, :, None] * np.eye(6),
        )

    def when_free(self) -> Array:
        """Of the torque besides its slow part, without contact."""
        return self.quick + self._seen(self.prior.when_free())

    def in_contact(self) -> Array:
        """Of the torque besides its slow part, in contact."""
        return self.quick + self.sticking + self.lost + self._seen(self.prior.in_contact())

    def evidence(self, torque: Array, uncertainty: Array) -> Array:
        """Log-likelihood ratio contact : free (N,) of each torque (N, 6); 0 where it is NaN.

        uncertainty: (N, 6, 6) [Nm²], of the slow part that was taken off the torque.
        """
        known = finite_rows(torque)
        torque = np.where(known[:, None], torque, 0.0)
        contact = _log_density(torque, self.in_contact() + uncertainty)
        return known * (contact - _log_density(torque, self.when_free() + uncertainty))

    def contact_wrench(self, torque: Array) -> Posterior:
        """F̂ᵐᵃᵖ of a torque besides its slow part, in contact."""
        noise = self.quick + self.sticking + self.lost
        return regularised_wrench(torque, self.jacobian, noise, self.prior.in_contact())

    def hidden_wrench(self, torque: Array) -> Array:
        """Covariance (N, 6, 6) of what may act where none shows: at rest, stiction hides it."""
        resting = self.resting[:, None, None]
        prior = np.where(resting, self.prior.in_contact(), self.prior.when_free())
        noise = self.quick + self.sticking
        return regularised_wrench(torque, self.jacobian, noise, prior).covariance

    def _seen(self, wrench: Array) -> Array:
        return self.jacobian.mT @ wrench @ self.jacobian


def _log_density(x: Array, covariance: Array) -> Array:
    """Of a normal distribution around zero, up to a constant."""
    factor = np.linalg.cholesky(covariance)
    whitened = np.linalg.solve(factor, x[..., None])[..., 0]
    diagonal = np.diagonal(factor, axis1=1, axis2=2)
    return -0.5 * (whitened**2).sum(axis=1) - np.log(diagonal).sum(axis=1)
