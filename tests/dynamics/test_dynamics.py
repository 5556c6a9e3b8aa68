"""The equations of motion: identities, and Pinocchio and MuJoCo as independent engines."""

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio
import pytest
import torch
from torch import Tensor
from torch.func import jvp

from tests import euler_lagrange
from ur5lib.dynamics.arm import ArmTensors, build_arm
from ur5lib.dynamics.kinematics import jacobian, velocity_product_acceleration
from ur5lib.dynamics.recursion import symmetric
from ur5lib.dynamics.rigid_body import (
    coriolis_matrix,
    forward_dynamics,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
    kinetic_energy,
    potential_energy,
    regressor,
)
from ur5lib.robots.description import Payload, load_robot, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies

torch.set_num_threads(1)  # on a busy machine, threads mostly wait for one another

STATES = 1000
BASE_AXES = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
PAYLOAD = Payload(
    mass=2.5,
    center_of_mass=(0.02, -0.03, 0.08),
    inertia=(0.011, 0.012, 0.007, 0.001, -0.002, 0.0015),
)
CASES = [
    ("ur5", "A", False),
    ("ur5", "C", True),
    ("ur5", "C+rotors", False),
    ("ur10e", "maker+rotors", True),
]


def states(count: int = STATES) -> tuple[Tensor, Tensor, Tensor]:
    """Positions over both turns, velocities and accelerations up to the arm's limits."""
    random = np.random.default_rng(0)
    limits = (2 * np.pi, 3.2, 25.0)
    q, qd, qdd = (torch.tensor(random.uniform(-a, a, (count, 6))) for a in limits)
    return q, qd, qdd


def wrenches(count: int = STATES) -> Tensor:
    return torch.tensor(np.random.default_rng(1).uniform(-50, 50, (count, 6)))


def times(matrix: Tensor, vector: Tensor) -> Tensor:
    return (matrix @ vector[..., None])[..., 0]


@dataclass(frozen=True)
class Case:
    """An arm here, and what the engines are told of it.

    text: URDF, without the payload that Pinocchio is given by itself; loaded_text: with it.
    """

    arm: ArmTensors
    text: str
    loaded_text: str
    rotors: np.ndarray
    payload: Payload | None

    def pinocchio(self) -> tuple[pinocchio.Model, pinocchio.Data]:
        engine = pinocchio.buildModelFromXML(self.text)
        engine.armature = self.rotors
        if self.payload:
            xx, yy, zz, xy, xz, yz = self.payload.inertia
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            center = np.array(self.payload.center_of_mass)
            body = pinocchio.Inertia(self.payload.mass, center, tensor)
            flange = engine.frames[engine.getFrameId("frame_6")].placement
            engine.appendBodyToJoint(6, body, flange)
        return engine, engine.createData()


@pytest.fixture(scope="module", params=CASES, ids=lambda case: "-".join(map(str, case)))
def case(request: pytest.FixtureRequest) -> Case:
    name, model, loaded = request.param
    robot = load_robot(robot_path(name))
    bodies = rigid_bodies(robot, model)
    carrying = robot.carrying(PAYLOAD) if loaded else robot
    payload = PAYLOAD if loaded else None
    text, loaded_text = urdf(robot, bodies), urdf(carrying, rigid_bodies(carrying, model))
    return Case(build_arm(carrying, model), text, loaded_text, bodies.rotor_inertia, payload)


@pytest.fixture(scope="module")
def arm(case: Case) -> ArmTensors:
    return case.arm


# Pinocchio


def compare(case: Case, ours: Tensor, theirs: Callable[..., np.ndarray], *given: Tensor) -> None:
    """`theirs` is called for each state with the engine's model and data."""
    engine = case.pinocchio()
    rows = zip(*(states.numpy() for states in given), strict=True)
    expected = np.array([np.array(theirs(*engine, *row)) for row in rows])
    assert np.abs(ours.numpy() - expected).max() < 1e-9


def crba(model: pinocchio.Model, data: pinocchio.Data, q: np.ndarray) -> np.ndarray:
    upper = np.triu(pinocchio.crba(model, data, q))
    return upper + np.triu(upper, 1).T


def flange_jacobian(model: pinocchio.Model, data: pinocchio.Data, q: np.ndarray) -> np.ndarray:
    frame = model.getFrameId("frame_6")
    return pinocchio.computeFrameJacobian(model, data, q, frame, BASE_AXES)


def flange_acceleration(
    model: pinocchio.Model, data: pinocchio.Data, q: np.ndarray, qd: np.ndarray
) -> np.ndarray:
    pinocchio.forwardKinematics(model, data, q, qd, np.zeros(6))
    frame = model.getFrameId("frame_6")
    return pinocchio.getFrameClassicalAcceleration(model, data, frame, BASE_AXES).vector


TERMS = [  # ours, Pinocchio's, and of how many of q, q̇, q̈; its C is that of Christoffel's symbols
    (inverse_dynamics, pinocchio.rnea, 3),
    (inertia_matrix, crba, 1),
    (coriolis_matrix, pinocchio.computeCoriolisMatrix, 2),
    (gravity_torque, pinocchio.computeGeneralizedGravity, 1),
    (kinetic_energy, pinocchio.computeKineticEnergy, 2),
    (potential_energy, pinocchio.computePotentialEnergy, 1),
    (jacobian, flange_jacobian, 1),
    (velocity_product_acceleration, flange_acceleration, 2),
]


@pytest.mark.parametrize(
    ("ours", "theirs", "count"), TERMS, ids=[ours.__name__ for ours, *_ in TERMS]
)
def test_terms_agree_with_pinocchio(
    case: Case, ours: Callable[..., Tensor], theirs: Callable[..., np.ndarray], count: int
) -> None:
    given = states()[:count]
    compare(case, ours(case.arm, *given), theirs, *given)


def test_forward_dynamics_agrees_with_pinocchio(case: Case) -> None:
    """Within 1e-9 of the largest acceleration, which lies in the millions without rotors."""
    q, qd, torque = states()
    ours = forward_dynamics(case.arm, q, qd, torque).numpy()
    model, data = case.pinocchio()
    rows = zip(q.numpy(), qd.numpy(), torque.numpy(), strict=True)
    theirs = np.array([pinocchio.aba(model, data, *row) for row in rows])
    assert np.abs(ours - theirs).max() < 1e-9 * np.abs(theirs).max()


def test_regressor_agrees_with_pinocchio(case: Case) -> None:
    """Pinocchio's has no columns for rotors; those are the joints' accelerations."""
    ours = regressor(case.arm, *states())
    compare(case, ours[..., :60], pinocchio.computeJointTorqueRegressor, *states())
    assert torch.equal(ours[..., 60:], torch.diag_embed(states()[2]))


def test_a_wrench_acts_as_in_pinocchio(case: Case) -> None:
    def pushed(model: pinocchio.Model, data: pinocchio.Data, *given: np.ndarray) -> np.ndarray:
        q, qd, qdd, wrench = given
        pinocchio.framesForwardKinematics(model, data, q)
        flange = data.oMf[model.getFrameId("frame_6")].translation
        seen = data.oMi[6].actInv(pinocchio.SE3(np.eye(3), flange).act(pinocchio.Force(wrench)))
        forces = [pinocchio.Force.Zero()] * 6 + [seen]
        return pinocchio.rnea(model, data, q, qd, qdd, forces)

    given = (*states(), wrenches())
    compare(case, inverse_dynamics(case.arm, *given), pushed, *given)


# MuJoCo


def test_exported_urdf_gives_the_same_in_mujoco(case: Case) -> None:
    """URDF cannot say the armature: it is told apart."""
    engine = mujoco.MjModel.from_xml_string(case.loaded_text)
    engine.dof_armature[:] = case.rotors
    engine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(engine)
    given = [state.numpy() for state in states()]
    torque, inertia = np.empty((STATES, 6)), np.empty((STATES, 6, 6))
    for i, (data.qpos, data.qvel, data.qacc) in enumerate(zip(*given, strict=True)):
        mujoco.mj_inverse(engine, data)
        torque[i] = data.qfrc_inverse
        mujoco.mj_fullM(engine, data, inertia[i])
    assert np.abs(inverse_dynamics(case.arm, *states()).numpy() - torque).max() < 1e-6
    assert np.abs(inertia_matrix(case.arm, states()[0]).numpy() - inertia).max() < 1e-6


# Identities


def test_inertia_matrix_is_symmetric_and_positive_definite(arm: ArmTensors) -> None:
    matrix = inertia_matrix(arm, states()[0])
    assert torch.equal(matrix, matrix.mT)
    assert torch.linalg.eigvalsh(matrix).min() > 0


def test_change_of_inertia_less_twice_coriolis_is_skew_symmetric(arm: ArmTensors) -> None:
    q, qd, _ = states()
    change = jvp(lambda q: inertia_matrix(arm, q), (q,), (qd,))[1]
    difference = change - 2 * coriolis_matrix(arm, q, qd)
    assert (difference + difference.mT).abs().max() < 1e-12 * change.abs().max()


def test_a_symmetric_matrix_is_its_upper_half() -> None:
    """Whatever stands below, which need not be computed."""
    unused = np.nan
    upper = [[1.0, 2.0, 3.0], [unused, 4.0, 5.0], [unused, unused, 6.0]]
    assert symmetric(upper) == ((1.0, 2.0, 3.0), (2.0, 4.0, 5.0), (3.0, 5.0, 6.0))


def test_both_derivations_agree(arm: ArmTensors) -> None:
    """Euler and Lagrange: D q̈ + C q̇ + g from energies; Newton and Euler: the recursion."""
    q, qd, qdd = states(100)
    D, g = euler_lagrange.inertia_matrix(arm, q), euler_lagrange.gravity_torque(arm, q)
    C = euler_lagrange.coriolis_matrix(arm, q, qd)
    torch.testing.assert_close(inertia_matrix(arm, q), D, rtol=0, atol=1e-12)
    torch.testing.assert_close(coriolis_matrix(arm, q, qd), C, rtol=0, atol=1e-12)
    torch.testing.assert_close(gravity_torque(arm, q), g, rtol=0, atol=1e-11)
    torque = times(D, qdd) + times(C, qd) + g
    torch.testing.assert_close(inverse_dynamics(arm, q, qd, qdd), torque, rtol=0, atol=1e-10)


def test_forward_dynamics_undoes_inverse_dynamics(arm: ArmTensors) -> None:
    q, qd, qdd = states()
    wrench = wrenches()
    back = forward_dynamics(arm, q, qd, inverse_dynamics(arm, q, qd, qdd, wrench), wrench)
    assert (back - qdd).abs().max() < 1e-9 * qdd.abs().max()


def test_power_is_the_change_of_energy(arm: ArmTensors) -> None:
    """dE/dt = q̇ᵀ τ along a trajectory: q changes with q̇, q̇ with q̈, and both derivatives exact."""
    q, qd, qdd = states()

    def energy(q: Tensor, qd: Tensor) -> Tensor:
        return kinetic_energy(arm, q, qd) + potential_energy(arm, q)

    change = jvp(energy, (q, qd), (qd, qdd))[1]
    power = (qd * inverse_dynamics(arm, q, qd, qdd)).sum(1)
    assert (change - power).abs().max() < 1e-12 * power.abs().max()


def test_regressor_times_parameters_is_the_torque(arm: ArmTensors) -> None:
    torque = regressor(arm, *states()) @ arm.parameters
    assert (torque - inverse_dynamics(arm, *states())).abs().max() < 1e-11
