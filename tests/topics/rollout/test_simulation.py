"""Arms that torques move: known motions, energy, rest, and MuJoCo as an independent engine."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.dynamics.many_arms import ManyArms
from ur5lib.dynamics.rigid_body import kinetic_energy, potential_energy
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.exports import JointFriction, urdf
from ur5lib.robots.inertia import written_bodies
from ur5lib.robots.mjcf import mjcf
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.rollout.simulation import STEP, ManyFrictions, State, simulated

ARMS, STEPS, FINE = 20, 400, 10  # STEPS of 2 s; a step's mean torque is found by finer ones
TERMS = ("coulomb", "viscous", "load")
PARTS, AT_ONCE = 10, 1e-6  # of a step in MuJoCo; rad, over which dry friction reverses there
FRICTION = np.array([5.0, 8.0, 0.06])  # Nm, Nm s/rad, Nm/Nm
RANDOM = np.random.default_rng(4)
SIZE, RATE, PHASE, MIDDLE = (
    RANDOM.uniform(*ends, (ARMS, 1, 6)) for ends in ((0.2, 0.6), (1.5, 4), (0, 6), (-1.5, 1.5))
)


def arm() -> Robot:
    """On a slope, with a payload."""
    robot = load_robot(robot_path("ur5e")).mounted([1.0, -2.0, -9.5])
    return robot.carrying(Payload(mass=1.5, center_of_mass=(0.02, 0.0, 0.1)))


def swings() -> tuple[Array, Array, Array]:
    """Motions (ARMS, N, 6) that reverse, at fine steps."""
    angle = RATE * STEP / FINE * np.arange(STEPS * FINE + 1)[:, None] + PHASE
    q, qd = MIDDLE + SIZE * np.sin(angle), SIZE * RATE * np.cos(angle)
    return q, qd, -(RATE**2) * (q - MIDDLE)


def many(robot: Robot, model: str) -> ManyArms:
    return ManyArms([(robot, model)], np.zeros(ARMS, dtype=np.int64))


def frictions(coefficients: Array) -> ManyFrictions:
    return ManyFrictions(TERMS, np.tile(coefficients, (ARMS, 6, 1)), np.zeros(6))


def step_means(torque: Array) -> Array:
    """The mean (ARMS, STEPS, 6) over each step, by the trapezoidal rule."""
    middle = (torque[:, 1:] + torque[:, :-1]) / 2
    return middle.reshape(ARMS, STEPS, FINE, 6).mean(axis=2)


@pytest.mark.parametrize(
    ("model", "coefficients"),
    [("maker+rotors", 0 * FRICTION), ("maker+rotors", FRICTION), ("maker", FRICTION)],
)
def test_the_torque_of_a_motion_leads_along_it(model: str, coefficients: Array) -> None:
    """Friction included, through reversals, also of wrists that weigh next to nothing."""
    robot, (q, qd, qdd) = arm(), swings()
    rigid = LinkModel(robot, model).inverse_dynamics(*(x.reshape(-1, 6) for x in (q, qd, qdd)))
    rigid, friction = rigid.reshape(q.shape), frictions(coefficients)
    direction, driven = np.sign(qd[:, 0]), np.empty_like(rigid)
    start = State(q[:, 0], qd[:, 0], direction)
    for k in range(q.shape[1]):
        direction = friction.turned(direction, q[:, k] - q[:, max(k - 1, 0)])[1]
        state = State(q[:, k], qd[:, k], direction)
        driven[:, k] = rigid[:, k] + friction.torque(state, rigid[:, k])
    found = simulated(many(robot, model), friction, start, step_means(driven))
    error = np.abs(found[:, -1] - q[:, -1])
    travelled = np.abs(np.diff(q, axis=1)).sum(axis=1)
    assert np.quantile(error / travelled, 0.95) < 0.005


def test_energy_is_kept_without_friction_and_torque() -> None:
    """As it is in free fall from rest; it changes by less than a thousandth of what falls."""
    robot = arm()
    tensors = build_arm(robot, "maker+rotors")

    def energy(q: Array, qd: Array) -> Array:
        state = torch.from_numpy(q), torch.from_numpy(qd)
        return (kinetic_energy(tensors, *state) + potential_energy(tensors, state[0])).numpy()

    q, still = MIDDLE[:, 0], np.zeros((ARMS, 6))
    falls = simulated(
        many(robot, "maker+rotors"), frictions(0 * FRICTION), State(q, still, still),
        np.zeros((ARMS, STEPS // 4, 6)),
    )  # fmt: skip
    places = falls[:, -3:]
    velocity = (places[:, 2] - places[:, 0]) / (2 * STEP)
    before, after = energy(q, still), energy(places[:, 1].copy(), velocity)
    fallen = potential_energy(tensors, torch.from_numpy(places[:, 1].copy())).numpy() - before
    assert np.abs(after - before).max() < 2e-3 * np.abs(fallen).max()


@pytest.mark.parametrize(("model", "most"), [("maker+rotors", 1e-4), ("maker", 1e-2)])
def test_dry_friction_holds_an_arm_at_rest(model: str, most: float) -> None:
    """Against two thirds of the torque that breaks it loose, and not against more than that; a
    joint without a rotor weighs next to nothing, and rings.
    """
    robot, q = arm(), MIDDLE[:, 0].copy()
    gravity, taken = LinkModel(robot, model).gravity_torque(q), 2 / 3 * np.sign(PHASE[:, 0] - 3)
    breakaway = FRICTION[0] + FRICTION[2] * np.abs(gravity)
    for share, holds in ((1.0, True), (1.8, False)):
        torque = np.repeat((gravity + share * taken * breakaway)[:, None], STEPS, axis=1)
        start = State(q, 0 * q, taken)
        found = simulated(many(robot, model), frictions(FRICTION), start, torque)
        moved = np.abs(found[:, -1] - q)
        assert (moved < most).all() if holds else (moved.max(axis=1) > 2e-2).all()


@pytest.mark.parametrize("to", ["mjcf", "urdf"])
def test_mujoco_goes_where_it_goes(to: str) -> None:
    """By the exported arm, whose dry friction reverses at once and is as hard as its steps allow:
    of half of the motions, which reverse, within 0.5 % of the way. Rotors of a URDF are set.
    """
    robot, model = arm(), "maker+rotors"
    written = JointFriction(np.full(6, 5.0), np.full(6, 8.0), np.ones(6))
    bodies = written_bodies(robot, model)
    text = mjcf(robot, model, written) if to == "mjcf" else urdf(robot, bodies, written)
    engine = mujoco.MjModel.from_xml_string(text)
    engine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    engine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    engine.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    engine.opt.timestep, engine.opt.gravity = STEP / PARTS, robot.gravity
    engine.dof_solref[:, 0] = 2 * STEP / PARTS
    engine.dof_armature[:] = bodies.rotor_inertia
    mujoco.mj_setConst(engine, mujoco.MjData(engine))
    q, qd, qdd = (x[:, ::FINE] for x in swings())
    states = (x[:, :-1].reshape(-1, 6) for x in (q, qd, qdd))
    rigid = LinkModel(robot, "maker+rotors").inverse_dynamics(*states)
    torque = 1.1 * rigid.reshape(ARMS, STEPS, 6) + 8.0 * qd[:, :-1] + 5.0 * np.sign(qd[:, :-1])
    start = State(q[:, 0], qd[:, 0], np.sign(qd[:, 0]))
    friction = replace(frictions(np.array([5.0, 8.0, 0.0])), distance=AT_ONCE)
    ours = simulated(many(robot, "maker+rotors"), friction, start, torque)[:, -1]
    theirs = np.array([by_mujoco(engine, *each) for each in zip(*start[:2], torque, strict=True)])
    moved, apart = (flange(robot, ours) - flange(robot, own) for own in (start.q, theirs))
    shares = np.linalg.norm(apart, axis=1) / np.linalg.norm(moved, axis=1)
    assert np.median(shares) < 0.005


def flange(robot: Robot, q: Array) -> Array:
    return link_frames(robot, q)[1][:, -1]


def by_mujoco(engine: mujoco.MjModel, q: Array, qd: Array, torque: Array) -> Array:
    """The angles (6,) after the torques (STEPS, 6) of steps."""
    data = mujoco.MjData(engine)
    data.qpos, data.qvel = q, qd
    for applied in np.repeat(torque, PARTS, axis=0):
        data.qfrc_applied = applied
        mujoco.mj_step(engine, data)
    return np.array(data.qpos)
