"""What another recording is worth: how wide bands are before and after it, in a user's units.

At random states, a predicted current errs by what recordings differ in, by the day, and by what is
not known of the parameters. A force at the flange has the covariance (J Σ⁻¹ Jᵀ)⁻¹, with Σ that of
the torques. A load's mass is found along as much motion again, beside the parameters.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.special import stdtrit

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.posterior import Fitted
from ur5lib.excitation.problem import CORRELATED, LOAD_WIDTH, Problem, random_states
from ur5lib.excitation.questions import PREDICTED_ACCELERATION, PREDICTED_SPEED
from ur5lib.identification.current_regression import MOVING
from ur5lib.identification.currents import BETWEEN_DAYS
from ur5lib.robots.description import Payload, Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

FAST, SLOW = (1.5, 3.0), (0.2, 0.4)  # rad/s, rad/s²: of recordings that may come next
# Relative: of friction from day to day where several days show it; one day is taken for the most
# different (BETWEEN_DAYS)
BETWEEN_SEEN = 0.035
LOAD = Payload(mass=2.0, center_of_mass=(0.06, 0.0, 0.05))  # kg, m
WEIGHED = 20.0  # s, along which a load is found
FELT = 1e-6  # m; a smaller lever is none


@dataclass(frozen=True)
class Bands:
    """Half the 95 % bands of a force in contact [N], of a current [A] and of a load's mass [kg]."""

    force: float
    current: float
    mass: float


@dataclass(frozen=True)
class Next:
    """Bands after a recording that may come next; after: its name, "now" without any."""

    after: str
    force: float
    current: float
    mass: float


def feels_forces(arm: Robot) -> bool:
    """Return whether an arm's joints feel forces at the flange in all directions."""
    linear = flange_kinematics(arm, random_states(arm, *FAST)[0])[2][:, :3]
    return bool(np.linalg.matrix_rank(linear, tol=FELT).max() == 3)


class Outlook:
    """The bands of an arm by the information on its parameters; of one that `feels_forces`."""

    def __init__(self, arm: Robot, problem: Problem, fitted: Fitted) -> None:
        """Evaluate the arm at random states; problem: without a payload among its parameters."""
        q, qd, qdd = random_states(arm, PREDICTED_SPEED, PREDICTED_ACCELERATION)
        Y = LinkModel(arm, arm.fullest_model()).regressor(q, qd, qdd)
        self._arm, self._problem, self._fitted = arm, problem, fitted
        self._rows = problem.rows(problem.theta, Y, qd)[:, problem.joints :]  # over the noise
        self._friction = problem.friction_current(Y, qd)
        self._with_load = problem.rows_with_load(Y, qd)
        self._jacobian = flange_kinematics(arm, q)[2][:, :3]

    def bands(self, information: Array, further: int = 0, other_day: bool = False) -> Bands:
        """Return the bands by an information (P, P) on the parameters.

        further: recordings beyond those of the fit; other_day: whether on another day.
        """
        rows = self._rows * self._problem.noise.current[:, None]
        doubt = rows @ np.linalg.inv(information) @ rows.mT  # (N, n, n) [A²]
        apart = self._within(further) ** 2 + (self._between(other_day) * self._friction) ** 2
        current = doubt + apart[..., None] * np.eye(self._problem.joints)
        constant = 1 / self._problem.theta[self._problem.of_currents][::5]
        torque = np.linalg.inv(current * np.outer(constant, constant))
        force = np.linalg.inv(self._jacobian @ torque @ self._jacobian.mT)
        variance = {
            "force": np.median(np.trace(force, axis1=1, axis2=2)) / 3,
            "current": np.trace(current, axis1=1, axis2=2).mean() / self._problem.joints,
            "mass": self._mass(information, apart),
        }
        return Bands(**{name: NORMAL95 * float(np.sqrt(own)) for name, own in variance.items()})

    def ranked(self, earlier: Array, candidates: Iterable[tuple[str, Array]]) -> Iterator[Next]:
        """Yield the bands as they are, then those after each candidate, the least force first.

        candidates: names, and what they would tell beyond the information so far, (P, P).
        """
        yield Next("now", **vars(self.bands(earlier)))
        rows = [
            Next(name, **vars(self.bands(earlier + own, 1, other_day)))
            for candidate, own in candidates
            for name, other_day in self._days(candidate)
        ]
        yield from sorted(rows, key=lambda row: row.force)

    def candidates(self, seconds: float) -> Iterator[tuple[str, Array]]:
        """Yield what recordings of some length would tell, (P, P)."""
        for name, load, motion in (
            ("all joints", None, FAST),
            ("all joints slowly", None, SLOW),
            ("all joints with 2 kg", LOAD, FAST),
        ):
            model = LinkModel(self._arm.carrying(load), self._arm.fullest_model())
            q, qd, qdd = random_states(self._arm, *motion)
            problem = self._problem.of_model(model.parameters)
            Y = model.regressor(q, qd, qdd)
            yield f"{seconds:g} s, {name}", problem.information(Y, qd, seconds / len(q))

    def _days(self, name: str) -> Sequence[tuple[str, bool]]:
        """Return a candidate on the same day, and on another, if the fit has seen one only."""
        one_day = self._fitted.recordings and self._fitted.fit.days < 2
        return [(name, False), (f"{name}, on another day", True)] if one_day else [(name, False)]

    def _within(self, further: int) -> Array:
        """Return the standard deviations (n,) [A] by which recordings differ.

        The quantile of Student's t falls with their number.
        """
        count = MOVING.recordings + self._fitted.recordings
        quantiles = stdtrit(np.array([count, count + further]), 0.975)
        known = np.array([joint.band_moving for joint in self._fitted.fit.joints]) / NORMAL95
        known = np.where(np.isfinite(known), known, self._problem.noise.current)
        return np.asarray(known * quantiles[1] / quantiles[0])

    def _between(self, other_day: bool) -> float:
        """Return the relative deviation of friction from day to day that is not seen."""
        if self._fitted.fit.days >= 2:
            return 0.0
        return BETWEEN_SEEN if other_day else BETWEEN_DAYS

    def _mass(self, information: Array, apart: Array) -> float:
        """Return the variance [kg²] of a load's mass along WEIGHED seconds of the states.

        apart: variance (N, n) [A²] of currents, independent every CORRELATED.
        """
        count = len(information)
        load = np.diag(LOAD_WIDTH**-2.0)
        relative = self._problem.noise.current / np.sqrt(apart)  # (N, n)
        J = (self._with_load * relative[..., None]).reshape(-1, count + 10)
        seconds = WEIGHED / CORRELATED / len(relative)
        whole = block_diag(information, load) + J.T @ J * seconds
        return float(np.linalg.inv(whole)[count, count])
