"""Whether a contact may be at the flange: by identity, and on made-up torques of a real arm."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import MODEL, PRIOR, free_run, torque_of
from ur5lib.force.alarms import Alarm
from ur5lib.force.external_torque import joint_states
from ur5lib.force.flange_contact import (
    MAX_CONTACT_SAMPLES,
    MIN_PROBABILITY_ELSEWHERE,
    PLACE_SPACING,
    flange_probability,
    judged_by_torques,
    middle_half,
    place_jacobian,
    places,
)
from ur5lib.force.force_input import ForceInput
from ur5lib.force.problem import Problem
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics, link_frames
from ur5lib.stand.plan import POSTURE
from ur5lib.timeseries.arrays import Array

SIZES, COUNT = (5.0, 15.0, 45.0, 135.0), 3  # N, samples
Frames = tuple[Array, Array]
Levers = dict[int, list[Array]]


def frames_at(robot: Robot, posture: Array) -> Frames:
    return link_frames(robot, np.tile(posture, (COUNT, 1)))


def levers_of(frames: Frames) -> Levers:
    along = places(*frames)
    return {link: [place_jacobian(*frames, link, own) for own in along[link]] for link in along}


def test_a_contact_is_judged_by_its_middle_half_where_torques_are_known() -> None:
    time, segment = 0.008 * np.arange(2500), np.zeros(2500, int)
    phase = time[:, None] + np.arange(6)
    torque = np.zeros_like(phase)
    torque[1000:1100, 2] = np.nan
    states = joint_states(np.cos(phase), segment, 0.008, cutoff=2.0)
    given = ForceInput(np.sin(phase), np.cos(phase), torque, states, segment, 0.008)
    for start, end in ((2.0, 2.2), (4.0, 12.0), (8.2, 8.6)):
        rows = middle_half(given, time, start, end)
        middle = np.abs(time - (start + end) / 2) <= (end - start) / 4
        known = middle & np.isfinite(torque).all(axis=1)
        assert set(rows) <= {*np.flatnonzero(known)}
        assert len(rows) >= min(MAX_CONTACT_SAMPLES, known.sum())
        if len(rows):
            assert time[rows[-1]] - time[rows[0]] > 0.9 * np.ptp(time[known])


@pytest.fixture(scope="module")
def levers(ur5: Robot) -> Levers:
    return levers_of(frames_at(ur5, POSTURE))


def found(torque: Array, levers: Levers, spread: float, scale: float = 1.0) -> float:
    """Return the probability of the flange, by torques in Nm / scale."""
    noise = np.broadcast_to((scale * spread) ** 2 * np.eye(6), (COUNT, 6, 6))
    arms = {link: [scale * J for J in own] for link, own in levers.items()}
    return flange_probability(scale * torque, arms, noise, SIZES, 0.0)


def test_the_lever_of_the_flange_is_its_jacobian(ur5: Robot) -> None:
    frames = frames_at(ur5, POSTURE)
    jacobian = flange_kinematics(ur5, np.tile(POSTURE, (COUNT, 1)))[2]
    assert place_jacobian(*frames, 6, frames[1][:, 6]) == pytest.approx(jacobian, abs=1e-9)


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


def test_a_link_has_no_more_places_than_its_length_needs(ur5: Robot) -> None:
    """The tool, too, which is exactly two steps long."""
    for along in places(*frames_at(ur5, POSTURE)).values():
        if len(along) > 1:
            length = len(along) * np.linalg.norm(along[1] - along[0], axis=1)
            assert (length / (len(along) - 1) > PLACE_SPACING + 1e-6).all()


def trial(robot: Robot, random: np.random.Generator) -> tuple[int, float]:
    """Return the link of a contact anywhere on it, and the probability of the flange."""
    levers, link = levers_of(frames_at(robot, random.uniform(-2.5, 2.5, 6))), random.integers(1, 7)
    J = levers[int(link)][random.integers(len(levers[int(link)]))]
    force = random.normal(0, random.choice(SIZES), 3)
    moment = random.normal(0, 0.05 * np.linalg.norm(force) / np.sqrt(3), 3)
    torque = J.mT @ np.concatenate([force, moment]) + random.normal(0, 1.0, 6)
    return int(link), found(torque, levers, 1.0)


def test_the_stated_odds_of_the_flange_hold(ur5: Robot) -> None:
    """A contact at the flange is hardly ever excluded, most of others are at least once in two."""
    random = np.random.default_rng(1)
    trials = [trial(ur5, random) for _ in range(150)]
    at_flange = np.array([link == 6 for link, _ in trials])
    stated = np.array([probability for _, probability in trials])
    excluded = stated <= 1 - MIN_PROBABILITY_ELSEWHERE
    assert stated.mean() == pytest.approx(at_flange.mean(), abs=0.06)
    assert excluded[at_flange].mean() <= 1 - MIN_PROBABILITY_ELSEWHERE
    assert excluded[~at_flange].mean() >= 0.5


def test_noise_excludes_nothing_that_it_hides(levers: Levers) -> None:
    torque = levers[3][0].mT @ np.array([5.0, 5, 5, 0, 0, 0])
    assert found(torque, levers, 30.0) > 1 - MIN_PROBABILITY_ELSEWHERE


def test_links_with_the_same_lever_are_not_told_apart(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([40.0, 40, 40, 0, 0, 0])
    assert found(torque, dict.fromkeys(range(1, 7), levers[6]), 0.3) == pytest.approx(1 / 6)


def test_the_probability_does_not_depend_on_units(levers: Levers) -> None:
    torque = levers[5][0].mT @ np.array([30.0, 3, 3, 0, 0, 0])
    assert found(torque, levers, 1.0, scale=1e3) == pytest.approx(found(torque, levers, 1.0))


def test_load_friction_makes_a_contact_less_telling(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([60.0, 60, 60, 0, 0, 0])
    noise = np.broadcast_to(np.eye(6), (COUNT, 6, 6))
    sharp, loaded = (
        flange_probability(torque, levers, noise, SIZES, share) for share in (0.0, 0.5)
    )
    assert loaded < sharp


@pytest.mark.parametrize("link", [3, 6])
def test_contacts_alone_are_judged_where_torques_are_known(ur5: Robot, link: int) -> None:
    """A push of the forearm is off the flange; a load, or a push that no torque shows, is not."""
    run = free_run(ur5, 0, seconds=4.0, moving=False, scale=0.0)
    frames = link_frames(ur5, run.q)
    J = place_jacobian(*frames, link, places(*frames)[link][-1])
    torque = torque_of(J, np.tile([60.0, -80.0, 90.0, 0.0, 0.0, 0.0], (len(run.time), 1)))
    unknown = np.where(np.arange(6) == 2, np.nan, torque)
    contact = Alarm(1.0, 3.0, 2.0, np.zeros(3), np.ones(3), run.q[0])
    load = replace(contact, kind="load")
    shown, hidden = (Problem(run.input(torque=own), MODEL) for own in (torque, unknown))
    found = judged_by_torques(ur5, shown, run.time, PRIOR, [contact, load])
    assert [one.off_flange for one in found] == [link != 6, False]
    assert judged_by_torques(ur5, hidden, run.time, PRIOR, [contact]) == [contact]
