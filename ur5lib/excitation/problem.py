"""The parameters that a recording is to determine: those of an arm's torques and motor currents.

A UR's target torques are those of its controller's link model, τ = Y β. Motor currents are i = a T
+ b + c z + v q̇ + l |T| z with T = τ + Y_n p, as `identification/currents.py` fits them: a = 1/k is
the inverse torque constant, b an offset, z = tanh(q̇/ε) the direction of dry friction, c, v and l
Coulomb, viscous and load-dependent friction over k, and p the ten parameters of a payload, which
moves with link n. Torque sensors replace currents with a k of nearly 1, and with the little
friction between them and the links.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from ur5lib.channels import CURRENT, Effort
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.identification.base_parameters import (
    LINK_PARAMETERS,
    PARAMETERS_PER_JOINT,
    BaseParameters,
    base_parameters,
    prior_width,
)
from ur5lib.identification.excitation import candidate_motions
from ur5lib.identification.prior import Prior, typical_friction
from ur5lib.identification.regression import Normal
from ur5lib.identification.samples import INDEPENDENT_STEP
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import BASE_TERMS
from ur5lib.timeseries.arrays import Array

# Errors of real arms are correlated over 0.3 to 1 s; this is the longest.
CORRELATION_TIME = 1.0  # s
DIRECTION_SPEED = 0.05  # rad/s; ε, at which dry friction reaches its full size
TORQUE_NOISE = 0.02  # Nm; target torques have this noise, unless a study has estimated it
CURRENT_NOISE = 0.01  # noise of currents, relative to the current at the largest torque
CONSTANT_WIDTH = 0.3  # relative standard deviation of a maker's torque constants
UR_CONSTANT_WIDTH = 0.1  # CONSTANT_WIDTH of a UR's motors
# Coulomb and viscous friction over the largest torque; load friction.
NOMINAL_FRICTION = (0.06, 0.06, 0.05)
SENSED_FRICTION_SHARE = 0.05  # a torque sensor sees this share of its joint's friction and offset
SENSOR_NOISE = 0.003  # residual of fits to two real arms' sensors over the largest torque
GAIN_WIDTH = 0.03  # standard deviation of calibrated torque sensors' gains
JOINT_PARAMETERS = (
    "torque constant",
    "offset",
    "Coulomb friction",
    "viscous friction",
    "load friction",
)
# An arm with torque sensors has these parameters of each joint.
SENSED_JOINT_PARAMETERS = ("gain", "bias", *JOINT_PARAMETERS[2:])
UNITS_BY_START = {  # units of parameters, by the start of their names
    **{"m of": "kg", "m c": "kg m", "I_": "kg m²", "rotor": "kg m²"},
    **dict(zip(JOINT_PARAMETERS, ("Nm/A", "Nm", "Nm", "Nm s/rad", "Nm/Nm"), strict=True)),
    **{"gain": "Nm/Nm", "bias": "Nm"},
}
PAYLOAD_PREFIX = "payload: "
# Standard deviations of a load's ten parameters.
LOAD_WIDTH = prior_width(PARAMETERS_PER_JOINT)[: len(LINK_PARAMETERS)]
# Forces are estimated at states up to these.
PREDICTED_SPEED = 1.0  # rad/s
PREDICTED_ACCELERATION = 2.0  # rad/s²
# Random states up to these determine base parameters.
RANK_TEST_SPEED = 1.5  # rad/s
RANK_TEST_ACCELERATION = 3.0  # rad/s²


@dataclass(frozen=True)
class MeasurementNoise:
    """Standard deviations of target torques (n,) [Nm] and currents (n,) [A].

    They are for errors that are independent every INDEPENDENT_STEP; errors that are independent
    every T seconds have √(T / INDEPENDENT_STEP) times the deviation. Target torques that the
    controller does not state have an infinite one.
    """

    torque: Array
    current: Array


@dataclass(frozen=True)
class Maps:
    """The joints' maps from torque to motor current, with their noise; coefficients: (n, 5), the
    columns a [A/Nm], b [A], c, v, l of the module's equation.
    """

    coefficients: Array
    noise: MeasurementNoise


@dataclass(frozen=True)
class DesignProblem:
    """The parameters θ = (β, the joints' a b c v l in turn, p) and their measurement.

    base: β, (B,); theta: (P,), nominal values; prior: (P, P), the information before any recording;
    has_payload: whether p, nominally zero, is among the parameters; effort: measured quantity.
    """

    base: BaseParameters
    theta: Array
    noise: MeasurementNoise
    prior: Array
    has_payload: bool
    effort: Effort = CURRENT

    @property
    def joints(self) -> int:
        """Return the number of joints, n."""
        return len(self.noise.current)

    @property
    def count(self) -> int:
        """Return the number of base parameters, B."""
        return len(self.base.columns)

    @property
    def of_currents(self) -> slice:
        """Return the place of the joints' maps to currents in θ."""
        return slice(self.count, self.count + 5 * self.joints)

    @property
    def of_payload(self) -> slice:
        """Return the place of the payload's parameters in θ, empty if none is estimated."""
        return slice(self.count + 5 * self.joints, None)

    @property
    def of_last_link(self) -> slice:
        """Return the place of the last link in the columns of Y: a payload moves as it does."""
        return slice(len(LINK_PARAMETERS) * (self.joints - 1), len(LINK_PARAMETERS) * self.joints)

    def of_model(self, parameters: Array) -> "DesignProblem":
        """Return the problem with the inertial parameters π (11 n,) of another link model, such as
        one with another load.
        """
        beta = self.base.groups @ parameters
        return replace(self, theta=np.concatenate([beta, self.theta[self.count :]]))

    def names(self) -> list[str]:
        """Return the parameters' names, in physical terms."""
        links = [self.base.parameters[column] for column in self.base.columns]
        names_per_joint = JOINT_PARAMETERS if self.effort == CURRENT else SENSED_JOINT_PARAMETERS
        joints = [
            f"{name} of joint {k + 1}" for k in range(self.joints) for name in names_per_joint
        ]
        load = self.base.parameters[self.of_last_link] if self.has_payload else []
        return [*links, *joints, *(f"{PAYLOAD_PREFIX}{name}" for name in load)]

    def units(self) -> list[str]:
        """Return the units of the parameters, in the order of `names`."""
        names = [name.removeprefix(PAYLOAD_PREFIX) for name in self.names()]
        return [
            next(u for start, u in UNITS_BY_START.items() if n.startswith(start)) for n in names
        ]

    def measured(self, theta: Array, Y: Array, qd: Array) -> Array:
        """Return target torques and currents (N, 2 n) [Nm, A] over their noise, for θ (P,).

        Y: (N, n, 11 n); qd: (N, n) [rad/s].
        """
        torque, load = self._torques(theta, Y)
        a, b, c, v, per_load = theta[self.of_currents].reshape(-1, 5).T
        z = np.tanh(qd / DIRECTION_SPEED)
        # i = a T + b + c z + v q̇ + l |T| z
        current = a * load + b + c * z + v * qd + per_load * np.abs(load) * z
        return np.hstack([torque / self.noise.torque, current / self.noise.current])

    def rows(self, theta: Array, Y: Array, qd: Array) -> Array:
        """Return J = ∂measured/∂θ (N, 2 n, P); see `measured`."""
        _, load = self._torques(theta, Y)
        z, gain = self._gain(theta, load, qd)
        J = np.zeros((len(Y), 2 * self.joints, len(theta)))
        J[:, : self.joints, : self.count] = Y[..., self.base.columns]
        J[:, self.joints :, : self.count] = Y[..., self.base.columns] * gain[..., None]
        for joint, columns in enumerate(self._joint_columns()):
            T, sign = load[:, joint], z[:, joint]
            terms = [T, np.ones(len(Y)), sign, qd[:, joint], np.abs(T) * sign]
            J[:, self.joints + joint, columns] = np.stack(terms, axis=1)
        if self.has_payload:
            J[:, self.joints :, self.of_payload] = Y[..., self.of_last_link] * gain[..., None]
        return J / np.concatenate([self.noise.torque, self.noise.current])[:, None]

    def rows_with_load(self, Y: Array, qd: Array) -> Array:
        """Return ∂currents/∂(θ, p) over their noise (N, n, P + 10), p a load's ten parameters."""
        theta = np.concatenate([self.theta, np.zeros(10)])
        return replace(self, theta=theta, has_payload=True).rows(theta, Y, qd)[:, self.joints :]

    def friction_current(self, Y: Array, qd: Array) -> Array:
        """Return the friction part (N, n) [A] of the nominal current."""
        a, b = self.theta[self.of_currents].reshape(-1, 5).T[:2]
        current = self.measured(self.theta, Y, qd)[:, self.joints :] * self.noise.current
        return np.asarray(current - a * self.torque(Y) - b)

    def pull_back(self, Y: Array, qd: Array, sensitivity: Array) -> tuple[Array, Array]:
        """Return ∂f/∂Y (N, n, 11 n) and ∂f/∂q̇ (N, n) from ∂f/∂J (N, 2 n, P), J at nominal θ."""
        theta, columns = self.theta, self.base.columns
        _, load = self._torques(theta, Y)
        z, gain = self._gain(theta, load, qd)
        of_torque = sensitivity[:, : self.joints] / self.noise.torque[:, None]
        of_current = sensitivity[:, self.joints :] / self.noise.current[:, None]
        # J of currents = gain Y, with gain = a + l z sign T
        of_Y = np.zeros_like(Y)
        of_Y[..., columns] = of_torque[..., : self.count]
        of_Y[..., columns] += of_current[..., : self.count] * gain[..., None]
        of_gain = np.sum(of_current[..., : self.count] * Y[..., columns], axis=2)
        if self.has_payload:
            load_columns = Y[..., self.of_last_link]
            of_Y[..., self.of_last_link] += of_current[..., self.of_payload] * gain[..., None]
            of_gain += np.sum(of_current[..., self.of_payload] * load_columns, axis=2)
        # J of currents by the map of each joint = (T, 1, z, q̇, |T| z)
        parts = [of_current[:, j, c] for j, c in enumerate(self._joint_columns())]
        of_T, _, of_sign, of_rate, of_load = np.moveaxis(np.stack(parts, axis=1), -1, 0)
        per_load, sign = theta[self.of_currents].reshape(-1, 5)[:, 4], np.sign(load)
        of_Y += self.pull_back_torque(of_T + of_load * z * sign)
        of_z = of_sign + of_load * np.abs(load) + of_gain * per_load * sign
        return of_Y, of_rate + of_z * (1 - z**2) / DIRECTION_SPEED

    def pull_back_torque(self, sensitivity: Array) -> Array:
        """Return ∂f/∂Y (N, n, 11 n) from ∂f/∂T (N, n), T the torque of arm and nominal payload."""
        of_Y = np.zeros((*sensitivity.shape, PARAMETERS_PER_JOINT * self.joints))
        of_Y[..., self.base.columns] = sensitivity[..., None] * self.theta[: self.count]
        if self.has_payload:
            of_Y[..., self.of_last_link] += sensitivity[..., None] * self.theta[self.of_payload]
        return of_Y

    def information(self, Y: Array, qd: Array, step: float) -> Array:
        """Return Fisher's information (P, P) of a recording with samples every `step` [s].

        See `information_of`.
        """
        return information_of(self.rows(self.theta, Y, qd), step)

    def torque(self, Y: Array) -> Array:
        """Return T (N, n) [Nm] of arm and nominal payload."""
        return self._torques(self.theta, Y)[1]

    def standard_errors(self, information: Array) -> Array:
        """Return the parameters' standard errors (P,) in physical units, see `UNITS_BY_START`."""
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
        """Return the link model's torque τ and the torque T with the payload, (N, n) each [Nm]."""
        torque = Y[..., self.base.columns] @ theta[: self.count]
        if not self.has_payload:
            return torque, torque
        return torque, torque + Y[..., self.of_last_link] @ theta[self.of_payload]

    def _gain(self, theta: Array, load: Array, qd: Array) -> tuple[Array, Array]:
        """Return z and ∂i/∂T = a + l z sign T, (N, n) each."""
        a, _, _, _, per_load = theta[self.of_currents].reshape(-1, 5).T
        z = np.tanh(qd / DIRECTION_SPEED)
        return z, a + per_load * z * np.sign(load)

    def _joint_columns(self) -> list[slice]:
        """Return for each joint the place in θ of its map from torque to current."""
        return [slice(self.count + 5 * k, self.count + 5 * k + 5) for k in range(self.joints)]


def information_of(J: Array, step: float) -> Array:
    """Return the information (P, P) of the rows J (N, 2 n, P) of samples every `step` [s].

    Jᵀ J step/INDEPENDENT_STEP, for normal errors that are independent every INDEPENDENT_STEP.
    """
    rows = J.reshape(-1, J.shape[-1])
    return rows.T @ rows * (step / INDEPENDENT_STEP)


def nominal_maps(robot: Robot) -> Maps:
    """Return the expected maps and noise of an arm without recordings.

    The noise has the longest correlation time of recorded arms. Raises InputError where no joint
    has a torque constant.
    """
    constants = np.array(robot.maker_torque_constants())
    if not np.isfinite(constants).any():
        raise InputError(
            f"{robot.name} has no torque constants: write its motors' `torque_constant` and "
            "`gear_ratio` into its description, or `effort` where its joints sense torque"
        )
    constants = np.where(np.isfinite(constants), constants, np.nanmean(constants))
    largest = np.array(robot.torque_limits())
    ones = np.ones_like(constants)
    friction_share = _friction_share(robot)
    coulomb, viscous, load = (friction_share * share for share in NOMINAL_FRICTION)
    torques = [ones, 0 * ones, coulomb * largest, viscous * largest, load * ones]
    slow = np.sqrt(CORRELATION_TIME / INDEPENDENT_STEP)
    relative = CURRENT_NOISE if robot.measured == CURRENT else SENSOR_NOISE
    targets = slow * TORQUE_NOISE if robot.is_ur() else np.inf
    noise = MeasurementNoise(targets * ones, slow * relative * largest / constants)
    return Maps(np.stack(torques, axis=1) / constants[:, None], noise)


def _friction_share(robot: Robot) -> float:
    """Return the share of the joints' friction that the measured effort contains: all of it for
    motor currents, less for torque sensors.
    """
    return 1.0 if robot.measured == CURRENT else SENSED_FRICTION_SHARE


def random_states(robot: Robot, speed: float, acceleration: float) -> tuple[Array, Array, Array]:
    """Return random q, q̇, q̈ of all joints, (300, n) each, up to a speed and an acceleration.

    Positions are within the joints' ranges, and at most half a turn from their middle.
    """
    *_, (q, qd, qdd) = candidate_motions(len(robot.joints), speed, acceleration, 300).values()
    ends = np.nan_to_num(robot.position_limits(), posinf=np.pi, neginf=-np.pi)
    return ends.mean(axis=1) + q * np.minimum(np.ptp(ends, axis=1) / 2 / np.pi, 1), qd, qdd


def build_problem(
    robot: Robot, model: LinkModel, maps: Maps, has_payload: bool, typical: bool = False
) -> DesignProblem:
    """Return the problem of an arm with a link model.

    has_payload: whether a load is estimated; typical: whether the prior of a UR's friction and
    constants is that of the fits.
    """
    base = base_parameters(
        model.regressor(*random_states(robot, RANK_TEST_SPEED, RANK_TEST_ACCELERATION))
    )
    beta = base.groups @ model.parameters
    theta = np.concatenate([beta, maps.coefficients.ravel(), np.zeros(10 * has_payload)])
    spread = base.groups * prior_width(base.groups.shape[1])
    blocks = [np.linalg.inv(spread @ spread.T), _prior_of_maps(robot, maps, typical)]
    blocks += [np.diag(LOAD_WIDTH**-2.0)] * has_payload
    prior = np.asarray(block_diag(*blocks))
    return DesignProblem(base, theta, maps.noise, prior, has_payload, robot.measured)


def _prior_of_maps(robot: Robot, maps: Maps, typical: bool) -> Array:
    """Return the information (5 n, 5 n) of the fits' prior on the joints' maps to currents.

    Torque sensors have a narrower prior: their gains are calibrated, and they measure little
    friction.
    """
    torque_max, inverse = np.array(robot.torque_limits()), maps.coefficients[:, 0]
    width, friction = CONSTANT_WIDTH if robot.measured == CURRENT else GAIN_WIDTH, {}
    if typical and robot.has_ur_motors():
        width, friction = UR_CONSTANT_WIDTH, typical_friction(torque_max)
    constants = Normal(inverse, np.diag((width * inverse) ** -2.0))
    prior = Prior(constants, _friction_share(robot) * torque_max, typical=friction)
    return prior.over(BASE_TERMS).precision
