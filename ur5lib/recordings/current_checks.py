"""Checks of currents against gravity: their unit, and loads that nothing declares."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ur5lib.recordings.block_means import BlockMeans, fitted_load, size
from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import load_torque
from ur5lib.timeseries.arrays import Array

BEARING = 3.0  # Nm; a joint with less gravity torque says nothing about its current
CONSTANTS = (2.5, 40.0)  # Nm/A; the torque constants of all arms lie between
ONE = (0.5, 2.0)  # Nm per “A” where the current is a torque
SURE = 5.0  # standard errors
UNEXPLAINED = 0.5  # share of a current's square that gravity, friction and inertia may leave
UNDECLARED = 1.0  # kg; right recordings show up to 0.4 kg, all of it friction
SEEN = 0.2  # least share of the difference of the currents that such a load explains


class Held(NamedTuple):
    """Current per torque of gravity [A/Nm], its standard error, and the share left unexplained."""

    slope: float
    error: float
    left: float


def foreign_currents(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find currents that are not in A: too many or too few of them hold gravity.

    arm: with what it carries.
    """
    gravity = means.gravity(arm)
    joint = int(np.argmax((gravity**2).mean(axis=0)))
    if np.sqrt((gravity[:, joint] ** 2).mean()) < BEARING:
        return
    for name, current in means.currents.items():
        held = _held(means, gravity, current, joint)
        away = SURE * held.error
        if held.left < UNEXPLAINED and not (
            1 / CONSTANTS[1] < held.slope + away and held.slope - away < 1 / CONSTANTS[0]
        ):
            constant = 1 / (held.slope or 1e-9)
            code = "torque as current" if ONE[0] <= constant <= ONE[1] else "no current"
            yield contradiction(code, name=name, joint=joint + 1, constant=constant)


def undeclared_load(means: BlockMeans, told: Robot, carrying: Robot) -> Iterator[Finding]:
    """Find a load that neither the study nor the controller knows, by which currents differ.

    told: the arm with the payload that the controller knows; carrying: with the declared one.
    """
    if {"actual_current", "target_current"} - means.currents.keys():
        return
    columns, torque = _unexpected(means, told, means.gravity(carrying) - means.gravity(told))
    if len(torque):
        mass, left = fitted_load(columns, torque)
        if mass > UNDECLARED and left**2 < (1 - SEEN) * size(torque) ** 2:
            yield contradiction("undeclared load", mass=mass)


def _held(means: BlockMeans, gravity: Array, current: Array, joint: int) -> Held:
    """Return how much of a joint's current holds gravity, beside friction and inertia."""
    own = current[:, joint]
    columns = np.column_stack([gravity[:, joint], means.friction(joint), means.qdd])
    inverse = np.linalg.pinv(columns)
    solution = inverse @ own
    left = size(own - columns @ solution)
    error = left / np.sqrt(max(1, len(own) - columns.shape[1])) * np.linalg.norm(inverse[0])
    return Held(float(solution[0]), float(error), (left / size(own)) ** 2)


def _unexpected(means: BlockMeans, told: Robot, declared: Array) -> tuple[Array, Array]:
    """Return torque per load (n, 4), and the torque (n,) that measured currents hold beyond
    target_current, both without friction and in units of its spread, of all joints that bear.

    declared: torque (M, 6) [Nm] that is known to be in it.
    """
    gravity, loads = means.gravity(told), load_torque(told, means.q)
    measured, target = means.currents["actual_current"], means.currents["target_current"]
    rows = [np.empty((0, 5))]
    for joint in range(6):
        held = _held(means, gravity, target, joint)
        if held.left < UNEXPLAINED and 1 / CONSTANTS[1] < held.slope < 1 / CONSTANTS[0]:
            torque = (measured - target)[:, joint] / held.slope - declared[:, joint]
            pair, friction = np.column_stack([loads[:, joint], torque]), means.friction(joint)
            pair -= friction @ np.linalg.lstsq(friction, pair, rcond=None)[0]
            rows.append(pair / max(pair[:, -1].std(), 0.1))
    every = np.vstack(rows)
    return every[:, :-1], every[:, -1]
