"""What the whole motion tells of efforts: their order and signs, the arm, and what it lacks.

Of a UR5e by currents, and of the same arm by its joints' torques, as whose links nobody knows. The
logs are computed here, by the equations of motion with friction, gears' losses and noise.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from tests.made_records import motion_of
from tests.stored_files import made_up_channels
from ur5lib.channels import CURRENT
from ur5lib.checks.arm import Cause, likeliest
from ur5lib.checks.block_means import block_means
from ur5lib.checks.by_motion import (
    MotionChecks,
    are_exchanged,
    have_exchanged_efforts,
    is_turned,
)
from ur5lib.checks.checked import Checked
from ur5lib.checks.contacts import FeltContact
from ur5lib.checks.currents import _unexpected_torque, fitted_load
from ur5lib.checks.delays import Delays, delayed_currents, delayed_joint
from ur5lib.checks.doubts import doubts_by_joint
from ur5lib.checks.findings import (
    contacts_felt,
    contradictions,
    load_without_targets,
    possible_delays,
    scaled_current,
)
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.checks.unchecked import unchecked
from ur5lib.checks.whole_motion import (
    STRETCHES,
    Explained,
    Lead,
    Misfit,
    Regression,
    WholeMotion,
)
from ur5lib.recordings.frames import repair_frames
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Finding, contradiction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.friction import friction_direction
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.newton_euler import torque
from ur5lib.robots.statics import flange_kinematics
from ur5lib.steps.compute_torques import compute_torques
from ur5lib.tables import channel, named, write_table
from ur5lib.timeseries.arrays import Array

STEP, SECONDS, HOME = 0.02, 24.0, np.array([0.3, -1.2, 1.4, -1.0, 1.2, 0.4])
PHASES = {seed: np.random.default_rng(seed).uniform(0, 2 * np.pi, 6) for seed in (0, 7)}
Spoil = Callable[[Array], Array]


@pytest.fixture(scope="module")
def ur5e() -> Robot:
    return load_robot(robot_path("ur5e"))


@pytest.fixture(scope="module")
def sensed(ur5e: Robot, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The same arm with its joints' torques measured, from its URDF."""
    file = tmp_path_factory.mktemp("arm") / "arm.urdf"
    file.write_text(urdf(ur5e, rigid_bodies(ur5e, ur5e.chosen_model)))
    return robot_from_urdf(Path(file))[0]


def log(arm: Robot, seed: int = 0, spring: float = 0.0, reversal: float = 0.0) -> Checked:
    """A motion of all joints; spring: at joint 2 [Nm/rad]; reversal: of friction [rad]."""
    random, time = np.random.default_rng(seed), np.arange(0, SECONDS, STEP)
    pace, phase = random.uniform(0.5, 2.0, (2, 3, 6)) * [[[1.0]], [[np.pi]]]
    angle = pace[:, None] * time[:, None] + phase[:, None]
    size = 0.25
    q, qd = HOME + size * np.sin(angle).sum(0), size * (pace[:, None] * np.cos(angle)).sum(0)
    qdd = -size * (pace[:, None] ** 2 * np.sin(angle)).sum(0)
    links = torque(arm, arm.fullest_model(), q, qd, qdd)
    largest = np.array([150, 150, 150, 28, 28, 28])
    effort = 1.05 * links if arm.measured == CURRENT else links
    dry = np.tanh(qd / 0.02)
    if reversal:
        whole = np.zeros(len(q), int)
        dry = np.stack([friction_direction(one, whole, reversal) for one in q.T], axis=1)
    effort = effort + largest * (0.04 * dry + 0.02 * qd)
    effort[:, 1] += spring * (q[:, 1] - HOME[1])
    effort += 0.005 * largest * random.normal(size=q.shape)
    effort = effort / arm.maker_torque_constants()
    table = pd.DataFrame({"time": time, "segment": 0, "interpolated": False})
    for name, values in {"actual_q": q, "actual_qd": qd, arm.measured.channel: effort}.items():
        table = table.assign(**named(values, name))
    return Checked(table, arm, None, None, fitted=True, cutoff=2.0)


def spoilt(own: Checked, order: list[int], *names: str, sign: Array | None = None) -> Checked:
    """With the columns of some channels in another order, or times a sign."""
    table = own.robot.copy()
    for name in names:
        values = channel(own.robot, name)[:, order] * (1.0 if sign is None else sign)
        table = table.assign(**named(values, name))
    return replace(own, robot=table)


def signs(own: Checked) -> list[str]:
    return [said(sign) for sign in stop_signs(own)]


def unknown(arm: Robot) -> Robot:
    return arm.model_copy(update={"links": "unknown"})


@pytest.mark.parametrize("seed", range(3))
def test_right_logs_are_not_stopped(ur5e: Robot, sensed: Robot, seed: int) -> None:
    for arm in (ur5e, sensed):
        own = log(arm, seed)
        assert signs(own) == []
        assert Found.LINKS_IN_DOUBT not in {one.code for one in unchecked(own)}
    assert signs(replace(log(sensed, seed), arm=unknown(sensed))) == []


@pytest.mark.parametrize("seed", range(2))
def test_gravity_from_the_side_is_told_without_links(sensed: Robot, seed: int) -> None:
    """Where any links explain the torques, but under no gravity from there."""
    for side in ((0.0, -9.81, 0.0), (9.81, 0.0, 0.0)):
        arm = unknown(sensed).mounted(side)
        (sign,) = stop_signs(replace(log(sensed, seed), arm=arm))
        assert sign.cause == CauseCode.OTHER_MOUNTING
        assert "`gravity: [0, 0, -9.8" in sign.detail


def test_exchanged_efforts_and_joints_are_told_apart(ur5e: Robot, sensed: Robot) -> None:
    order = [0, 3, 2, 1, 4, 5]
    for own in (log(ur5e), log(sensed), replace(log(sensed), arm=unknown(sensed))):
        (efforts,) = stop_signs(spoilt(own, order, own.arm.measured.channel))
        assert efforts.joints == (2, 4)
        assert "of joints 2 and 4 are exchanged: each follows" in said(efforts)
        (joints,) = signs(spoilt(own, order, "actual_q", "actual_qd", own.arm.measured.channel))
        assert "joints 2 and 4 are exchanged: their motion" in joints


@pytest.mark.parametrize("known", [True, False])
def test_a_turned_torque_is_told_by_links(sensed: Robot, known: bool) -> None:
    """As sensors beyond gears feel no friction; the entry's remedy mends it."""
    arm = sensed if known else unknown(sensed)
    turned = np.array([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    (sign,) = signs(
        spoilt(replace(log(sensed), arm=arm), [*range(6)], "actual_torque", sign=turned)
    )
    assert "is reversed on joint 3;" in sign
    assert "`units: {actual_torque: [1, 1, -1, 1, 1, 1]}`" in sign


def test_a_turned_current_is_told(ur5e: Robot) -> None:
    turned = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
    (sign,) = signs(spoilt(log(ur5e), [*range(6)], "actual_current", sign=turned))
    assert "the sign of the current of joint 5 is reversed" in sign


def test_a_current_too_small_for_what_it_holds_is_told(ur5e: Robot) -> None:
    """Gears lose torque, so that no motor's current holds more than its constant allows."""
    weak = np.array([1.0, 0.7, 1.0, 1.0, 1.0, 1.0])
    (sign,) = signs(spoilt(log(ur5e), [*range(6)], "actual_current", sign=weak))
    assert "gravity's torque on joint 2 is" in sign


@pytest.mark.parametrize("stiffness", [100.0, 300.0])
def test_a_spring_on_the_tool_is_the_cause_of_what_it_changes(
    ur5e: Robot, sensed: Robot, stiffness: float
) -> None:
    """Whatever gravity, exchanged joints or constants would explain of it; none of a contact."""
    told = set()
    for own in (log(ur5e), log(sensed), log(ur5e.mounted((0.0, 6.9, -6.9)), 7)):
        pulled = sprung(own, stiffness)
        for sign in stop_signs(pulled):
            assert sign.cause == CauseCode.SPRING_ON_TOOL
            told.add(round(float(re.findall(r"spring of (\d+)", sign.detail)[0]), -1))
        signs = stop_signs(replace(pulled, fitted=False, touched=True))
        assert {sign.severity for sign in signs} <= {"warning"}
    assert not told or max(abs(one - stiffness) for one in told) <= 0.1 * stiffness
    assert bool(told) == (stiffness == 300.0)


def sprung(own: Checked, stiffness: float) -> Checked:
    """With what pulls on the tool towards the middle of its path."""
    _, place, jacobian = flange_kinematics(own.arm, channel(own.robot, "actual_q"))
    force = stiffness * (place.mean(axis=0) - place)
    torque = np.einsum("nij,ni->nj", jacobian[:, :3], force) / own.arm.maker_torque_constants()
    name = own.arm.measured.channel
    return replace(own, robot=own.robot.assign(**named(channel(own.robot, name) - torque, name)))


def test_what_a_ripple_may_lack_is_no_weak_current(ur5e: Robot) -> None:
    """Where a joint bears little, a current that varies once per turn looks like less gravity."""
    weak = np.array([1.0, 0.7, 1.0, 1.0, 1.0, 1.0])
    own = log(ur5e.mounted((0.0, 0.0, -2.4)))
    assert signs(spoilt(own, [*range(6)], "actual_current", sign=weak)) == []


@pytest.mark.parametrize("seed", [0, 7])
def test_a_joint_whose_friction_brakes_is_not_turned(seed: int) -> None:
    """A current that varies once per turn may be more than what a small wrist bears."""
    own = log(load_robot(robot_path("ur3e")), seed)
    current = channel(own.robot, "actual_current")
    ripple = 0.15 * np.sin(channel(own.robot, "actual_q") + PHASES[seed])
    rippled = own.robot.assign(**named(current + ripple, "actual_current"))
    assert signs(replace(own, robot=rippled)) == []


@pytest.mark.parametrize(("cutoff", "shortest"), [(2.0, 0.03), (10.0, 0.006)])
def test_a_delay_matters_from_a_share_of_the_cut_off_s_period_on(
    ur5e: Robot, cutoff: float, shortest: float
) -> None:
    delays = replace(log(ur5e), cutoff=cutoff).delays
    assert delays is not None
    assert delays.shortest == pytest.approx(shortest)


@pytest.mark.parametrize("seed", range(3))
def test_friction_that_reverses_slowly_is_no_delay(ur5e: Robot, seed: int) -> None:
    """Over 2 mrad, currents follow a motion of 0.1 rad/s by 20 ms: a warning at most."""
    own = log(ur5e, seed, reversal=2e-3)
    assert signs(own) == []
    assert {one.code for one in possible_delays(own)} <= {Found.POSSIBLE_DELAY}


@pytest.mark.parametrize("seed", range(3))
def test_friction_that_a_pause_keeps_is_no_other_constant(ur5e: Robot, seed: int) -> None:
    """Of 12 s in which joints move for 5 s, and bear less than gravity while they rest."""
    own, moving, resting = log(ur5e, seed), 250, 350
    paused = own.robot.iloc[[*range(moving), *[moving] * resting]].reset_index(drop=True)
    paused["time"] = STEP * np.arange(moving + resting)
    rest = paused.index >= moving
    current = channel(paused, "actual_current")
    current[rest] *= 0.4
    qd = np.where(rest[:, None], 0.0, channel(paused, "actual_qd"))
    paused = paused.assign(**named(current, "actual_current"), **named(qd, "actual_qd"))
    assert signs(replace(own, robot=paused)) == []


@pytest.mark.parametrize(("before_shorter", "told"), [(2.0, False), (20.0, True)])
def test_a_delay_is_told_where_a_shorter_one_explains_less(
    before_shorter: float, told: bool
) -> None:
    """Friction that follows a reversal looks like a delay of one step, or of the next."""
    seconds = 0.02 * np.arange(-2, 3)
    usual = np.array([0.0, 0.0, 70.0, 100.0 - before_shorter, 100.0])
    scores = np.array([usual, usual, np.zeros(5)])[:, None]
    delays = Delays(seconds, scores, shortest=0.03, moves=np.array([True]))
    assert bool([*delayed_currents(delays, driven=True, name="actual_current")]) == told


@pytest.mark.parametrize("moves", [True, False])
def test_a_joint_at_rest_does_not_tell_when_its_effort_comes(moves: bool) -> None:
    """Two of a thousand episodes in which one joint moves were left out by the current of
    another.
    """
    seconds = 0.02 * np.arange(-2, 3)
    early, on_time = np.array([25.0, 15.0, 0.0, -6.0, -8.0]), -500.0 * np.abs(seconds)
    scores = np.tile([early, 10 * on_time], (3, 1, 1))
    delays = Delays(seconds, scores, shortest=0.03, moves=np.array([moves, True]))
    assert delays.late_joint(rubs=True) == ((0, pytest.approx(-0.04)) if moves else None)


def late(own: Checked, joints: list[int], seconds: float = 0.1) -> Checked:
    """A log whose efforts of some joints, from 0, come later than their motion."""
    effort = channel(own.robot, own.arm.measured.channel).copy()
    effort[:, joints] = np.roll(effort[:, joints], round(seconds / STEP), axis=0)
    return replace(own, robot=own.robot.assign(**named(effort, own.arm.measured.channel)))


@pytest.mark.parametrize("joint", range(6))
def test_one_late_joint_is_told(ur5e: Robot, joint: int) -> None:
    own = log(ur5e)
    found = [*stop_signs(late(own, [joint])), *possible_delays(late(own, [joint]))]
    assert found[0].cause == CauseCode.LATE_JOINT
    assert found[0].joints == (joint + 1,)
    assert re.search(r" 0\.(08|10|12) s later", found[0].detail)


@pytest.mark.parametrize("joint", [1, 3, 5])
@pytest.mark.parametrize("channels", [["actual_q"], ["actual_q", "actual_qd"], ["actual_qd"]])
def test_velocities_tell_which_column_of_a_joint_is_late(
    ur5e: Robot, joint: int, channels: list[str]
) -> None:
    """Positions behind velocities and currents, or both before the currents; else neither."""
    own = log(ur5e)
    for name in channels:
        rows = channel(own.robot, name).copy()
        rows[:, joint] = np.roll(rows[:, joint], round(0.1 / STEP))
        own = replace(own, robot=own.robot.assign(**named(rows, name)))
    found = [*stop_signs(own), *possible_delays(own)]
    told = [one for one in found if one.cause in (CauseCode.LATE_JOINT, CauseCode.EARLY_JOINT)]
    if channels == ["actual_qd"]:
        assert told == []
        return
    assert told[0].joints == (joint + 1,)
    whole = len(channels) == 2
    cause = CauseCode.EARLY_JOINT if whole else CauseCode.LATE_JOINT
    name, rest = ("actual_current", "agrees with") if whole else ("actual_q", "than actual_qd and")
    assert told[0].cause == cause
    assert told[0].detail.startswith(f"{name} of joint {joint + 1} comes 0.")
    assert rest in told[0].detail


def test_one_late_torque_without_velocities_is_a_doubt(sensed: Robot) -> None:
    """Of an arm that is no UR, on which nothing else bears it out."""
    own = late(log(sensed), [2], 0.3)
    delays, columns = own.sensed_delays, [c for c in own.robot if "actual_qd" not in c]
    assert delays is not None
    found = [
        one.severity
        for robot in (own.robot, own.robot[columns])
        for one in delayed_joint(delays, False, "actual_torque", robot)
    ]
    assert found == ["stop", "warning"]


def test_a_late_log_names_no_joint(ur5e: Robot, sensed: Robot) -> None:
    (sign,) = stop_signs(late(log(ur5e), [*range(6)]))
    assert sign.cause == CauseCode.LATE_CURRENT
    assert possible_delays(log(ur5e)) == possible_delays(log(sensed)) == []


@pytest.mark.parametrize("joint", range(6))
def test_a_late_torque_is_told_whatever_the_links_are(sensed: Robot, joint: int) -> None:
    """By torques of sensors, which feel no friction of the motors, it is a warning."""
    own = replace(log(sensed), arm=unknown(sensed))
    assert possible_delays(own) == []
    (found,) = possible_delays(late(own, [joint], 0.3))
    assert (found.cause, found.joints) == (CauseCode.LATE_JOINT, (joint + 1,))


@pytest.mark.parametrize("gains", [(1.0, 2.0), (2.0, 1.0)])
def test_of_several_causes_that_of_the_largest_gain_is_told(
    ur5e: Robot, gains: tuple[float, float]
) -> None:
    means = block_means(log(ur5e).robot, STEP)
    codes = {1.0: CauseCode.LATE_JOINT, 2.0: CauseCode.EARLY_JOINT}
    found = [contradiction(codes[gain], "robot", "so") for gain in gains]
    pairs = zip(found, gains, strict=True)
    causes = [Cause(finding, gain, means, ur5e) for finding, gain in pairs]
    assert [one.cause for one in likeliest(causes)] == [CauseCode.EARLY_JOINT]
    assert [*likeliest([])] == []


def test_another_arm_is_told_unless_a_load_may_explain_it(ur5e: Robot) -> None:
    own = log(ur5e)
    ur10e = load_robot(robot_path("ur10e"))
    (sign,) = signs(replace(own, arm=ur10e))
    assert "`robot: ur5e`" in sign
    loaded = log(ur5e.carrying(Payload(mass=1.5, center_of_mass=(0.0, 0.0, 0.05))))
    assert signs(replace(loaded, arm=ur5e)) == []


@pytest.mark.parametrize(("mass", "told"), [(0.3, False), (2.6, True)])
def test_a_load_is_told_without_targets(ur5e: Robot, mass: float, told: bool) -> None:
    load = Payload(mass=mass, center_of_mass=(0.01, 0.0, 0.08))
    own = replace(log(ur5e.carrying(load)), arm=ur5e)
    found = load_without_targets(own)
    assert [one.code for one in found] == [Found.UNDECLARED_LOAD] * told
    assert load_without_targets(replace(own, fitted=False)) == []
    assert load_without_targets(replace(own, declared=load)) == []


@pytest.mark.parametrize(
    ("mass", "error", "size", "told"),
    [
        (2.0, 0.2, 1.5, True),
        (2.0, 0.2, 0.5, False),
        (0.5, 0.01, 1.5, False),
        (2.0, 0.5, 1.5, False),
    ],
)
def test_a_load_is_told_where_it_is_sure_large_and_explains_far_more(
    ur5e: Robot, mass: float, error: float, size: float, told: bool
) -> None:
    checks = MotionChecks(block_means(log(ur5e).robot, STEP), ur5e, rubs=True)
    checks.motion.load = lambda: (mass, error, Lead(size, errors=9.0))
    assert len([*checks.undeclared_load()]) == told
    checks.means = checks.means.with_efforts(checks.means.effort)
    checks.means.currents["target_current"] = checks.means.effort
    assert [*checks.undeclared_load()] == []  # its excess over the target tells it


def test_each_joint_that_shows_a_load_beside_its_targets_has_one_weight(ur5e: Robot) -> None:
    """It is over the spread of the torque by which its current exceeds the target."""
    load = Payload(mass=2.0, center_of_mass=(0.01, 0.0, 0.08))
    means, bare = (block_means(log(arm).robot, STEP) for arm in (ur5e.carrying(load), ur5e))
    means.currents["target_current"] = bare.effort
    for joint in (1, 2):
        columns, torque = _unexpected_torque(means, ur5e, 0 * means.q, odd={*range(6)} - {joint})
        assert torque.std() == pytest.approx(1.0)
        assert fitted_load(columns, torque)[0] == pytest.approx(2.0, rel=0.3)


@pytest.mark.parametrize("factor", [0.6, 1.0])
@pytest.mark.parametrize("joint", [1, 2])
def test_a_small_current_is_told_beside_the_others(ur5e: Robot, joint: int, factor: float) -> None:
    own = log(ur5e)
    effort = channel(own.robot, "actual_current") * np.where(np.arange(6) == joint, factor, 1.0)
    robot = own.robot.assign(**named(effort, "actual_current"))
    found = scaled_current(replace(own, robot=robot))
    assert [one.joints for one in found] == ([(joint + 1,)] if factor < 1 else [])


def doubts(own: Checked) -> list[str]:
    assert signs(own) == []
    return [said(one) for one in unchecked(own) if one.code == Found.LINKS_IN_DOUBT]


def test_what_a_description_lacks_is_named(ur5e: Robot, sensed: Robot) -> None:
    """Rotors, a load, a spring, or other links, each where nothing before it heals the doubt."""
    rotors = {"rotor_inertias": ur5e.models[ur5e.fullest_model()].rotor_inertias}
    model = sensed.models["maker"].model_copy(update=rotors)
    driven = sensed.model_copy(update={"models": {"maker": model}})
    (lacks_rotors,) = doubts(replace(log(driven), arm=sensed))
    assert "`rotor_inertia`" in lacks_rotors
    load = Payload(mass=3.0, center_of_mass=(0.02, 0.0, 0.1))
    lacks_load = doubts(replace(log(sensed.carrying(load)), arm=sensed))
    assert any("declare it as `payload`" in one for one in lacks_load)
    (lacks_spring,) = doubts(log(sensed, spring=40.0))
    assert "joint 2 of" in lacks_spring
    assert "`balanced_joints: [2]`" in lacks_spring


def test_a_joint_whose_links_are_in_doubt_is_told_before_a_contact(sensed: Robot) -> None:
    """Baxter was to have been touched, where its spring pulled."""
    whole, sprung = log(sensed), log(sensed, spring=40.0)
    found = {}
    for name, own, joint in [("right", whole, 2), ("sprung", sprung, 2), ("other", sprung, 4)]:
        own.__dict__["contact"] = FeltContact(joint, 11.0, 0.2)  # as if it were cached
        (found[name],) = (said(one) for one in contacts_felt(own, sensed=False))
    assert ["in doubt" in one for one in found.values()] == [False, True, False]


def test_the_likeliest_doubt_heals_the_description() -> None:
    other, load, spring = (
        CauseCode.DOUBTFUL_LINKS,
        CauseCode.MISSING_LOAD,
        CauseCode.MISSING_SPRING,
    )
    found = [
        Finding("robot", Found.LINKS_IN_DOUBT, "note", 1, "so", cause=cause, joints=(2,))
        for cause in (other, other, load, spring, spring)
    ]
    assert {k: one.cause for k, one in doubts_by_joint(found).items()} == {2: spring}
    assert doubts_by_joint(found[:2])[2].cause == other
    assert doubts_by_joint([Finding("robot", Found.CONTACT, "note", 1, "so", joints=(2,))]) == {}


def test_a_run_finds_what_a_check_finds(sensed: Robot, tmp_path: Path) -> None:
    """The report of a Baxter lacked the spring that `ur5 check` had named."""
    own, file = log(sensed, spring=40.0), tmp_path / "signals.parquet"
    write_table(own.robot, file)
    time, q, qd = (
        own.robot["time"].to_numpy(),
        *(channel(own.robot, f"actual_{n}") for n in ("q", "qd")),
    )
    cutoffs = {"currents": 2.0, "motion": 80.0}
    known = {"signals": Signals.read(file), "motion": motion_of(time, q, qd)}
    moved = AlignedRecording(role="fit", gravity=None, untouched=None, **known)
    run = compute_torques(moved, sensed, cutoffs).premises
    names = [one.code for one in run.contradictions.findings]
    assert {
        Found.LINKS_IN_DOUBT,
        "unfiltered",
        Found.CONTACT_NOT_CHECKED,
        Found.TORQUES_NOT_CHECKED,
    } <= {*names}
    assert run.contradictions == contradictions(own, [], False, cutoffs, {})


def test_rotors_and_loads_that_cannot_be_are_not_named(ur5e: Robot, sensed: Robot) -> None:
    """The rotors of a right UR3 were to be missing, where they are described as too heavy, and a
    UR5 was to carry a load of no mass.
    """
    model = ur5e.models[ur5e.fullest_model()].model_copy(update={"rotor_inertias": (0.0,) * 6})
    lighter = ur5e.with_model(ur5e.fullest_model(), model)
    causes = {one.cause for one in replace(log(lighter), arm=ur5e).doubted_links}
    assert causes == {CauseCode.SURPLUS_ROTORS}
    pull = Payload(mass=3.0, center_of_mass=(0.02, 0.0, 0.1))
    lifted = doubts(replace(log(sensed), arm=sensed.carrying(pull)))  # it carries less
    assert not any("declare it as `payload`" in one for one in lifted)


def test_nothing_is_explained_better_than_to_two_hundredths_of_a_newton_metre() -> None:
    """Not even by the columns that made it; and what they miss adds to that."""
    random = np.random.default_rng(0)
    columns = random.normal(size=(200, 6, 4))
    explained = columns @ [1.0, -2.0, 3.0, 0.5]
    missed = 3.0 * np.where(np.arange(200)[:, None] % 2, 1.0, -1.0) * np.arange(6)
    least = Regression(columns, ridges=(1e-12,))
    for misfit in least.misfit(explained):
        np.testing.assert_allclose(misfit, np.log(0.02**2), rtol=1e-6)
    found = least.misfit(explained + missed)
    expected = np.log((3.0 * np.arange(6)) ** 2 + 0.02**2)
    np.testing.assert_allclose(found.whole[1:], expected[1:], atol=0.1)


def test_wrong_links_are_doubted_and_stop_nothing(sensed: Robot) -> None:
    masses = tuple(
        mass * factor for mass, factor in zip(sensed.masses, (1, 2, 0.3, 3, 0.3, 4), strict=True)
    )
    model = sensed.models["maker"].model_copy(update={"masses": None})
    wrong = sensed.model_copy(update={"masses": masses, "models": {"maker": model}})
    found = doubts(replace(log(sensed), arm=wrong))
    assert any("say `links: unknown` there" in one for one in found)


def test_joints_that_rest_tell_nothing(sensed: Robot) -> None:
    """As notes, and no stop sign, whatever their columns hold."""
    own = log(sensed)
    still = own.robot.copy()
    for name in ("actual_q", "actual_qd"):
        still = still.assign(**named(0 * channel(own.robot, name), name))
    resting = replace(own, robot=still)
    assert signs(resting) == []
    open_ones = {one.code for one in unchecked(resting)}
    assert {Found.ORDER_NOT_CHECKED, Found.SIGN_NOT_CHECKED, Found.COLUMNS_NOT_CHECKED} <= open_ones


@pytest.mark.parametrize("seed", [2, 11, 14])
def test_joints_of_a_short_log_with_other_friction_are_not_exchanged(
    seed: int, tmp_path: Path
) -> None:
    """Where friction grows with the root of velocity, gravity of a vertical joint tells nothing."""
    time, channels = made_up_channels(tmp_path / "run", seed=seed)
    q, qd, current = (channels[name] for name in ("actual_q", "actual_qd", "actual_current"))
    rubbing = current + 0.3 * np.sign(qd) * np.sqrt(np.abs(qd))
    columns = {"actual_q": q, "actual_qd": qd, "actual_current": rubbing}
    table = pd.DataFrame(
        {
            "time": time,
            **{f"{name}_{k}": rows[:, k] for name, rows in columns.items() for k in range(6)},
        }
    )
    robot, timing, _ = repair_frames(table, None, 0.1, "run", None)
    means = block_means(robot, timing.period, ["actual_current"])
    arm = load_robot(robot_path("ur5"))
    assert [*MotionChecks(means, arm, True).exchanges_of_joints()] == []


def ahead(motion: WholeMotion, leads: list[float]) -> Explained:
    """What leads an explanation that misses 1 by so much on each joint, by any links, too."""
    chance = 0.1 * np.random.default_rng(0).normal(size=(STRETCHES, 1))
    its = Explained(motion, motion.torque)
    its.by_links = its.by_any_links = Misfit(-np.array(leads), chance - np.array(leads))
    return its


@pytest.mark.parametrize(("others", "exchanged"), [(0.1, True), (-0.6, False)])
def test_joints_are_exchanged_where_the_others_agree(
    sensed: Robot, others: float, exchanged: bool
) -> None:
    """Their torques hang on the postures of both, and short of them links may fit by chance."""
    motion = WholeMotion(block_means(log(sensed).robot, STEP), sensed)
    declared = ahead(motion, [0.0] * 6)
    declared.by_links = declared.by_any_links = Misfit(np.zeros(6), np.zeros((STRETCHES, 6)))
    other = ahead(motion, [1.0, others, others, 1.0, others, others])
    assert are_exchanged(other, declared, (0, 3)) == exchanged


@pytest.mark.parametrize(("lead", "exchanged"), [(1.2, False), (3.0, True)])
def test_joints_that_move_alike_are_exchanged_only_by_clear_links(
    sensed: Robot, lead: float, exchanged: bool
) -> None:
    """Any links explain either order of them; described ones may err by more than wrists bear."""
    means = block_means(log(sensed).robot, STEP)
    alike = replace(means, qd=np.repeat(means.qd[:, :1], 6, axis=1) * np.arange(1.0, 7.0))
    for own, expected in ((means, True), (alike, exchanged)):
        motion = WholeMotion(own, sensed)
        declared = ahead(motion, [0.0] * 6)
        declared.by_links = declared.by_any_links = Misfit(np.zeros(6), np.zeros((STRETCHES, 6)))
        swapped = ahead(motion, [lead, 0.1, 0.1, lead, 0.1, 0.1])
        assert are_exchanged(swapped, declared, (0, 3)) == expected
        assert have_exchanged_efforts(swapped, declared, (0, 3)) == expected
        assert is_turned(swapped, declared, 3) == expected
