"""Which link a force acts on: by identity, and on made-up torques of a real arm's geometry."""

import numpy as np
import pytest

from ur5lib.dynamics.flange import flange_kinematics, link_frames
from ur5lib.force.contact_link import (
    SURE,
    lever,
    likely_links,
    link_probabilities,
    places,
    touched_link,
)
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE
from ur5lib.timeseries.arrays import Array

SIZES, COUNT = (5.0, 15.0, 45.0, 135.0), 3  # N, samples
Frames = tuple[Array, Array]
Levers = dict[int, list[Array]]


def frames_at(robot: Robot, posture: Array) -> Frames:
    return link_frames(robot, np.tile(posture, (COUNT, 1)))


def levers_of(frames: Frames) -> Levers:
    along = places(*frames)
    return {link: [lever(*frames, link, own) for own in along[link]] for link in along}


@pytest.fixture(scope="module")
def levers(ur5: Robot) -> Levers:
    return levers_of(frames_at(ur5, POSTURE))


def found(torque: Array, levers: Levers, spread: float, scale: float = 1.0) -> dict[int, float]:
    """Return the probabilities of the links, by torques in Nm / scale."""
    noise = np.broadcast_to((scale * spread) ** 2 * np.eye(6), (COUNT, 6, 6))
    arms = {link: [scale * J for J in own] for link, own in levers.items()}
    return link_probabilities(scale * torque, arms, noise, SIZES, 0.0)


def test_the_lever_of_the_flange_is_its_jacobian(ur5: Robot) -> None:
    frames = frames_at(ur5, POSTURE)
    jacobian = flange_kinematics(ur5, np.tile(POSTURE, (COUNT, 1)))[2]
    assert lever(*frames, 6, frames[1][:, 6]) == pytest.approx(jacobian, abs=1e-9)


@pytest.mark.parametrize("link", range(1, 7))
def test_joints_beyond_a_link_carry_nothing_of_its_contacts(levers: Levers, link: int) -> None:
    for J in levers[link]:
        assert not J[:, :, link:].any()
        assert J[:, 3:, :link].any(axis=1).all()


def test_places_are_as_dense_along_every_link(ur5: Robot) -> None:
    """None is further than half a step from the next place, whatever the link's length."""
    frames = frames_at(ur5, POSTURE)
    for link, along in places(*frames).items():
        if link < 6:
            ends = frames[1][:, link - 1], frames[1][:, link]
            middle = sum(along) / len(along)
            assert middle == pytest.approx((ends[0] + ends[1]) / 2)
            apart = np.linalg.norm(ends[1] - ends[0], axis=1) / len(along)
            assert (apart <= 0.1 + 1e-9).all()


def trial(robot: Robot, random: np.random.Generator, spread: float) -> tuple[int, dict[int, float]]:
    """Return the link of a contact anywhere on it, and what its torques tell."""
    frames = frames_at(robot, random.uniform(-2.5, 2.5, 6))
    levers, link = levers_of(frames), int(random.integers(1, 7))
    J = levers[link][random.integers(len(levers[link]))]
    force = random.normal(0, random.choice(SIZES), 3)
    moment = random.normal(0, 0.05 * np.linalg.norm(force) / np.sqrt(3), 3)
    torque = J.mT @ np.concatenate([force, moment]) + random.normal(0, spread, 6)
    return link, found(torque, levers, spread)


def test_the_stated_odds_hold_anywhere_on_the_arm(ur5: Robot) -> None:
    random = np.random.default_rng(1)
    trials = [trial(ur5, random, 1.0) for _ in range(150)]
    stated = np.mean([max(links.values()) for _, links in trials])
    right = np.mean([max(links, key=links.__getitem__) == link for link, links in trials])
    held = np.mean([link in likely_links(links) for link, links in trials])
    named = [(link, touched_link(links)) for link, links in trials if touched_link(links)]
    assert stated == pytest.approx(right, abs=0.06)
    assert held >= 0.92
    assert len(named) >= 10
    assert np.mean([link == own for link, own in named]) >= 0.9


@pytest.mark.parametrize("link", [3, 4])
def test_contacts_on_forearm_and_wrist_are_not_ascribed_to_others(ur5: Robot, link: int) -> None:
    """Not at the confidence that is stated, wherever on the link and in whatever posture."""
    random, wrong = np.random.default_rng(link), 0
    for _ in range(50):
        levers = levers_of(frames_at(ur5, random.uniform(-2.5, 2.5, 6)))
        J = levers[link][random.integers(len(levers[link]))]
        force = np.append(random.normal(0, 30.0, 3), [0, 0, 0])
        links = found(J.mT @ force + random.normal(0, 1.0, 6), levers, 1.0)
        wrong += touched_link(links) not in (None, link)
    assert wrong <= 0.05 * 50


def test_noise_names_no_link_that_it_hides(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([5.0, 5, 5, 0, 0, 0])
    links = found(torque, levers, 30.0)
    assert touched_link(links) is None
    assert len(likely_links(links)) == 6


def test_links_with_the_same_lever_are_not_told_apart(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([40.0, 40, 40, 0, 0, 0])
    links = found(torque, dict.fromkeys(range(1, 7), levers[6]), 0.3)
    assert [*links.values()] == pytest.approx([1 / 6] * 6)


def test_probabilities_do_not_depend_on_units(levers: Levers) -> None:
    torque = levers[3][0].mT @ np.array([30.0, 3, 3, 0, 0, 0])
    links = found(torque, levers, 1.0)
    assert sum(links.values()) == pytest.approx(1.0)
    assert found(torque, levers, 1.0, scale=1e3) == pytest.approx(links)


def test_load_friction_makes_a_contact_less_telling(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([60.0, 60, 60, 0, 0, 0])
    noise = np.broadcast_to(np.eye(6), (COUNT, 6, 6))
    sharp, loaded = (
        link_probabilities(torque, levers, noise, SIZES, share) for share in (0.0, 0.5)
    )
    assert max(loaded.values()) < max(sharp.values())


def test_the_likely_links_are_the_fewest_that_are_sure() -> None:
    assert likely_links({1: 0.01, 2: 0.02, 3: 0.3, 4: 0.67}) == [3, 4]
    assert touched_link({1: 0.01, 2: 0.02, 3: 0.3, 4: 0.67}) is None
    assert touched_link({5: 1 - SURE, 6: SURE}) == 6
