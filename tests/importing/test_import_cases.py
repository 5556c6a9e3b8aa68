"""`ur5 import` on random logs of all arms: proven, assumed or refused, never silently wrong."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.entries import in_words
from tests.stored_files import JOINTS
from ur5lib.checks.readings import usual_orders
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import FileClocks
from ur5lib.importing.contents import (
    FileContents,
    TableHeader,
    UserStatement,
)
from ur5lib.importing.proposal import Proposal, meanings, propose
from ur5lib.robots.description import Robot, load_robot, robot_names, robot_path
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.timeseries.arrays import Array

EFFORTS = ("actual_current", "actual_current_as_torque", "actual_torque_less_gravity")


@dataclass(frozen=True)
class Log:
    """A log as a lab may have it, and what is true of it.

    q, qd: (N, 6) [rad, rad/s] in the arm's order; efforts: (N, 6) by channel, in SI units; wrench:
    (N, 6), base frame, the arm on its surroundings, None without a contact.
    """

    file: FileContents
    arm: str
    q: Array
    qd: Array
    efforts: dict[str, Array]
    wrench: Array | None


def made_up(seed: int, rate: float, seconds: float) -> Log:
    """A random arm on a random path, recorded in a random way at a rate [Hz]."""
    random = np.random.default_rng(seed)
    arm = load_robot(robot_path(str(random.choice(robot_names()))))
    time = np.arange(0, seconds, 1 / rate)
    q, qd, qdd = motion(arm, time, random)
    wrench = pushes(time, random) if random.random() < 0.4 else None
    efforts = driven(arm, q, qd, qdd, wrench, random)
    kind = str(random.choice(EFFORTS))
    blocks = {"q": q, "qd": qd, "effort": efforts[kind]}
    if kind == EFFORTS[0] and random.random() < 0.3:
        blocks["effort"] = 1e3 * blocks["effort"]  # mA
    if kind != EFFORTS[2] and random.random() < 0.2:
        blocks["effort"] = -blocks["effort"]
    if random.random() < 0.3:
        blocks |= {"q": np.degrees(q), "qd": np.degrees(qd)}
    named = random.random() < 0.3
    usual = usual_orders(6)
    order = np.array(usual[0] if named else usual[int(random.integers(3))])
    parts = [*joint_blocks(blocks, order, named), *wrench_blocks(wrench, random)]
    stated = UserStatement(arm.name if random.random() < 0.9 else "")
    clocks = FileClocks({"time": time}, {})
    file = FileContents(Path("log.csv"), "table-csv", TableHeader(), parts, [], clocks, [], stated)
    return Log(file, arm.name, q, qd, efforts, wrench)


def motion(arm: Robot, time: Array, random: np.random.Generator) -> tuple[Array, Array, Array]:
    """Positions, velocities and accelerations (N, 6) of some joints that swing, at 1 to 3 rates."""
    fastest = np.array(arm.velocity_limits())
    moving = random.random(6) < random.choice([0.3, 1.0, 1.0])
    rates = 2 * np.pi * random.uniform(0.05, 0.5, (3, 6))
    size = moving * random.uniform(0.2, 0.9, (3, 6)) * fastest / rates / 6
    phase = random.uniform(0, 2 * np.pi, (3, 6))
    angle = time[:, None, None] * rates + phase
    middle = np.array([0.0, -1.2, 1.0, -1.0, 1.2, 0.3]) + random.uniform(-0.5, 0.5, 6)
    parts = size * np.sin(angle), size * rates * np.cos(angle), -size * rates**2 * np.sin(angle)
    q, qd, qdd = (part.sum(axis=1) for part in parts)
    noise = random.normal(0, 1e-5, q.shape), random.normal(0, 1e-3, q.shape)
    return middle + q + noise[0], qd + noise[1], qdd


def pushes(time: Array, random: np.random.Generator) -> Array:
    """A force (N, 6) [N, Nm] along changing axes."""
    force = random.uniform(10, 40, 3) * np.sin(np.outer(time, random.uniform(1, 4, 3)))
    return np.hstack([force, 0.02 * force[:, ::-1]])


def driven(
    arm: Robot, q: Array, qd: Array, qdd: Array, wrench: Array | None, random: np.random.Generator
) -> dict[str, Array]:
    """Efforts (N, 6) by channel: gravity, rotors, friction, the push and noise."""
    motors = [arm.motor(joint) for joint in arm.joint_numbers]
    constants = np.array(arm.maker_torque_constants()) * random.uniform(0.9, 1.1, 6)
    most = np.array([motor.torque_max for motor in motors])
    rotors = np.array([motor.reflected_rotor() or 0.0 for motor in motors])
    friction = 0.04 * most * np.tanh(qd / 0.02) + 0.03 * most * qd
    free = 1.5 * rotors * qdd + friction + 0.004 * most * random.normal(size=q.shape)
    if wrench is not None:
        rotation, origin = link_frames(arm, q)
        axes, lever = rotation[:, :6, :, 2], origin[:, 6:] - origin[:, :6]
        jacobian = np.concatenate([np.cross(axes, lever), axes], axis=2)
        free = free + np.einsum("nji,ni->nj", jacobian, wrench)
    torque = free + gravity_torque(arm, arm.chosen_model, q)
    return dict(zip(EFFORTS, (torque / constants, torque, free), strict=True))


def joint_blocks(blocks: dict[str, Array], order: Array, named: bool) -> Iterator[ColumnBlock]:
    for name, rows in blocks.items():
        names = tuple(f"{joint}_{name}" for joint in JOINTS) if named else (name,)
        yield ColumnBlock(names, rows[:, order], "time")


def wrench_blocks(wrench: Array | None, random: np.random.Generator) -> Iterator[ColumnBlock]:
    """Force and moment, sometimes with axes exchanged."""
    if wrench is not None:
        axes = random.permutation(3) if random.random() < 0.4 else np.arange(3)
        for name, part in (("force", wrench[:, :3]), ("torque", wrench[:, 3:])):
            yield ColumnBlock((name,), part[:, axes], "time")


def silently_wrong(log: Log, proposal: Proposal) -> list[str]:
    """What a proposal has wrong without saying that it is assumed."""
    rows = log.file.account.rows(meanings(proposal))
    assumed, wrong = in_words(row for row in rows if row.confidence == "check"), list[str]()
    order = np.array(proposal.order)
    found = {name: blocks[0].rows for name, blocks in proposal.channels.items()}
    factor = np.pi / 180 if "actual_q" in proposal.units else 1.0
    if proposal.arm != log.arm and "robot" not in assumed:
        wrong.append(f"arm {proposal.arm} for {log.arm}")
    right = np.allclose(factor * found["actual_q"][:, order], log.q)
    right &= np.allclose(factor * found["actual_qd"][:, order], log.qd)
    if not right and "the joints' order" not in assumed:
        wrong.append(f"order or unit of the positions {proposal.order}")
    for name in found.keys() & {*EFFORTS}:
        rows = found[name][:, order] if right else np.sort(found[name])
        truth = log.efforts[name] if right else np.sort(log.efforts[name])
        doubted = "in Nm, less gravity" in assumed or "in an unknown unit" in assumed
        if not np.allclose(rows, truth) and not doubted:
            wrong.append(f"{name} is another effort")
    return wrong + ([] if right_wrench(log, proposal, assumed) else ["the force"])


def right_wrench(log: Log, proposal: Proposal, assumed: str) -> bool:
    """Whether a wrench is none, or that of the arm in the base's frame, but for an assumed sign."""
    blocks = proposal.sensor or proposal.channels.get("actual_TCP_force")
    if not blocks or log.wrench is None:
        return not blocks
    rows = np.hstack([block.rows for block in blocks]) * (-1 if proposal.opposite else 1)
    signs = (1, -1) if "sign of actual_TCP_force" in assumed else (1,)
    return not proposal.sensor and any(np.allclose(sign * rows, log.wrench) for sign in signs)


def outcome(seed: int, rate: float, seconds: float) -> str:
    log = made_up(seed, rate, seconds)
    proposal = propose(log.file)
    assert silently_wrong(log, proposal) == [], seed
    rows = log.file.account.rows(meanings(proposal))
    return "check" if any(row.confidence == "check" for row in rows) else "proven"


@pytest.mark.parametrize("seed", [1, 9, 11, 12, 16, 19])
def test_nothing_is_silently_wrong(seed: int) -> None:
    outcome(seed, 125.0, 20.0)


@pytest.mark.slow
@pytest.mark.thorough
def test_nothing_is_silently_wrong_in_a_hundred_cases() -> None:
    outcomes = [outcome(seed, 50.0, 10.0) for seed in range(100)]
    assert outcomes.count("proven") > 20
