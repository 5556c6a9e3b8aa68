"""Which link is touched: by identity, and on made-up torques of a real arm."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import MODEL, PRIOR, free_run, torque_of
from ur5lib.force.alarms import Alarm
from ur5lib.force.contact_wrench import ContactWrench
from ur5lib.force.external_torque import joint_states
from ur5lib.force.flange_contact import MAX_CONTACT_SAMPLES, judged_by_torques, middle_half
from ur5lib.force.force_input import ForceInput
from ur5lib.force.problem import Problem
from ur5lib.force.touched_link import (
    LAST_LINK_SHARE,
    LIKELY,
    PLACE_SPACING,
    Samples,
    mixture,
    off_flange,
    place_jacobian,
    place_jacobians,
    place_probabilities,
    places,
    touched,
)
from ur5lib.records.forces import Forces
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
    return 1 - off_flange(place_probabilities(scale * torque, arms, noise, SIZES, 0.0))


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
    levers = levers_of(frames_at(robot, random.uniform(-2.5, 2.5, 6)))
    link = 6 if random.random() < LAST_LINK_SHARE else random.integers(1, 6)
    J = levers[int(link)][random.integers(len(levers[int(link)]))]
    force = random.normal(0, random.choice(SIZES), 3)
    moment = random.normal(0, 0.05 * np.linalg.norm(force) / np.sqrt(3), 3)
    torque = J.mT @ np.concatenate([force, moment]) + random.normal(0, 1.0, 6)
    return int(link), found(torque, levers, 1.0)


def test_the_stated_odds_of_the_flange_hold(ur5: Robot) -> None:
    """A contact at the flange is hardly ever excluded, others are at least once in two."""
    random = np.random.default_rng(1)
    trials = [trial(ur5, random) for _ in range(300)]
    at_flange = np.array([link == 6 for link, _ in trials])
    stated = np.array([probability for _, probability in trials])
    excluded = stated <= 1 - LIKELY
    assert stated.mean() == pytest.approx(at_flange.mean(), abs=0.06)
    assert excluded[at_flange].mean() <= 0.05
    assert excluded[~at_flange].mean() >= 0.5


def test_noise_excludes_nothing_that_it_hides(levers: Levers) -> None:
    torque = levers[3][0].mT @ np.array([5.0, 5, 5, 0, 0, 0])
    assert found(torque, levers, 30.0) > 1 - LIKELY


def test_links_with_the_same_lever_are_not_told_apart(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([40.0, 40, 40, 0, 0, 0])
    same = dict.fromkeys(range(1, 7), levers[6])
    assert found(torque, same, 0.3) == pytest.approx(LAST_LINK_SHARE)


def test_the_probability_does_not_depend_on_units(levers: Levers) -> None:
    torque = levers[5][0].mT @ np.array([30.0, 3, 3, 0, 0, 0])
    assert found(torque, levers, 1.0, scale=1e3) == pytest.approx(found(torque, levers, 1.0))


def test_load_friction_makes_a_contact_less_telling(levers: Levers) -> None:
    torque = levers[6][0].mT @ np.array([60.0, 60, 60, 0, 0, 0])
    noise = np.broadcast_to(np.eye(6), (COUNT, 6, 6))
    sharp, loaded = (
        off_flange(place_probabilities(torque, levers, noise, SIZES, share)) for share in (0.0, 0.5)
    )
    assert loaded > sharp


def test_a_mixture_has_the_moments_of_its_draws() -> None:
    random = np.random.default_rng(2)
    parts = [ContactWrench(random.normal(size=(2, 6)), random.uniform(size=(2, 6))) for _ in "ab"]
    draws = [
        own.mean + np.sqrt(own.variance) * random.normal(size=(count, 2, 6))
        for own, count in zip(parts, (30_000, 70_000), strict=True)
    ]
    found = mixture(parts, np.array([0.3, 0.7]))
    assert found.mean == pytest.approx(np.concatenate(draws).mean(axis=0), abs=0.02)
    assert found.variance == pytest.approx(np.concatenate(draws).var(axis=0), abs=0.03)


def pushed_on(robot: Robot, link: int, force: Array) -> tuple[Samples, ContactWrench]:
    """Return samples of a push at the middle of a link, and another wrench, of the flange."""
    rotation, origin = frames_at(robot, POSTURE)
    along = place_jacobians(rotation, origin, places(rotation, origin))[link]
    J = along[len(along) // 2]
    torque = J[:, :3].mT @ force
    noise = np.broadcast_to(0.5**2 * np.eye(6), (COUNT, 6, 6))
    seen = Samples(torque, noise, rotation, origin - origin[:, -1:])
    return seen, ContactWrench(*np.ones((2, COUNT, 6)))


@pytest.mark.parametrize("link", [2, 3, 6])
def test_the_force_is_stated_where_the_arm_is_touched(ur5: Robot, link: int) -> None:
    """Before the flange, with a band that has the truth; at the flange, as it was."""
    force = np.array([20.0, 12.0, -25.0])
    seen, at_flange = pushed_on(ur5, link, force)
    found = touched(seen, at_flange, PRIOR)
    assert found is not None
    if link == 6:
        assert found.off_flange < LIKELY
        assert found.wrench is at_flange
        return
    assert found.off_flange > 0.8
    assert abs(found.link - link) <= 1
    error = np.abs(found.wrench.mean[:, :3] - force)
    assert (error <= 1.96 * np.sqrt(found.wrench.variance[:, :3])).all()


def test_nothing_is_told_of_a_contact_without_a_torque(ur5: Robot) -> None:
    seen, at_flange = pushed_on(ur5, 2, np.ones(3))
    unknown = seen._replace(torque=np.full_like(seen.torque, np.nan))
    assert touched(unknown, at_flange, PRIOR) is None


@pytest.mark.parametrize("moving", [True, False])
def test_links_are_told_in_motion_alone(ur5: Robot, moving: bool) -> None:
    """At rest, friction keeps what the wrist carries."""
    run = free_run(ur5, 3, seconds=16.0, moving=moving, scale=0.2)
    rotation, origin = link_frames(ur5, run.q)
    J = place_jacobian(rotation, origin, 3, origin[:, 2:4].mean(axis=1))
    pressed = (run.time > 6) & (run.time < 9)
    force = np.where(pressed[:, None], [60.0, -80.0, 90.0, 0.0, 0.0, 0.0], 0.0)
    problem = Problem(run.input(torque=run.torque + torque_of(J, force)), MODEL)
    used = run.jacobian[problem.rows]
    here, anywhere = (problem.solve(used, PRIOR, None, arm) for arm in (None, ur5))
    inside = (run.time > 7) & (run.time < 8)
    assert np.isfinite(anywhere.off_flange[inside]).all() == moving
    assert np.isnan(anywhere.off_flange[run.time < 4]).all()
    assert np.isnan(here.off_flange).all()
    if moving:
        assert (np.abs(anywhere.link[inside] - 3) <= 1).all()
        before, after = (
            np.linalg.norm((own.wrench - force)[inside, :3], axis=1).mean()
            for own in (here, anywhere)
        )
        assert after < before
    else:
        assert anywhere.wrench == pytest.approx(here.wrench, abs=0.0)


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
    none = Forces(
        time=run.time, segment=np.zeros(len(run.time), int), wrench={}, std={}, log_odds={}
    )
    found = judged_by_torques(ur5, shown, none, PRIOR, [contact, load])
    assert [one.off_flange for one in found] == [link != 6, False]
    assert [one.link for one in found] == [None, None]
    assert judged_by_torques(ur5, hidden, none, PRIOR, [contact]) == [contact]


def test_an_alarm_in_motion_has_the_link_that_the_force_has(ur5: Robot) -> None:
    run = free_run(ur5, 0, seconds=4.0)
    inside = np.where((run.time > 1) & (run.time < 3), 1.0, np.nan)
    stated = Forces(
        time=run.time,
        segment=np.zeros(len(run.time), int),
        wrench={},
        std={},
        log_odds={},
        link=4 * inside,
        off_flange=0.9 * inside,
    )
    contact = Alarm(0.8, 2.9, 2.0, np.zeros(3), np.ones(3), run.q[0])
    problem = Problem(run.input(), MODEL)
    (found,) = judged_by_torques(ur5, problem, stated, PRIOR, [contact])
    assert (found.link, found.off_flange_probability, found.off_flange) == (4, 0.9, True)
