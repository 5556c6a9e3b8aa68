"""How hard elbow or forearm may be pushed at rest without an alarm.

Friction keeps a part of the push, and what is left looks unlike a contact at the flange.
"""

from dataclasses import replace

import numpy as np

from ur5lib.force.contact_place import jacobian_at
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import is_still
from ur5lib.force.gate import Observations, contact_probabilities, log_odds
from ur5lib.force.problem import Problem
from ur5lib.force.touched_link import place_jacobian
from ur5lib.force.trial_contacts import PUSH_DURATION
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.dynamics import Kinematics
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

LINKS = 2, 3  # before the wrist; their middles are pushed
SEEN_SHARE = 0.9  # of harder pushes, in any direction
DIRECTIONS = 12  # of trial pushes on each link
SIZES = 0.25, 100.0  # smallest and largest trial push, in typical forces
HALVINGS = 6  # of the logarithm of their ratio
SECONDS, PERIOD = 3.0, 0.1  # s, of rest around a trial push in its middle; between its samples


def unseen_before_wrist(
    problem: Problem,
    kinematics: Kinematics,
    arm: Robot,
    prior: ContactPrior,
    place: ContactPlace,
    threshold: float,
) -> dict[str, float]:
    """Return, as columns of `Detection`, the push [N] on each of LINKS from which on SEEN_SHARE
    raise an alarm in the pose of the longest rest.

    place: where contacts are assumed; threshold: of alarms, in log-odds. Empty without a rest; the
    largest trial where that is not seen.
    """
    still = runs(is_still(problem.input.states) & np.isfinite(problem.input.q).all(axis=1))
    if not len(still) or len(arm.joints) <= max(LINKS):
        return {}
    row = int(still[np.diff(still).argmax()].mean())
    at_place = jacobian_at(kinematics.jacobian, place.on(kinematics.rotation))[row]
    seen = at_rest(problem, row, at_place, prior)
    per_newton = np.concatenate(pushed(arm, problem.input.q[row : row + 1]))
    random, model = np.random.default_rng(0), problem.model
    kept = random.uniform(size=per_newton.shape) * model.stiction * model.breakaway
    pulse = push_at(np.arange(0.0, SECONDS, PERIOD))

    def raises(force: Array) -> Mask:
        torque = force[:, None] * per_newton
        felt = torque - np.clip(torque, -kept, kept)
        found = contact_probabilities(seen, pulse[:, None] * felt[:, None])
        return np.array([log_odds(one).max() >= threshold for one in found])

    low, high = (np.full(len(per_newton), size * prior.force) for size in SIZES)
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        seen_there = raises(middle)
        low, high = np.where(seen_there, low, middle), np.where(seen_there, middle, high)
    unseen = np.quantile(high.reshape(len(LINKS), -1), SEEN_SHARE, axis=1, method="higher")
    names = [f"unseen_link_{link}_n" for link in LINKS]
    return dict(zip(names, unseen.tolist(), strict=True))


def at_rest(problem: Problem, row: int, jacobian: Array, prior: ContactPrior) -> Observations:
    """Return SECONDS of an untouched rest in a sample's pose."""
    count = round(SECONDS / PERIOD)
    rest = problem.input.thinned(1, np.full(count, row))
    rest = replace(rest, torque=np.zeros_like(rest.torque), period=PERIOD)
    return Observations.of(rest, np.tile(jacobian, (count, 1, 1)), problem.model, prior)


def pushed(arm: Robot, q: Array) -> list[Array]:
    """Return the joint torques (DIRECTIONS, n) [Nm] of forces of 1 N on the middle of each of
    LINKS; q: (1, n) [rad].
    """
    rotation, origin = link_frames(arm, q)
    middles = {link: origin[:, [link - 1, link]].mean(axis=1) for link in LINKS}
    return [
        half_sphere(DIRECTIONS) @ place_jacobian(rotation, origin, link, middle)[0, :3]
        for link, middle in middles.items()
    ]


def half_sphere(count: int) -> Array:
    """Return directions (count, 3) that share a half sphere evenly (Fibonacci's spiral)."""
    height, turn = (np.arange(count) + 0.5) / count, np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)


def push_at(time: Array) -> Array:
    """Return a push (N,) of height 1 in the middle of SECONDS, as it rises and falls."""
    since = (time - (SECONDS - PUSH_DURATION) / 2) / PUSH_DURATION
    return np.where((since > 0) & (since < 1), np.sin(np.pi * since) ** 2, 0.0)
