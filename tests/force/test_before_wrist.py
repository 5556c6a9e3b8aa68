"""A push on elbow or forearm at rest: what is said to be seen raises an alarm."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from benchmarks.harness.stand import currents, fitted_map, plans, residuals_of, taken
from ur5lib.force.before_wrist import LINKS, half_sphere, push_at, pushed, unseen_before_wrist
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.thresholds import alarms
from ur5lib.records.contact_place import ContactPlace
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE
from ur5lib.timeseries.arrays import Array

torch.set_num_threads(1)

PLACE = ContactPlace()
MIDDLES = {2: (0.2125, 0.0, 0.0), 3: (0.196, 0.0, 0.0)}  # in the links' frames of a UR5 [m]
START, EVERY, PUSHES = 3.0, 4.0, 7  # s
SIZES = 15.0, 400.0  # N


def resting(seed: int, link: int) -> dict[str, Any]:
    random = np.random.default_rng([seed, link])
    posture = POSTURE + random.uniform(-0.4, 0.4, 6)
    forces = [
        np.exp(random.uniform(*np.log(SIZES))) * way / np.linalg.norm(way)
        for way in random.normal(size=(PUSHES, 3))
    ]
    about = {"kind": "push", "seconds": 1.5, "link": link, "point": MIDDLES[link]}
    contacts = [
        about | {"start_s": START + EVERY * k, "force": force.tolist()}
        for k, force in enumerate(forces)
    ]
    motion = {"kind": "standstill", "posture": posture.tolist()}
    varied = {"varied_friction": True, "seed": seed, "contacts": contacts}
    return varied | {"trajectory": motion, "seconds": START + EVERY * PUSHES}


def raised(problem: Problem, jacobian: Array, prior: ContactPrior, time: Array) -> list[Array]:
    odds = problem.solve(jacobian[problem.rows], prior).log_odds
    return [time[slice(*span)] for span in alarms(np.nan_to_num(odds, nan=-np.inf), 0.0)]


@pytest.mark.slow
def test_nine_of_ten_pushes_are_seen_that_are_harder_than_is_said(tmp_path: Path) -> None:
    """And not all others are: the number says something."""
    fits = [
        taken(plan | {"varied_friction": True}, tmp_path / str(k))
        for k, plan in enumerate(plans(seed=1, seconds=14.0)[:3])
    ]
    friction = fitted_map(fits)
    residuals = residuals_of(friction, fits)
    harder, weaker = [], []
    for seed, link in ((s, one) for s in range(2) for one in LINKS):
        plan = resting(seed, link)
        own = taken(plan, tmp_path / f"{seed}-{link}")
        problem = fmap_problem(own.motion, currents(friction, own), residuals)
        assert problem is not None
        prior = ContactPrior.of(own.robot, None, PLACE)
        said = unseen_before_wrist(problem, own.kinematics, own.robot, prior, PLACE, 0.0)
        seen = raised(problem, own.kinematics.jacobian, prior, own.motion.time)
        for push in plan["contacts"]:
            start, end = push["start_s"], push["start_s"] + 1.8
            found = any(((span > start) & (span < end)).any() for span in seen)
            size = float(np.linalg.norm(push["force"]))
            (harder if size > said[f"unseen_link_{link}_n"] else weaker).append(found)
    assert len(harder) >= 3
    assert np.mean(harder) >= 0.9
    assert np.mean(weaker) < 0.9


def test_trial_pushes_load_the_joints_up_to_their_link(ur5: Robot) -> None:
    second, third = pushed(ur5, np.array([POSTURE]))
    assert not second[:, 2:].any()
    assert not third[:, 3:].any()
    assert (np.abs(third[:, :3]).max(axis=0) > np.abs(second[:, :3]).max(axis=0))[:2].all()


def test_directions_share_a_half_sphere() -> None:
    ways = half_sphere(200)
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1)
    np.testing.assert_allclose(ways.T @ ways / 200, np.eye(3) / 3, atol=0.01)


def test_a_trial_push_is_in_the_middle() -> None:
    push = push_at(np.linspace(0, 3, 301))
    np.testing.assert_allclose(push, push[::-1], atol=1e-12)
    assert push[150] == pytest.approx(1)
    assert not push[:100].any()
