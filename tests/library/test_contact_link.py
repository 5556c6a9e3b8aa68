"""Which link a force acts on: by identity, and on made-up torques of a real arm's geometry."""

import numpy as np
import pytest
import torch

from ur5lib.dynamics import kinematics
from ur5lib.dynamics.arm import build_arm
from ur5lib.force.contact_link import SURE, link_probabilities, place_probabilities, touched_link
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE
from ur5lib.timeseries.arrays import Array

LINKS = {"elbow": 2, "forearm": 3, "flange": 6}
SIZES, COUNT = (5.0, 15.0, 45.0), 20  # N, samples


@pytest.fixture(scope="module")
def levers(ur5: Robot) -> dict[str, Array]:
    arm = build_arm(ur5, ur5.chosen_model)
    q = torch.from_numpy(np.tile(POSTURE, (COUNT, 1)))
    return {
        place: kinematics.jacobian(arm, q, link)[:, :3].numpy() for place, link in LINKS.items()
    }


def told(torque: Array, levers: dict[str, Array], spread: float) -> int | None:
    noise = np.broadcast_to(spread**2 * np.eye(6), (COUNT, 6, 6))
    return touched_link(
        link_probabilities(place_probabilities(torque, levers, noise, SIZES), LINKS)
    )


@pytest.mark.parametrize("place", LINKS)
def test_the_touched_link_is_named(place: str, levers: dict[str, Array]) -> None:
    random = np.random.default_rng(0)
    named = []
    for _ in range(40):
        torque = (levers[place].mT @ random.normal(0, SIZES[-1], 3)[:, None])[..., 0]
        named.append(told(torque + random.normal(0, 0.3, 6), levers, 0.3))
    stated = [own for own in named if own is not None]
    assert len(stated) >= 20
    assert np.mean([own == LINKS[place] for own in stated]) >= 0.9


def test_noise_names_no_link_that_it_hides(levers: dict[str, Array]) -> None:
    torque = (levers["elbow"].mT @ np.full((3, 1), 5.0))[..., 0]
    assert told(torque, levers, 30.0) is None


def test_places_with_the_same_lever_are_not_told_apart(levers: dict[str, Array]) -> None:
    torque = (levers["flange"].mT @ np.full((3, 1), 40.0))[..., 0]
    same = dict.fromkeys(LINKS, levers["flange"])
    assert told(torque, same, 0.3) is None


def test_probabilities_sum_to_one_and_do_not_depend_on_units(levers: dict[str, Array]) -> None:
    torque = (levers["forearm"].mT @ np.full((3, 1), 3.0))[..., 0]
    noise = np.broadcast_to(np.eye(6), (COUNT, 6, 6))
    found = place_probabilities(torque, levers, noise, SIZES)
    scaled = place_probabilities(1e3 * torque, levers, 1e6 * noise, [1e3 * size for size in SIZES])
    assert sum(found.values()) == pytest.approx(1.0)
    assert scaled == pytest.approx(found)


def guessed(sizes: tuple[float, ...], levers: dict[str, Array]) -> tuple[Array, Array]:
    """Return the probability of the likeliest place, and whether it is the right one."""
    random = np.random.default_rng(1)
    noise = np.broadcast_to(4.0 * np.eye(6), (COUNT, 6, 6))
    stated, right = [], []
    for place in random.choice([*LINKS], 300):
        torque = levers[place].mT @ random.normal(0, random.choice(sizes), 3)
        found = place_probabilities(torque + random.normal(0, 2.0, 6), levers, noise, SIZES)
        best = max(found, key=found.__getitem__)
        stated.append(found[best])
        right.append(best == place)
    return np.array(stated), np.array(right)


def test_the_stated_odds_hold(levers: dict[str, Array]) -> None:
    stated, right = guessed(SIZES, levers)
    assert stated.mean() == pytest.approx(right.mean(), abs=0.08)


def test_a_force_below_the_noise_names_no_link(levers: dict[str, Array]) -> None:
    stated, _ = guessed((1.0,), levers)
    assert (stated >= SURE).mean() <= 0.02
