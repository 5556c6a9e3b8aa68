"""The virtual test stand moves as this project's own dynamics say, and rubs as joints do."""

from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import acceleration, velocity
from ur5lib.dynamics.rigid_body import (
    inverse_dynamics,
    wrench_torque,
)
from ur5lib.errors import InputError
from ur5lib.force.sensor import move_to_frame_6, wrench_of_environment
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.drive import drive_of, motion_share
from ur5lib.stand.friction import (
    COULOMB_WARMING,
    LOAD_SHARE,
    ROOT_ONSET,
    VISCOUS_WARMING,
    BristleFriction,
    friction_of,
)
from ur5lib.stand.plan import POSTURE, SimulatedRecording
from ur5lib.stand.rig import STEP, Experiment, perform
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

torch.set_num_threads(1)

FOURIER: dict[str, Any] = {"kind": "fourier"}
STILL: dict[str, Any] = {"kind": "standstill"}
PAYLOAD = Payload(
    mass=2.5, center_of_mass=(0.02, -0.03, 0.08), inertia=(0.011, 0.012, 0.007, 0.001, -0.002, 0.0)
)


MOUNTINGS = {  # gravity in the base frame [m/s²]
    "ceiling": (0.0, 0.0, 9.81),
    "wall": (0.0, -9.81, 0.0),
    "tilted": (9.81 * np.sin(np.pi / 6), 0.0, -9.81 * np.cos(np.pi / 6)),
}


def mounted(mounting: str, robot: str = "ur5") -> Robot:
    return load_robot(robot_path(robot)).mounted(MOUNTINGS[mounting])


def experiment(robot: str | Robot = "ur5", **plan: Any) -> Experiment:
    """What an arm does in 4 s, without friction and noise unless the plan has it."""
    arm = load_robot(robot_path(robot)) if isinstance(robot, str) else robot
    wanted = {"trajectory": FOURIER, "seconds": 4, "friction": False, "noise": False} | plan
    return perform(arm, SimulatedRecording.model_validate(wanted), np.random.default_rng(0))


def states(done: Experiment) -> tuple[Tensor, Tensor, Tensor]:
    q, qd, qdd = (torch.from_numpy(done.motion[name]) for name in ("q", "qd", "qdd"))
    return q, qd, qdd


def own_torques(done: Experiment) -> Array:
    return inverse_dynamics(build_arm(done.rig.robot, done.rig.model), *states(done)).numpy()


CONTACTS: list[dict[str, Any]] = [
    {"kind": "push", "start_s": 1, "force": [30, -20, 10]},
    {"kind": "push", "start_s": 1, "force": [-40, 0, 10], "link": 3, "point": [0.1, 0, 0.05]},
    {"kind": "hand", "start_s": 2, "displacement": [0.05, 0, 0]},
]


# Rigid bodies


@pytest.mark.parametrize(
    ("robot", "plan"),
    [
        ("ur5", {"model": "A"}),
        ("ur5", {"model": "C+rotors", "payload": PAYLOAD.model_dump(), "contacts": CONTACTS}),
        ("ur10e", {"model": "maker+rotors", "friction": True, "contacts": CONTACTS}),
    ],
)
def test_the_arm_obeys_its_equation(robot: str, plan: dict[str, Any]) -> None:
    """D q̈ + C q̇ + g = motor − friction + contact, by our own dynamics."""
    motion = (done := experiment(robot, **plan)).motion
    assert np.abs(motion["qd"]).max(axis=0).min() > 0.3
    given = motion["motor_torque"] - motion["friction_torque"] + motion["contact_torque"]
    assert np.abs(own_torques(done) - given).max() < 1e-8


@pytest.mark.parametrize("mounting", MOUNTINGS)
def test_an_arm_may_hang_anywhere(mounting: str) -> None:
    """Motors and the controller's model under its gravity, which is not the floor's."""
    arm = mounted(mounting)
    done = experiment(arm, payload=PAYLOAD.model_dump())
    torque = done.motion["motor_torque"]
    np.testing.assert_allclose(own_torques(done), torque, atol=1e-6 * np.abs(torque).max())
    sent = frames(done, 0.008, None)
    np.testing.assert_allclose(channel(sent, "target_moment"), target_torques(done), atol=2e-6)


def target_torques(done: Experiment) -> Array:
    """What the true arm, with all that it carries, would take on the target."""
    targets = done.targets
    parts = (torch.from_numpy(part[::8].copy()) for part in (targets.q, targets.qd, targets.qdd))
    return inverse_dynamics(build_arm(done.rig.robot, done.rig.model), *parts).numpy()


def test_only_the_arm_knows_of_an_undeclared_payload() -> None:
    """It moves it; the controller's torque, and what it says of its payload, are without."""
    known = Payload(mass=1.0, center_of_mass=(0.0, 0.01, 0.05))
    both = experiment(payload=known.model_dump(), undeclared_payload=PAYLOAD.model_dump())
    alone = experiment(payload=known.model_dump())
    torque = both.motion["motor_torque"]
    np.testing.assert_allclose(own_torques(both), torque, atol=1e-6 * np.abs(torque).max())
    sent, told = frames(both, 0.008, None), frames(alone, 0.008, None)
    np.testing.assert_array_equal(channel(sent, "target_moment"), channel(told, "target_moment"))
    assert set(sent["payload"]) == {1.0}
    assert np.abs(target_torques(both) - channel(sent, "target_moment")).max() > 10
    untold = frames(experiment(undeclared_payload=PAYLOAD.model_dump()), 0.008, None)
    assert "payload" not in untold


def test_a_wrench_on_the_tool_is_told_at_frame_6() -> None:
    contacts = [{"kind": "push", "start_s": 1, "force": [30, -20, 10], "point": [0.03, 0, 0.2]}]
    motion = (done := experiment(contacts=contacts)).motion
    q, wrench = torch.from_numpy(motion["q"]), torch.from_numpy(motion["wrench"])
    torque = wrench_torque(build_arm(done.rig.robot, done.rig.model), q, wrench).numpy()
    np.testing.assert_allclose(torque, motion["contact_torque"], atol=1e-10)
    np.testing.assert_allclose(np.abs(motion["wrench"][:, :3]).max(axis=0), [30, 20, 10], rtol=1e-6)
    assert np.abs(motion["wrench"][:, 3:]).max() > 1


def test_a_motion_is_its_own_derivative() -> None:
    motion = experiment(friction=True).motion
    assert len(motion) == 4001
    np.testing.assert_allclose(np.diff(motion["q"], axis=0), STEP * motion["qd"][1:], atol=1e-12)
    np.testing.assert_allclose(np.diff(motion["qd"], axis=0), STEP * motion["qdd"][:-1], atol=1e-12)


# Sensors of the flange


@pytest.mark.parametrize("robot", ["ur5", "ur10e"])
def test_frame_6_is_where_it_belongs(robot: str) -> None:
    motion = (done := experiment(robot)).motion
    rotation, origin, _ = flange_kinematics(done.rig.robot, motion["q"])
    np.testing.assert_allclose(motion["origin"], origin, atol=1e-12)
    np.testing.assert_allclose(motion["rotation"].reshape(-1, 3, 3), rotation, atol=1e-12)


@pytest.mark.parametrize("gravity", [None, MOUNTINGS["tilted"]])
def test_imu_feels_what_kinematics_say(
    ur5: Robot, gravity: tuple[float, float, float] | None
) -> None:
    """At its mounting place, against gravity at rest, axes turned against frame 6."""
    turn, ur5 = np.array([-0.5, -0.1, 0.1]), ur5.mounted(gravity)
    motion = (done := experiment(ur5, imu={"mounting_deg": turn.tolist()}, friction=True)).motion
    assert ur5.mounting is not None
    arm, (q, qd, qdd) = build_arm(done.rig.robot, done.rig.model), states(done)
    place = torch.tensor(ur5.mounting.imu, dtype=torch.float64)
    specific = acceleration(arm, q, qd, qdd, point=place)[:, :3].numpy() - ur5.gravity
    rate = velocity(arm, q, qd)[:, 3:].numpy()
    rotation, *_ = flange_kinematics(ur5, motion["q"])
    for felt, true in ((motion["imu"][:, :3], specific), (motion["imu"][:, 3:], rate)):
        inside = np.einsum("nji,nj->ni", rotation, true)
        first_order = inside + np.cross(inside, np.deg2rad(turn))
        assert np.abs(felt - first_order).max() < 1e-4 * np.abs(true).max()
        assert np.abs(felt - inside).max() > 1e-3 * np.abs(true).max()  # the mounting shows


def test_force_sensor_reads_the_force_of_the_hand_on_the_arm(ur5: Robot) -> None:
    contacts = [{"kind": "push", "start_s": 1, "force": [30, -20, 10], "point": [0, 0.02, 0.1]}]
    motion = experiment(contacts=contacts).motion
    assert ur5.mounting is not None
    rotation = motion["rotation"].reshape(-1, 3, 3)
    there = wrench_of_environment(motion["force_sensor"], rotation)
    wrench = move_to_frame_6(there, rotation, np.array(ur5.mounting.force_sensor))
    np.testing.assert_allclose(wrench, motion["wrench"], atol=1e-10)


@pytest.mark.parametrize("gravity", [None, MOUNTINGS["tilted"]])
@pytest.mark.parametrize("key", ["payload", "undeclared_payload"])
def test_force_sensor_carries_the_tool(
    ur5: Robot, key: str, gravity: tuple[float, float, float] | None
) -> None:
    """Its weight at rest, its inertia in motion; the sensor sits 28.6 mm from frame 6."""
    arm = ur5.mounted(gravity)
    motion = experiment(arm, **{key: PAYLOAD.model_dump()}, trajectory=STILL, seconds=2).motion
    rotation = motion["rotation"][-1].reshape(3, 3)
    weight = PAYLOAD.mass * np.array(arm.gravity) @ rotation
    lever = np.array(PAYLOAD.center_of_mass) - [0, 0, 0.0286]
    np.testing.assert_allclose(motion["force_sensor"][-1, :3], weight, atol=1e-6)
    np.testing.assert_allclose(motion["force_sensor"][-1, 3:], np.cross(lever, weight), atol=1e-6)


# Friction


def test_friction_falls_as_it_warms() -> None:
    parameters = friction_of(load_robot(robot_path("ur5")), True)
    torque = []
    for warmth in (0.0, 10.0):
        friction = BristleFriction(parameters, np.zeros(6))
        for _ in range(2000):
            slid = friction.torque(np.zeros(6), np.ones(6), np.zeros(6), 0.001, warmth)
        torque.append(slid)
    lost = parameters.coulomb * COULOMB_WARMING + parameters.viscous * VISCOUS_WARMING
    np.testing.assert_allclose(torque[1] - torque[0], 10 * lost, rtol=1e-6)


@pytest.mark.parametrize("root", [False, True])
@pytest.mark.parametrize("speed", [-50.0, -3.0, -0.1, 0.01, 1.0, 3.0])
def test_sliding_friction_is_dry_viscous_and_periodic(speed: float, root: bool) -> None:
    """After turning steadily, without load; and of the root of velocity less its line up to 1."""
    parameters, qd = friction_of(load_robot(robot_path("ur5")), True, root), np.full(6, speed)
    friction, torque = BristleFriction(parameters, np.zeros(6)), np.zeros(6)
    for _ in range(2000):
        torque = friction.torque(np.zeros(6), qd, np.zeros(6), STEP)
    dry = np.sign(speed) * parameters.dry(qd, np.zeros(6))
    periodic = parameters.periodic * np.cos(parameters.phase)
    line = 4 / 15 * np.sign(speed) + 4 / 5 * speed
    rooted = parameters.velocity_root * (speed / np.sqrt(abs(speed) + ROOT_ONSET) - line)
    expected = dry + parameters.viscous * qd + rooted + periodic
    np.testing.assert_allclose(torque, expected, rtol=1e-6)
    assert parameters.velocity_root.any() == root


def test_friction_falls_from_stiction_and_grows_with_load() -> None:
    parameters = friction_of(load_robot(robot_path("ur5")), True)
    still = np.zeros(6)
    breakaway = parameters.dry(still, still)
    np.testing.assert_allclose(breakaway, parameters.stiction * parameters.coulomb)
    np.testing.assert_allclose(parameters.dry(still - 1, still), parameters.coulomb)
    more = parameters.dry(still + 1, still - 10) - parameters.coulomb
    np.testing.assert_allclose(more, 10 * parameters.load)


def test_friction_takes_energy_over_any_cycle() -> None:
    parameters = friction_of(load_robot(robot_path("ur5")), True)
    for amplitude in (1e-5, 1e-4, 1e-2, 1.0):
        friction, work = BristleFriction(parameters, np.zeros(6)), np.zeros(6)
        for phase in np.linspace(0, 6 * np.pi, 6000):
            qd = np.full(6, amplitude * np.cos(phase))
            q = np.full(6, amplitude * np.sin(phase))
            torque = friction.torque(q, qd, np.zeros(6), 0.001)
            work += (phase >= 4 * np.pi) * torque * qd  # once it repeats
        assert (work > 0).all()


def test_a_stuck_arm_hides_a_small_force_and_comes_back_from_a_large_one() -> None:
    """Stiction holds part of a push; after one beyond breakaway, some of it stays in the joints."""

    def currents(force: float) -> Array:
        contacts = [{"kind": "push", "start_s": 1, "seconds": 1, "force": [force, 0, 0]}]
        return experiment(trajectory=STILL, friction=True, contacts=contacts).motion["motor_torque"]

    small, large = currents(2.0), currents(150.0)
    shown = [np.abs(t - t[0]).max(axis=0)[0] for t in (small, large)]
    lever = np.abs(experiment(trajectory=STILL).motion["origin"][0, 1])
    assert shown[0] < 0.6 * 2.0 * lever
    # of the large one, the share by which it loads the gear besides
    assert shown[1] > (0.8 - LOAD_SHARE) * 150.0 * lever
    assert np.abs(large[-1] - large[0])[0] > 1
    assert np.abs(small[-1] - small[0])[0] < 0.2


@pytest.mark.parametrize("robot", ["ur5", "ur10e"])
def test_an_arm_at_rest_stays_at_rest(robot: str) -> None:
    """No chattering in the stiction: what moved before the recording has settled."""
    motion = experiment(robot, trajectory=STILL, friction=True, seconds=3).motion
    assert np.abs(motion["qd"]).max() < 1e-4
    assert np.abs(motion["q"] - POSTURE).max() < 1e-3
    assert np.abs(motion["friction_torque"][0]).max() > 0.1


@pytest.mark.parametrize("robot", ["ur5", "ur10e"])
def test_drives_keep_to_the_target(robot: str) -> None:
    """As close as the real UR5's: some 0.3 mrad in the big joints, 1 mrad in the small."""
    done = experiment(robot, friction=True, seconds=10)
    off = np.sqrt(np.mean((done.motion["q"] - done.targets.q) ** 2, axis=0))
    assert (off < 1.5e-3).all()
    assert (off > 1e-5).all()


@pytest.mark.parametrize("robot", ["ur5", "ur10e"])
def test_the_controller_knows_four_fifths_of_the_friction_of_sliding_joints(robot: str) -> None:
    """Against either direction, none at rest; the Coulomb part sets in around 0.05 rad/s."""
    arm = load_robot(robot_path(robot))
    friction = friction_of(arm, friction=True)
    drive = drive_of(arm, friction)
    qd = np.outer([-2.0, -0.5, 0.0, 0.5, 2.0], np.ones(6))
    sliding = friction.viscous * qd + friction.coulomb * np.sign(qd)
    np.testing.assert_allclose(drive.known_friction(qd), 0.8 * sliding, rtol=1e-7)
    slow = drive.known_friction(np.array([[0.05], [-0.05]]) * np.ones(6))
    coulomb = np.abs(slow) - 0.8 * 0.05 * friction.viscous
    np.testing.assert_allclose(coulomb / (0.8 * friction.coulomb), np.tanh(1.0), rtol=1e-9)


@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_motors_of_another_kind_have_the_constants_of_their_maker(factor: float) -> None:
    """With a UR's, at most what the thesis's shows, an arm of 300 kg would need 166 A."""
    arm = load_robot(robot_path("ur5e"))
    motors = {
        name: own.model_copy(update={"torque_constant": factor * (own.torque_constant or 0.0)})
        for name, own in arm.motors.items()
    }
    arm = arm.model_copy(update={"motors": motors})
    most = [10.7, 10.7, 10.7, 10.2, 11.9, 10.7] if factor == 1 else [np.inf] * 6
    constant = drive_of(arm, friction_of(arm, friction=True)).torque_constant
    np.testing.assert_allclose(constant, np.fmin(most, arm.maker_torque_constants()))


def test_the_noise_of_motion_sets_in_around_a_twentieth_of_a_radian_per_second() -> None:
    """The same for both directions."""
    share = motion_share(np.array([-2.0, -0.05, 0.0, 0.05, 2.0]))
    np.testing.assert_allclose(share, [1.0, np.tanh(1.0), 0.0, np.tanh(1.0), 1.0], atol=1e-9)


# Contacts


def test_a_wall_stops_the_arm_and_never_pulls() -> None:
    """At rest against it, stiffness times depth."""
    below = experiment(trajectory=STILL, seconds=2).motion["origin"][0, 2] - 0.05
    wall = {"kind": "wall", "through": [0, 0, below], "normal": [0, 0, 2], "point": [0, 0, 0]}
    down = [POSTURE[0], POSTURE[1] + 0.25, *POSTURE[2:]]
    points = {"kind": "movej", "way_points": [POSTURE, down], "speed_rad_s": 0.2, "pause_s": 3}
    motion = experiment(trajectory=points, friction=True, contacts=[wall], seconds=5).motion
    force, depth = motion["wrench"][:, 2], below - motion["origin"][:, 2]
    assert force.min() == force[depth < 0].max() == 0
    assert depth.max() > 0.001
    np.testing.assert_allclose(force[-1], 5000 * depth[-1], rtol=1e-3)
    np.testing.assert_array_equal(motion["wrench"][:, :2], 0)


def test_a_spring_pulls_as_far_as_it_is_drawn() -> None:
    spring = {"kind": "spring", "start_s": 1, "displacement": [0, 0.04, 0], "stiffness_n_m": 500}
    motion = experiment(trajectory=STILL, contacts=[spring], seconds=3).motion
    peak = motion["wrench"][2000, :3]  # its middle; the arm hardly gives way
    np.testing.assert_allclose(peak, [0, 20, 0], atol=0.2)


def test_a_hand_follows_and_lets_go() -> None:
    hand = {"kind": "hand", "start_s": 1, "seconds": 2.5, "displacement": [0.05, 0, 0.03]}
    motion = experiment(contacts=[hand], friction=True).motion
    force = np.linalg.norm(motion["wrench"][:, :3], axis=1)
    assert 10 < force.max() < 150
    assert np.abs(np.diff(force)).max() < 0.03 * force.max()
    assert force[:1000].max() == force[3501:].max() == 0


@pytest.mark.parametrize("mounting", ["ceiling", "tilted"])
def test_a_grasped_load_is_a_mass_at_its_point(mounting: str) -> None:
    """m (g − a) while it is held, a that of the point; before and after, nothing."""
    load = {"kind": "load", "mass": 2, "start_s": 1, "seconds": 2.5, "point": [0.02, 0, 0.1]}
    motion = (done := experiment(mounted(mounting), contacts=[load], friction=True)).motion
    arm, point = build_arm(done.rig.robot, done.rig.model), torch.tensor(load["point"])
    moved = acceleration(arm, *states(done), point=point.double())[:, :3].numpy()
    expected = 2 * (done.rig.robot.gravity - moved)
    held = slice(1250, 3250)
    off = np.abs(motion["wrench"][held, :3] - expected[held])
    assert off.max() < 0.05 * np.ptp(expected[held], axis=0).max()
    assert off.mean() < 0.02
    assert np.abs(motion["wrench"][:1000]).max() == np.abs(motion["wrench"][3501:]).max() == 0
    assert np.abs(np.diff(motion["wrench"][:, :3], axis=0)).max() < 0.5


@pytest.mark.parametrize("model", ["A", "C+rotors"])
def test_a_load_heavier_than_the_arm_may_lift_is_stable(model: str) -> None:
    load = {"kind": "load", "mass": 20, "start_s": 0.5, "seconds": 10}
    motion = experiment(trajectory=STILL, model=model, contacts=[load]).motion
    assert np.abs(motion["qd"][-1000:]).max() < 1e-4
    np.testing.assert_allclose(motion["wrench"][-1, :3], [0, 0, -20 * 9.81], atol=1e-2)


@pytest.mark.parametrize(
    "contact",
    [
        {"kind": "spring", "stiffness_n_m": 50_000, "damping_ns_m": 500, "start_s": 1},
        {"kind": "hand", "stiffness_n_m": 50_000, "damping_ns_m": 500, "start_s": 1,
         "displacement": [0.001, 0, 0], "lag_s": 0.01},
    ],
)  # fmt: skip
def test_the_stiffest_contacts_are_stable(contact: dict[str, Any]) -> None:
    motion = experiment(trajectory=STILL, friction=True, contacts=[contact]).motion
    assert np.abs(motion["q"] - POSTURE).max() < 0.05
    assert np.abs(motion["qd"][3500:]).max() < 0.01


def test_what_the_arm_cannot_do_is_told() -> None:
    with pytest.raises(InputError, match="`model` is 'D'; give one of A, B, C"):
        experiment(model="D")
    far = {"kind": "movej", "way_points": [POSTURE, (7, 0, 0, 0, 0, 0)]}
    with pytest.raises(
        InputError, match=r"takes joint 1 of ur5 to .* rad, beyond its limit of 6\.28"
    ):
        experiment(trajectory=far, seconds=10)
