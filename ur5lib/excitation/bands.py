"""What another recording is worth: how wide bands are before and after it, in a user's units.

At random states, a predicted current errs by what recordings differ in, by the day, and by what is
not known of the parameters. A force at the flange has the covariance (J Σ⁻¹ Jᵀ)⁻¹, with Σ that of
the torques. A load's mass is found along as much motion again, beside the parameters.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from scipy.linalg import block_diag
from scipy.special import stdtrit

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.posterior import Earlier, problem_after
from ur5lib.excitation.problem import CORRELATED, LOAD_WIDTH, random_states
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
    """Half the 95 % bands of a force in contact [N], of a current [A] and of a load's mass [kg].

    after: name of a recording that may come next, "now" without any.
    """

    after: str
    force: float
    current: float
    mass: float


def feels_forces(arm: Robot) -> bool:
    """Return whether an arm's joints feel forces at the flange in all directions."""
    linear = flange_kinematics(arm, random_states(arm, *FAST)[0])[2][:, :3]
    return bool(np.linalg.matrix_rank(linear, tol=FELT).max() == 3)


class Outlook:
    """The bands of an arm after further recordings; of one that `feels_forces`."""

    def __init__(self, arm: Robot, known: Earlier) -> None:
        """Evaluate the arm at random states; information: of what is known, (P, P)."""
        problem, self.information = problem_after(arm, known, has_payload=False)
        q, qd, qdd = random_states(arm, PREDICTED_SPEED, PREDICTED_ACCELERATION)
        Y = LinkModel(arm, arm.fullest_model()).regressor(q, qd, qdd)
        self.problem, self._arm, self._known = problem, arm, known
        self._rows = problem.rows(problem.theta, Y, qd)[:, problem.joints :]  # over the noise
        self._friction = problem.friction_current(Y, qd)
        self._with_load = problem.rows_with_load(Y, qd)
        self._jacobian = flange_kinematics(arm, q)[2][:, :3]

    def bands(
        self, information: Array, after: str = "now", further: int = 0, other_day: bool = False
    ) -> Bands:
        """Return the bands by an information (P, P) on the parameters.

        further: recordings beyond those of the fit; other_day: whether on another day.
        """
        # of friction from day to day, as far as it is not seen
        between = BETWEEN_SEEN if other_day else BETWEEN_DAYS
        between = 0.0 if self._known.fit.days >= 2 else between
        apart = self._within(further) ** 2 + (between * self._friction) ** 2
        rows = self._rows * self.problem.noise.current[:, None]
        doubt = rows @ np.linalg.inv(information) @ rows.mT  # (N, n, n) [A²]
        current = doubt + apart[..., None] * np.eye(self.problem.joints)
        constant = 1 / self.problem.theta[self.problem.of_currents][::5]
        torque = np.linalg.inv(current * np.outer(constant, constant))
        force = np.linalg.inv(self._jacobian @ torque @ self._jacobian.mT)
        variances = (
            np.median(np.trace(force, axis1=1, axis2=2)) / 3,
            np.trace(current, axis1=1, axis2=2).mean() / self.problem.joints,
            self._mass(information, apart),
        )
        return Bands(after, *(NORMAL95 * float(np.sqrt(own)) for own in variances))

    def ranked(self, candidates: Iterable[tuple[str, Array]]) -> list[Bands]:
        """Return the bands as they are, then those after each candidate, the least force first.

        candidates: names, and what they would tell beyond the information so far, (P, P). If the
        fit has seen one day only, each is judged on another day, too.
        """
        one_day = self._known.fitted and self._known.fit.days < 2
        rows = list[Bands]()
        for name, own in candidates:
            rows.append(self.bands(self.information + own, name, 1))
            if one_day:
                other = f"{name}, on another day"
                rows.append(self.bands(self.information + own, other, 1, other_day=True))
        return [self.bands(self.information), *sorted(rows, key=attrgetter("force"))]

    def candidates(self, seconds: float) -> Iterator[tuple[str, Array]]:
        """Yield what recordings of some length would tell, (P, P)."""
        for name, load, motion in (
            ("all joints", None, FAST),
            ("all joints slowly", None, SLOW),
            ("all joints with 2 kg", LOAD, FAST),
        ):
            model = LinkModel(self._arm.carrying(load), self._arm.fullest_model())
            q, qd, qdd = random_states(self._arm, *motion)
            problem = self.problem.of_model(model.parameters)
            Y = model.regressor(q, qd, qdd)
            yield f"{seconds:g} s, {name}", problem.information(Y, qd, seconds / len(q))

    def _within(self, further: int) -> Array:
        """Return the standard deviations (n,) [A] by which recordings differ.

        The quantile of Student's t falls with their number.
        """
        count = MOVING.recordings + self._known.fitted
        quantiles = stdtrit(np.array([count, count + further]), 0.975)
        known = np.array([joint.band_moving for joint in self._known.fit.joints]) / NORMAL95
        known = np.where(np.isfinite(known), known, self.problem.noise.current)
        return np.asarray(known * quantiles[1] / quantiles[0])

    def _mass(self, information: Array, apart: Array) -> float:
        """Return the variance [kg²] of a load's mass along WEIGHED seconds of the states.

        apart: variance (N, n) [A²] of currents, independent every CORRELATED.
        """
        count = len(information)
        load = np.diag(LOAD_WIDTH**-2.0)
        relative = self.problem.noise.current / np.sqrt(apart)  # (N, n)
        J = (self._with_load * relative[..., None]).reshape(-1, count + 10)
        seconds = WEIGHED / CORRELATED / len(relative)
        whole = block_diag(information, load) + J.T @ J * seconds
        return float(np.linalg.inv(whole)[count, count])
