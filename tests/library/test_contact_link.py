"""Which link a force acts on: by identity, and on made-up torques of a real arm's geometry."""

import numpy as np
import pytest
import torch

from ur5lib.dynamics import kinematics
from ur5lib.dynamics.arm import build_arm
from ur5lib.force.contact_link import force_covariance, place_probabilities, touched_link
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE
from ur5lib.timeseries.arrays import Array

LINKS = {"elbow": 2, "forearm": 3, "flange": 6}
SIZE, COUNT = 45.0, 20  # N
FORCE = force_covariance(SIZE)


@pytest.fixture(scope="module")
def levers(ur5: Robot) -> dict[str, Array]:
    arm = build_arm(ur5, ur5.chosen_model)
    q = torch.from_numpy(np.tile(POSTURE, (COUNT, 1)))
    return {
        place: kinematics.jacobian(arm, q, link)[:, :3].numpy() for place, link in LINKS.items()
    }


def told(torque: Array, levers: dict[str, Array], spread: float) -> int | None:
    noise = np.broadcast_to(spread**2 * np.eye(6), (COUNT, 6, 6))
    return touched_link(place_probabilities(torque, levers, noise, FORCE, 0.1), LINKS)


@pytest.mark.parametrize("place", LINKS)
def test_the_touched_link_is_named(place: str, levers: dict[str, Array]) -> None:
    random = np.random.default_rng(0)
    named = []
    for _ in range(40):
        torque = (levers[place].mT @ random.normal(0, SIZE, 3)[:, None])[..., 0]
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
    found = place_probabilities(torque, levers, noise, FORCE, 0.1)
    scaled = place_probabilities(
        1e3 * torque, levers, 1e6 * noise, force_covariance(1e3 * SIZE), 0.1
    )
    assert sum(found.values()) == pytest.approx(1.0)
    assert scaled == pytest.approx(found)
