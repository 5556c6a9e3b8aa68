"""The parameters that a recording is to determine: those of an arm's torques and motor currents.

The controller's target torques are those of its link model, τ = Y β. Motor currents are
i = a T + b + c z + v q̇ + l |T| z with T = τ + Y_6 p, as `identification/currents.py` fits them:
a = 1/k is the inverse torque constant, b an offset, z = tanh(q̇/ε) the direction of dry friction, c,
v and l Coulomb, viscous and load-dependent friction over k, and p a payload's ten parameters.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.base_parameters import (
    BaseParameters,
    base_parameters,
    parameter_names,
    prior_width,
)
from ur5lib.identification.excitation import candidate_motions
from ur5lib.identification.population import Population, typical_arm
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal
from ur5lib.identification.samples import STEP as INDEPENDENT
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import BASE
from ur5lib.timeseries.arrays import Array

CORRELATED = 1.0  # s between errors of real arms that are independent, the longest of 0.3 to 1 s
DIRECTION = 0.05  # rad/s, ε, over which dry friction reaches its full size
TORQUE_NOISE = 0.02  # Nm, of target torques, unless a study has estimated it
CURRENT_NOISE = 0.01  # relative to the current at the largest torque; likewise
CONSTANT_WIDTH = 0.3  # relative standard deviation of the maker's torque constants
NOMINAL = (0.06, 0.06, 0.05)  # Coulomb, viscous friction over the largest torque; load friction
PER_JOINT = ("torque constant", "offset", "Coulomb friction", "viscous friction", "load friction")
UNITS = ("Nm/A", "Nm", "Nm", "Nm s/rad", "Nm/Nm")
PARAMETERS = parameter_names(66)  # of the links and rotors of six joints
LINK_UNITS = {"m of": "kg", "m c": "kg m", "I_": "kg m²", "rotor": "kg m²"}  # by a name's start
LINK_6 = slice(50, 60)  # of the columns of Y: a payload moves as link 6 does
SPEED, ACCELERATION = 1.5, 3.0  # rad/s, rad/s²: of the states that determine base parameters


@dataclass(frozen=True)
class Noise:
    """Standard deviations of target torques (6,) [Nm] and currents (6,) [A], every INDEPENDENT.

    Errors that are independent only every T seconds count as √(T / INDEPENDENT) times as large.
    """

    torque: Array
    current: Array


@dataclass(frozen=True)
class Maps:
    """The joints' maps from torque to current, (6, 5): a [A/Nm], b [A], c, v, l over k."""

    coefficients: Array
    noise: Noise


@dataclass(frozen=True)
class Problem:
    """The parameters θ = (β, the joints' a b c v l in turn, p) and their measurement.

    base: β, (B,); theta: (P,), nominal values; prior: (P, P), the information before any recording;
    has_payload: whether p, whose nominal value is zero, is among the parameters.
    """

    base: BaseParameters
    theta: Array
    noise: Noise
    prior: Array
    has_payload: bool

    @property
    def count(self) -> int:
        """Return the number of base parameters, B."""
        return len(self.base.columns)

    @property
    def of_currents(self) -> slice:
        """Return the place of the joints' maps to currents in θ."""
        return slice(self.count, self.count + 30)

    @property
    def of_payload(self) -> slice:
        """Return the place of the payload's parameters in θ, empty if none is estimated."""
        return slice(self.count + 30, None)

    def of_model(self, parameters: Array) -> "Problem":
        """Return the problem about other inertial parameters π (66,): another load, for example."""
        beta = self.base.groups @ parameters
        return replace(self, theta=np.concatenate([beta, self.theta[self.count :]]))

    def names(self) -> list[str]:
        """Return the parameters' names, in physical terms."""
        links = [PARAMETERS[column] for column in self.base.columns]
        joints = [f"{name} of joint {k}" for k in range(1, 7) for name in PER_JOINT]
        return [*links, *joints, *(f"payload: {PARAMETERS[k]}" for k in _payload(self.has_payload))]

    def units(self) -> list[str]:
        """Return the units of the parameters, in the order of `names`."""
        links = [PARAMETERS[column] for column in [*self.base.columns, *_payload(self.has_payload)]]
        units = [next(u for word, u in LINK_UNITS.items() if n.startswith(word)) for n in links]
        return [*units[: self.count], *UNITS * 6, *units[self.count :]]

    def measured(self, theta: Array, Y: Array, qd: Array) -> Array:
        """Return target torques and currents (N, 12) [Nm, A] over their noise, for θ (P,).

        Y: (N, 6, 66); qd: (N, 6) [rad/s].
        """
        torque, load = self._torques(theta, Y)
        a, b, c, v, per_load = theta[self.of_currents].reshape(6, 5).T
        z = np.tanh(qd / DIRECTION)
        current = a * load + b + c * z + v * qd + per_load * np.abs(load) * z
        return np.hstack([torque / self.noise.torque, current / self.noise.current])

    def rows(self, theta: Array, Y: Array, qd: Array) -> Array:
        """Return J = ∂measured/∂θ (N, 12, P); see `measured`."""
        _, load = self._torques(theta, Y)
        z, gain = self._gain(theta, load, qd)
        J = np.zeros((len(Y), 12, len(theta)))
        J[:, :6, : self.count] = Y[..., self.base.columns]
        J[:, 6:, : self.count] = Y[..., self.base.columns] * gain[..., None]
        for joint, columns in enumerate(self._joint_columns()):
            T, sign = load[:, joint], z[:, joint]
            terms = [T, np.ones(len(Y)), sign, qd[:, joint], np.abs(T) * sign]
            J[:, 6 + joint, columns] = np.stack(terms, axis=1)
        if self.has_payload:
            J[:, 6:, self.of_payload] = Y[..., LINK_6] * gain[..., None]
        return J / np.concatenate([self.noise.torque, self.noise.current])[:, None]

    def rows_with_load(self, Y: Array, qd: Array) -> Array:
        """Return ∂currents/∂(θ, p) over their noise (N, 6, P + 10), p a load's ten parameters."""
        theta = np.concatenate([self.theta, np.zeros(10)])
        return replace(self, theta=theta, has_payload=True).rows(theta, Y, qd)[:, 6:]

    def friction_current(self, Y: Array, qd: Array) -> Array:
        """Return the part (N, 6) [A] of the nominal current that friction takes."""
        a, b = self.theta[self.of_currents].reshape(6, 5).T[:2]
        current = self.measured(self.theta, Y, qd)[:, 6:] * self.noise.current
        return np.asarray(current - a * self.torque(Y) - b)

    def pull_back(self, Y: Array, qd: Array, sensitivity: Array) -> tuple[Array, Array]:
        """Return ∂f/∂Y (N, 6, 66) and ∂f/∂q̇ (N, 6) from ∂f/∂J (N, 12, P), J at the nominal θ."""
        theta, columns = self.theta, self.base.columns
        _, load = self._torques(theta, Y)
        z, gain = self._gain(theta, load, qd)
        of_torque = sensitivity[:, :6] / self.noise.torque[:, None]
        of_current = sensitivity[:, 6:] / self.noise.current[:, None]
        # J of currents = gain Y, with gain = a + l z sign T
        of_Y = np.zeros_like(Y)
        of_Y[..., columns] = of_torque[..., : self.count]
        of_Y[..., columns] += of_current[..., : self.count] * gain[..., None]
        of_gain = np.sum(of_current[..., : self.count] * Y[..., columns], axis=2)
        if self.has_payload:
            of_Y[..., LINK_6] += of_current[..., self.of_payload] * gain[..., None]
            of_gain += np.sum(of_current[..., self.of_payload] * Y[..., LINK_6], axis=2)
        # J of currents by the map of each joint = (T, 1, z, q̇, |T| z)
        parts = [of_current[:, j, c] for j, c in enumerate(self._joint_columns())]
        of_T, _, of_sign, of_rate, of_load = np.moveaxis(np.stack(parts, axis=1), -1, 0)
        per_load, sign = theta[self.of_currents].reshape(6, 5)[:, 4], np.sign(load)
        of_Y += self.pull_back_torque(of_T + of_load * z * sign)
        of_z = of_sign + of_load * np.abs(load) + of_gain * per_load * sign
        return of_Y, of_rate + of_z * (1 - z**2) / DIRECTION

    def pull_back_torque(self, sensitivity: Array) -> Array:
        """Return ∂f/∂Y (N, 6, 66) from ∂f/∂T (N, 6), T the torque of arm and nominal payload."""
        of_Y = np.zeros((*sensitivity.shape, 66))
        of_Y[..., self.base.columns] = sensitivity[..., None] * self.theta[: self.count]
        if self.has_payload:
            of_Y[..., LINK_6] += sensitivity[..., None] * self.theta[self.of_payload]
        return of_Y

    def information(self, Y: Array, qd: Array, step: float) -> Array:
        """Return Fisher's information (P, P) of a recording with samples every `step` [s].

        Jᵀ J step/INDEPENDENT, for normal errors that are independent every INDEPENDENT.
        """
        J = self.rows(self.theta, Y, qd).reshape(-1, len(self.theta))
        return J.T @ J * (step / INDEPENDENT)

    def torque(self, Y: Array) -> Array:
        """Return T (N, 6) [Nm] of arm and nominal payload."""
        return self._torques(self.theta, Y)[1]

    def standard_errors(self, information: Array) -> Array:
        """Return the standard errors (P,) of the parameters in physical units, see `UNITS`."""
        rotated = self.to_physical()
        return np.sqrt(np.diag(rotated @ np.linalg.inv(information) @ rotated.T))

    def to_physical(self) -> Array:
        """Return ∂physical/∂θ (P, P): k = 1/a, and b, c, v, l times k."""
        D = np.eye(len(self.theta))
        for columns in self._joint_columns():
            a, *others = self.theta[columns]
            block = np.diag([-1 / a**2, *[1 / a] * 4])
            block[1:, 0] = -np.array(others) / a**2
            D[columns, columns] = block
        return D

    def _torques(self, theta: Array, Y: Array) -> tuple[Array, Array]:
        """Return the link model's torque τ and the torque T with the payload, (N, 6) each [Nm]."""
        torque = Y[..., self.base.columns] @ theta[: self.count]
        if not self.has_payload:
            return torque, torque
        return torque, torque + Y[..., LINK_6] @ theta[self.of_payload]

    def _gain(self, theta: Array, load: Array, qd: Array) -> tuple[Array, Array]:
        """Return z and ∂i/∂T = a + l z sign T, (N, 6) each."""
        a, _, _, _, per_load = theta[self.of_currents].reshape(6, 5).T
        z = np.tanh(qd / DIRECTION)
        return z, a + per_load * z * np.sign(load)

    def _joint_columns(self) -> list[slice]:
        """Return the place of each joint's map in θ."""
        return [slice(self.count + 5 * k, self.count + 5 * k + 5) for k in range(6)]


def nominal_maps(robot: Robot) -> Maps:
    """Return the expected maps and noise of an arm without recordings.

    The noise has the longest correlation time of recorded arms.
    """
    constants = np.array(robot.maker_torque_constants())
    constants = np.where(np.isfinite(constants), constants, np.nanmean(constants))
    largest = np.array(robot.torque_limits())
    coulomb, viscous, load = NOMINAL
    torques = [np.ones(6), np.zeros(6), coulomb * largest, viscous * largest, np.full(6, load)]
    slow = np.sqrt(CORRELATED / INDEPENDENT)
    noise = Noise(np.full(6, slow * TORQUE_NOISE), slow * CURRENT_NOISE * largest / constants)
    return Maps(np.stack(torques, axis=1) / constants[:, None], noise)


def random_states(speed: float, acceleration: float) -> tuple[Array, Array, Array]:
    """Return random q, q̇, q̈ of all joints, (300, 6) each, up to a speed and an acceleration."""
    *_, states = candidate_motions(6, speed, acceleration, count=300).values()
    return states


def build_problem(
    robot: Robot,
    model: LinkModel,
    maps: Maps,
    has_payload: bool,
    population: Population | None = None,
) -> Problem:
    """Return the problem of an arm with a link model.

    has_payload: whether a load is estimated; population: from which friction is expected, if any.
    """
    base = base_parameters(model.regressor(*random_states(SPEED, ACCELERATION)))
    beta = base.groups @ model.parameters
    theta = np.concatenate([beta, maps.coefficients.ravel(), np.zeros(10 * has_payload)])
    prior = _prior(robot, base, maps, has_payload, population or {})
    return Problem(base, theta, maps.noise, prior, has_payload)


def _prior(
    robot: Robot, base: BaseParameters, maps: Maps, has_payload: bool, population: Population
) -> Array:
    """Return the information of the priors of the fits, before any recording."""
    spread = base.groups * prior_width(len(PARAMETERS))
    torque_max = np.array(robot.torque_limits())
    typical, inverse = typical_arm(population, torque_max), maps.coefficients[:, 0]
    ratio = typical.pop("torque_constant", None)
    if ratio is None:
        precision = np.diag((CONSTANT_WIDTH * inverse) ** -2.0)
    else:
        covariance = ratio.covariance * np.outer(inverse, inverse)
        precision = np.asarray(np.linalg.inv(covariance), dtype=np.float64)
    known = Normal(inverse, precision)
    joints = Prior(known, torque_max, typical=typical).over([BASE] * len(inverse))
    blocks = [np.linalg.inv(spread @ spread.T), joints.precision]
    width = prior_width(len(PARAMETERS))[_payload(has_payload)]
    return np.asarray(block_diag(*blocks, np.diag(width**-2.0)))


def _payload(has_payload: bool) -> range:
    """Return the columns of Y of a payload, none if no load is estimated."""
    return range(LINK_6.start, LINK_6.stop) if has_payload else range(0)
