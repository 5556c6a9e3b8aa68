"""The force while the arm runs: identities, pushes, faults of the stream, and the same in C++."""

import json
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from tests.conftest import PROJECT
from tests.rubbing_arm import TERMS as FRICTION_TERMS
from tests.rubbing_arm import friction, robot
from tests.topics.live.made_arm import PERIOD, arm_file, exported, hostile, push, samples
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError, RefusalError
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.missed_contacts import missed_contacts
from ur5lib.force.residual_model import USUAL_REST_STD
from ur5lib.records.measured import Measured
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.friction import JointMotion, coefficient_names, friction_columns
from ur5lib.topics.live.live import (
    CONTACT,
    FREE,
    RESTING,
    REVERSING,
    SETTLING,
    STATES,
    STILL,
    SUSPECTED,
    TERMS,
    UNKNOWN,
    UNMOVED,
    Answer,
    Live,
)
from ur5lib.topics.live.live_file import CONSTANTS, MIN_LOG_ODDS, learned, numbers
from ur5lib.topics.live.live_recording import alarms_of_each, follow

HEADER = PROJECT / "ur5lib" / "topics" / "live"
AT_REST_AND_IN_MOTION = pytest.mark.parametrize("moving", [False, True])
Sample = tuple[Any, Any, Any, Any]


@pytest.mark.parametrize("name", ["ur5", "ur10e"])
def test_one_sweep_gives_what_mass_matrices_give(name: str) -> None:
    """p = M q̇, Cᵀ q̇ - g."""
    arm = load_robot(robot_path(name)).with_rotors().mounted([1.0, -2.0, -9.5])
    estimator = Live(arm_file() | numbers(arm, friction(arm), "", None))
    model = LinkModel(arm, arm.fullest_model())
    q, qd = np.random.default_rng(0).uniform(-2, 2, (2, 100, 6))
    swept = [estimator.sweep(*state) for state in zip(q, qd, strict=True)]
    for own, expected in (
        ([one.momentum for one in swept], model.momentum(q, qd)),
        ([one.rate for one in swept], model.coriolis_torque(q, qd) - model.gravity_torque(q)),
    ):
        np.testing.assert_allclose(own, expected, rtol=0, atol=2e-14 * np.abs(expected).max())


@AT_REST_AND_IN_MOTION
def test_a_push_is_told_within_100_ms_and_stated_soon(moving: bool) -> None:
    force = np.array([20.0, -25.0, 15.0])
    run = samples(8.0, moving, push(6.0, 7.0, *force))
    found = follow(arm_file(), run)
    before, after = (found.wrench[round(t / PERIOD), :3] for t in (5.99, 6.1))
    assert (after - before) @ force > (1 - np.exp(-1)) * force @ force
    inside = slice(round(6.4 / PERIOD), round(6.9 / PERIOD))
    off = np.abs(found.wrench[inside, :3] - force)
    assert off.mean() < 2.0
    assert (off < 1.96 * found.std[inside, :3]).mean() > 0.9
    [(first, last)] = found.alarms()
    assert 6.0 < run.time[first] < 6.15
    assert 7.0 < run.time[last] < 7.2


@AT_REST_AND_IN_MOTION
@pytest.mark.parametrize("noise", [0.3, 3.0])  # of the model: the push is found, or is not
def test_a_held_push_stays_and_goes(moving: bool, noise: float) -> None:
    force = np.array([0.0, -8.0, 6.0])
    run, free = samples(15.0, moving, push(4.0, 14.0, *force)), samples(15.0, moving)
    arm = arm_file(noise)
    shown = (follow(arm, run).wrench - follow(arm, free).wrench)[:, :3] @ force / (force @ force)
    first, held, gone = (
        shown[round(a / PERIOD) : round(b / PERIOD)].mean()
        for a, b in ((4.3, 4.8), (13.5, 13.95), (14.3, 14.8))
    )
    assert held > 0.8 * first
    assert abs(gone) < 0.2 * first


def test_friction_of_the_run_is_learnt() -> None:
    run = samples(20.0, moving=True)
    arm = arm_file(1.0, slow=5.0)
    arm["friction"]["terms"]["coulomb"] = [4.0] * 6  # of 5 Nm
    error = np.abs(follow(arm, run).torque).mean(axis=1)
    assert error[-500:].mean() < 0.5 * error[150:650].mean()


def test_friction_is_unknown_until_a_joint_has_moved() -> None:
    """To which side it holds a joint that rests while others move, after each fresh start."""
    run, estimator = samples(7.0, moving=False), Live(arm_file())
    time, q = run.time, run.q[-1] + 0.0 * run.q
    for joint, start in (0, 2.0), (1, 3.0), (1, 6.0):  # each turns for 0.4 s
        q[:, joint] += np.clip(0.5 * (time - start), 0.0, 0.2)
    current = run.current[-1] + 1e-6 * time[:, None]  # no channel that stays
    stamps = time + 10.0 * (time > 5.0)
    stream = [*zip(stamps, q, np.gradient(q, PERIOD, axis=0), current, strict=True)]
    found = []
    for sample in stream:
        estimator.step(*sample)
        found.append(estimator.state)
    resting, first, second, again = (found[round(t / PERIOD)] for t in (1.5, 2.3, 3.3, 6.3))
    assert (resting >= SETTLING).all()
    assert (resting <= STILL).all()
    assert first.tolist() == [REVERSING, *[UNMOVED] * 5]
    assert second.tolist() == [RESTING, REVERSING, *[UNMOVED] * 4]
    assert again.tolist() == [UNMOVED, REVERSING, *[UNMOVED] * 4]


def test_a_joint_that_has_not_moved_is_in_as_much_doubt_as_recordings_show() -> None:
    """Its noise is that of such joints, and the usual one of rest where they are not shown."""
    arm, run = arm_file(), samples(20.0, moving=True)
    one = run._replace(q=run.q.copy(), qd=run.qd.copy())
    for values in (one.q, one.qd):
        values[:, 3:] = values[:1, 3:] * (values is one.q)
    known = [learned([(arm, run), *own], 5, 1.0)["noise"]["std"] for own in ([], [(arm, one)])]
    usual, shown = (np.array(own["unmoved"]) for own in known)
    assert (usual > 0.9 * USUAL_REST_STD * np.array(arm["breakaway"])).all()
    np.testing.assert_allclose(shown[:3], usual[:3], rtol=0.1)
    assert (shown[3:] > 1.2 * usual[3:]).all()  # torques of a motion that the joints do not make


def fed(estimator: Live, stream: Iterable[Sample]) -> list[Answer]:
    """Return the answers to a stream."""
    return [estimator.step(*sample) for sample in stream]


def stream_of(run: Measured) -> list[Sample]:
    """Return a recording as samples."""
    velocities = [None] * len(run.time) if run.qd is None else run.qd
    return [*zip(run.time, run.q, velocities, run.current, strict=True)]


def damaged(run: Measured) -> Measured:
    """Return a recording with missing values, gaps, a turn that no joint makes, a repeated time."""
    random, count = np.random.default_rng(0), len(run.time)
    time, q = run.time.copy(), run.q.copy()
    q[random.random(q.shape) < 0.002] = np.nan
    q[count // 4 : count // 4 + 20] = np.nan
    q[count // 3 :, 1] += 1.0
    time[count // 2 :] += 3.0
    time[-50] = time[-51]
    return run._replace(time=time, q=q)


def attacked(run: Measured) -> Measured:
    """Return a hostile stream of a recording as one."""
    time, q, qd, current = map(np.array, zip(*hostile(run, 0), strict=True))
    return run._replace(time=time, q=q, qd=qd, current=current)


@AT_REST_AND_IN_MOTION
@pytest.mark.parametrize(
    ("change", "stated"),
    [
        (lambda run: run, {CONTACT, FREE, UNKNOWN}),
        (lambda run: run._replace(qd=None), {CONTACT, FREE, UNKNOWN}),
        (damaged, {CONTACT, FREE, UNKNOWN}),
        (attacked, {UNKNOWN}),
    ],
)
def test_a_recording_is_followed_as_sample_by_sample(
    moving: bool, change: Any, stated: set[str]
) -> None:
    """In blocks, whatever ends a run, and whether slow errors are learnt from or not."""
    run = change(samples(8.0, moving, push(4.0, 5.0, 20.0, -25.0, 15.0)))
    for arm in (arm_file(), arm_file(1.0, slow=5.0)):
        found, estimator = follow(arm, run, limited=True), Live(arm)
        answers = fed(estimator, stream_of(run))
        for own, expected in (
            *(
                (getattr(found, name), [getattr(one, name) for one in answers])
                for name in Answer._fields
                if name != "contact"
            ),
            (found.torque[-1], estimator.torque),
            (found.evidence[-1], estimator.evidence),
        ):
            np.testing.assert_allclose(own, expected, rtol=0, atol=1e-9)
        contact = np.where(found.contact, CONTACT, np.where(found.known, FREE, UNKNOWN))
        words = [FREE if one.contact == SUSPECTED else one.contact for one in answers]
        assert contact.tolist() == words
        assert {*contact} >= stated


@AT_REST_AND_IN_MOTION
def test_recordings_side_by_side_are_followed_as_each_alone(moving: bool) -> None:
    """Whenever each is pushed, also by a current that no motor of the arm has."""
    starts = 3.0, 5.0, 5.5
    runs = [samples(8.0, moving, push(at, at + 0.5, 20.0, -25.0, 15.0)) for at in starts]
    currents = np.stack([run.current for run in runs])
    currents[1, 400:402] = 1e3
    alone = [follow(arm_file(), runs[0]._replace(current=current)).alarms() for current in currents]
    assert alarms_of_each(arm_file(), runs[0], currents) == alone
    assert all(alone)


def test_nothing_is_learnt_from_rare_samples() -> None:
    run = samples(20.0, True)
    with pytest.raises(RefusalError, match="rare samples live"):
        learned([(arm_file(), run._replace(period=0.1))], 5, 1.0)


def assert_same(one: Answer, other: Answer) -> None:
    np.testing.assert_array_equal(one.wrench, other.wrench)
    np.testing.assert_array_equal(one.std, other.std)
    assert one.contact == other.contact


def test_each_fault_of_the_stream_has_its_answer() -> None:
    stream, estimator = stream_of(samples(3.0, moving=True)), Live(arm_file())
    answer = fed(estimator, stream)[-1]
    assert answer.contact == FREE
    time, q, qd, current = stream[-1]
    lost = np.full(6, np.nan)
    # repeated, late, or not a number: the last answer
    for one in (
        stream[-1],
        stream[-3],
        (time + 1e-15, q, qd, current + 0.01),
        (np.nextafter(time, np.inf), q, None, current + 0.01),
        (time + PERIOD, q, lost, current),
        (np.nan, q, qd, current),
    ):
        assert_same(estimator.step(*one), answer)
    # the next is as if nothing had been
    later = Live(arm_file())
    fed(later, stream)
    following = time + PERIOD, q + PERIOD * qd, qd, current + 0.02
    assert np.array_equal(estimator.step(*following).wrench, later.step(*following).wrench)
    # none for long, a clock that jumps either way: a fresh start, in which nothing is known
    assert fed(estimator, [(time + 0.02, q, lost, current)] * 20)[-1].contact == UNKNOWN
    for jump in (30.0, -30.0):
        fed(estimator, stream)
        assert estimator.step(time + jump, q + 1e-6, qd, current + 0.02).contact == UNKNOWN
    # what is no sample at all
    for wrong in ((time, q[:3], qd, current), (time, "text", qd, current), (None, q, qd, current)):
        estimator.step(*wrong)


def test_a_step_too_short_for_a_double_s_inverse_changes_nothing() -> None:
    """1e-310 s after a first sample at 0, of which the rate of change would be infinite."""
    _, q, qd, current = stream_of(samples(0.1, moving=True))[0]
    for qd_stated in (qd, None):
        estimator = Live(arm_file())
        first = estimator.step(0.0, q, qd_stated, current)
        assert_same(estimator.step(1e-310, q + 1e-6, qd_stated, current + 0.01), first)
        answer = estimator.step(PERIOD, q + PERIOD * qd, qd_stated, current)
        assert np.isfinite([*answer.wrench, *answer.std]).all()


def test_numpy_may_be_set_to_raise() -> None:
    """Of a friction whose direction before a sample counts e^-1000."""
    arm = arm_file()
    arm["friction"]["presliding"][0]["distance"] = 1e-6
    with np.errstate(all="raise"):
        fed(Live(arm), stream_of(samples(0.1, moving=True)))


@pytest.mark.parametrize("frozen", ["q", "current"])
def test_nothing_is_known_of_a_moving_arm_whose_channel_stays(frozen: str) -> None:
    run = samples(5.0, moving=True)
    values = getattr(run, frozen).copy()
    stays = run.time >= 3.0
    values[stays] = values[np.argmax(stays)]
    found = follow(arm_file(), run._replace(**{frozen: values}))
    assert found.known[(run.time > 1.5) & (run.time < 3.0)].all()
    assert not found.known[run.time > 3.0 + 0.11].any()


@pytest.mark.parametrize(("pull", "alarms"), [(0.0, 1), (2.0, 0)])
def test_encoders_of_a_resting_arm_feel_a_touch(pull: float, alarms: int) -> None:
    """Until joints stay; a joint that its motor pulls that way creeps."""
    run, arm = samples(10.0, moving=False), arm_file(noise=30.0)
    touched = run.time >= 6.0
    q, current = run.q.copy(), run.current.copy()
    q[touched, 1] += 3e-4
    torque = pull * arm["breakaway"][1] * (run.time > 4.5)
    current[:, 1] += torque / arm["torque_constant"][1]
    found = follow(arm, run._replace(q=q, current=current))
    assert len(found.alarms()) == alarms
    for first, last in found.alarms():
        assert 6.05 < run.time[first] < 6.2
        assert run.time[last] < 6.7


def test_the_wrench_of_a_suspected_contact_is_stated_within_50_ms() -> None:
    """63 % of a push, before the contact is sure."""
    force = np.array([20.0, -25.0, 15.0])
    answers = fed(Live(arm_file()), stream_of(samples(7.0, False, push(6.0, 7.0, *force))))
    words = [one.contact for one in answers]
    first = round(6.0 / PERIOD)
    assert words[first - 1] == FREE
    shown = [
        (one.wrench[:3] - answers[first - 1].wrench[:3]) @ force / (force @ force)
        for one in answers[first : words.index(CONTACT)]
    ]
    assert int(np.argmax(np.array(shown) > 1 - np.exp(-1))) + 1 <= 0.05 / PERIOD
    assert max(shown) > 1 - np.exp(-1)


def test_a_large_force_without_evidence_of_a_contact_is_not_stated() -> None:
    arm = arm_file(freeze=1e3, duration=1e2, stopping=1e2)
    answers = fed(Live(arm), stream_of(samples(7.0, False, push(6.0, 7.0, 40.0, 0.0, 0.0))))
    words = [one.contact for one in answers]
    first = words.index(SUSPECTED)
    assert words[first - 1] == FREE
    for one in answers[first:]:
        assert one.contact == SUSPECTED
        np.testing.assert_array_equal(one.wrench, answers[first - 1].wrench)


@pytest.mark.parametrize(("release", "alarms"), [(1e-9, 2), (CONSTANTS["release"], 1)])
def test_a_contact_whose_evidence_fails_for_a_moment_is_one(release: float, alarms: int) -> None:
    first, second = push(5.0, 5.5, 40.0, 0.0, 0.0), push(5.6, 6.0, 40.0, 0.0, 0.0)
    run = samples(7.0, False, lambda time: first(time) + second(time))
    assert len(follow(arm_file(gain=100.0, release=release), run).alarms()) == alarms


@pytest.mark.parametrize(("start", "alarms"), [(1.8, 0), (4.0, 1)])
def test_what_passes_while_joints_stop_is_suspected_alone(start: float, alarms: int) -> None:
    """Evidence of less than 0.1 s; of a resting arm, it is a contact. Joints stop in 1.5 to 2 s."""
    run = samples(5.0, False, push(start, start + 0.05, 0.0, 25.0, 0.0))
    found = follow(arm_file(), run)
    assert len(found.alarms()) == alarms
    pushed = (run.time > start) & (run.time < start + 0.2)
    assert found.evidence[pushed].max() > 10.0 + arm_file()["threshold"]["log_odds"]


@AT_REST_AND_IN_MOTION
def test_what_could_be_hidden_is_as_of_the_whole_recording(moving: bool) -> None:
    """A missed contact's size along an axis, as `missed_contacts` has it; in contact, none."""
    arm, stream = arm_file(3.0), stream_of(samples(8.0, moving, push(7.0, 8.0, 90.0, 0.0, 0.0)))
    arm["noise"]["hidden"] = {state: [4.0] * 6 for state in STATES}
    estimator, force = Live(arm), arm["contacts"]["typical"]
    answers = fed(estimator, stream[: round(6.0 / PERIOD)])
    own = answers[-1]
    assert own.contact == FREE
    jacobian = estimator.sweep(estimator.q, estimator.qd).jacobian
    hiding = np.full((1, 6), (CONSTANTS["missed"] * 1.1 * (3.0 if moving else 5.0)) ** 2)
    prior = ContactPrior(force, arm["contacts"]["lever"])
    [missed] = missed_contacts(jacobian[None], hiding, prior)[1]
    assert (own.hidden >= 2.576 * np.sqrt(missed[:3]) - 1e-9).all()
    assert (own.hidden <= 2.576 * np.sqrt(missed[:3]) + moving * 1e-9 + (not moving) * 10.0).all()
    assert (own.hidden_at_all >= own.hidden - moving * 1e-9 - (not moving) * 10.0).all()
    touched = fed(estimator, stream[round(6.0 / PERIOD) :])[-1]
    assert touched.contact == CONTACT
    assert not touched.hidden.any()
    np.testing.assert_allclose(touched.untouched, 1.96 * touched.std[:3])


def test_a_push_that_lasts_since_before_the_rest_could_be_hidden_at_all() -> None:
    """The background at rest takes it up; one that begins later changes it."""
    force = 30.0
    run = samples(8.0, False, push(1.2, 9.0, 0.0, 0.0, force))
    found = follow(arm_file(3.0, freeze=1e3, duration=1e2, stopping=1e2), run, limited=True)
    assert found.hidden_at_all[-1, 2] > force
    assert found.hidden_at_all[-1, 2] > found.hidden[-1, 2] + 10.0
    # while nothing is known, everything could be hidden
    sizes = arm_file()["contacts"]["sizes"]
    np.testing.assert_allclose(found.hidden[~found.known], 2.576 * max(sizes))


def test_what_a_caller_does_to_an_answer_stays_with_the_caller() -> None:
    run = samples(0.4, True)
    own, changed = Live(arm_file()), Live(arm_file())
    for time, *state in zip(run.time, run.q, run.qd, run.current, strict=True):
        bad = [state[0], state[1], state[2] * np.nan]
        for one in (state, bad):  # after the second, the answer is the last one
            told, spoilt = (each.step(float(time), *one) for each in (own, changed))
            np.testing.assert_array_equal(spoilt.wrench, told.wrench)
            np.testing.assert_array_equal(spoilt.std, told.std)
            spoilt.wrench[:], spoilt.std[:] = 1e6, -1.0


def test_a_resting_arm_that_feels_no_large_push_is_no_free_one() -> None:
    run = samples(5.0, moving=False)
    assert follow(arm_file(), run).known[-1]
    assert not follow(arm_file(noise=100.0, freeze=5.0), run).known[-1]


def test_a_speed_that_was_never_seen_widens_the_band() -> None:
    run = samples(4.0, moving=True)
    arm, slower = arm_file(), arm_file() | {"speed": [0.12] * 6}
    usual, unseen = follow(arm, run), follow(slower, run)
    fast = (np.abs(run.qd) > CONSTANTS["faster"] * 0.12).any(axis=1) & (run.time > 1.5)
    assert not unseen.known[fast].any()
    assert (unseen.std[fast] >= usual.std[fast] - 1e-9).all()
    assert unseen.std[fast, :3].mean() > 1.2 * usual.std[fast, :3].mean()


def test_velocities_may_be_missing() -> None:
    run = samples(6.0, True, push(4.0, 5.0, 30.0, 0.0, 0.0))
    found = follow(arm_file(1.0), run._replace(qd=None))
    middle = slice(round(4.4 / PERIOD), round(4.9 / PERIOD))
    assert found.wrench[middle, 0].mean() == pytest.approx(30.0, abs=5.0)


def streams(count: int, first: int = 0) -> list[list[Sample]]:
    """Return hostile streams of 4 s."""
    run = samples(4.0, True, push(2.0, 3.0, 0.0, 30.0, 0.0))
    return [hostile(run, first + seed) for seed in range(count)]


def check_hostile(count: int) -> None:
    """No exception, nothing but numbers, and nothing known after a fresh start."""
    estimator = Live(arm_file())
    for stream in streams(count):
        for sample in stream:
            answer = estimator.step(*sample)
            assert np.isfinite([*answer.wrench, *answer.std]).all()
            assert answer.contact == UNKNOWN or estimator.run >= estimator.set["settle"]


class Raises:
    """What raises an error of its own where it is to be numbers."""

    def __array__(self, *_: object, **__: object) -> None:
        raise LookupError

    __float__ = __len__ = __array__


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize(
    "wrong",
    [
        torch.ones(6, requires_grad=True),
        [torch.ones((), requires_grad=True)] * 6,
        [1j] * 6,
        np.full(6, 0.1 + 0j),
        np.array([np.complex64(0.1)] * 6, object),
        np.complex64(0.1),
        Raises(),
        [Raises()] * 6,
        {},
    ],
)
def test_what_is_no_number_never_raises_and_is_not_taken(wrong: Any, place: int) -> None:
    """As time, q, q̇ or current."""
    estimator = Live(arm_file())
    for sample in stream_of(samples(1.0, True)):
        estimator.step(*sample)
    before, passed = estimator.answer, estimator.time
    after = [*sample]
    after[0] = float(sample[0]) + PERIOD
    after[place] = wrong
    answer = estimator.step(*after)
    assert (estimator.time, estimator.missed) == (passed, 1)
    np.testing.assert_array_equal(answer.wrench, before.wrench)


def test_hostile_streams_have_answers() -> None:
    check_hostile(5)


@pytest.mark.thorough
def test_a_thousand_hostile_streams_have_answers() -> None:
    check_hostile(1000)


def test_noise_is_learnt_and_alarms_are_few() -> None:
    run, arm = samples(20.0, True), arm_file()
    known = learned([(arm, run)], 5, 1.0)
    assert known["threshold"]["log_odds"] >= MIN_LOG_ODDS
    assert not follow({**arm, **known}, run).alarms()
    assert (np.array(known["noise"]["std"]["moving"]) < 0.5).all()


def test_friction_that_is_not_the_joint_s_own_is_refused() -> None:
    arm = robot()
    known = friction(arm)
    joints = [replace(joint, terms=("load", "coupled")) for joint in known.fit.joints]
    known = replace(known, fit=replace(known.fit, joints=tuple(joints)))
    with pytest.raises(InputError, match="coupled"):
        numbers(arm, known, "", None)


def test_friction_is_that_of_the_study() -> None:
    """Of all its terms but the load's, with the same direction of dry friction."""
    terms = ("coulomb", "viscous", "load", "velocity_root", "velocity_square", "velocity_stribeck")
    random = np.random.default_rng(4)
    values = random.normal(size=len(coefficient_names(terms)))
    values[terms.index("load")] = 0.0
    known = friction(robot())
    joint = known.fit.joints[0]
    estimate = replace(joint.estimate, coefficients=np.array([1.0, 0.0, *values]))
    joint = replace(joint, terms=terms, held=np.zeros(1), estimate=estimate)
    fit = replace(known.fit, joints=(joint,) * 6)
    live = Live({**arm_file(), **numbers(robot(), replace(known, fit=fit), "", None)})
    qd = np.append(random.normal(size=(20, 6)), 0.02 * random.normal(size=(20, 6)), axis=0)
    z = np.tanh(qd / 0.01)
    _, stated = live.gears(0 * qd, qd, 0 * qd, z[:, None])
    for k in range(6):
        motion = JointMotion(0 * qd[:, k], qd[:, k], 0 * qd[:, k], z[:, k])
        assert stated[:, k] == pytest.approx(friction_columns(motion, terms) @ values)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The header, compiled."""
    if (compiler := shutil.which("g++")) is None:
        pytest.skip("no g++ is installed, so the header is not compared with the reference")
    built = tmp_path_factory.mktemp("live") / "live_samples"
    flags = ["-std=c++17", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-mismatched-new-delete"]
    source = str(PROJECT / "benchmarks" / "harness" / "live_samples.cpp")
    subprocess.run([compiler, *flags, f"-I{HEADER}", source, "-o", str(built)], check=True)
    return built


def written(values: Any) -> list[str]:
    """Return numbers with all their digits."""
    return [repr(float(value)) for value in values]


def in_cpp(program: Path, arm: dict[str, Any], stream: list[Sample], folder: Path) -> Any:
    """Return the header's answers (N, 21 + 2 n + 4) to a stream, and what it says of its step."""
    (folder / "arm.json").write_text(json.dumps(arm))
    lines = [
        " ".join(
            [
                repr(float(t)),
                *written(q),
                *(["none"] * 6 if qd is None else written(qd)),
                *written(i),
            ]
        )
        for t, q, qd, i in stream
    ]
    done = subprocess.run(
        [program, folder / "arm.json"],
        input="\n".join(lines),
        capture_output=True,
        text=True,
        check=True,
    )
    return np.loadtxt(done.stdout.splitlines()), done.stderr


def test_the_header_is_the_reference(program: Path, tmp_path: Path) -> None:
    arm = arm_file()
    arm["friction"]["presliding"] = [
        {"distance": 1e-4, "share": 0.6, "held": [-0.5] * 6},
        {"distance": 0.02, "share": 0.4, "held": [0.3] * 6},
    ]
    arm["contacts"] |= {"place": [0.02, -0.03, 0.12], "lever": 0.05}
    arm["smallest_pushes"] = [{"motion": "slow", "value": None, "blind": 3}]  # no input
    runs = [samples(8.0, moving, push(5.0, 6.0, 20.0, 0.0, 5.0)) for moving in (False, True)]
    runs.append(samples(8.0, True, push(4.0, 6.0, 0.0, 30.0, 40.0), link=3))
    for stream in (*map(stream_of, runs), *streams(3)):
        check_header(program, arm, stream, tmp_path)


def test_the_header_learns_from_rests_and_motions_as_the_reference(
    program: Path, tmp_path: Path
) -> None:
    """Of an arm whose slow errors are learnt from for seconds, before it is pushed."""
    arm, pushed = arm_file(1.0, slow=5.0), push(7.0, 8.0, 0.0, 30.0, 10.0)
    for moving in (False, True):
        check_header(program, arm, stream_of(samples(9.0, moving, pushed)), tmp_path)


def test_the_header_takes_velocities_from_positions_as_the_reference_does(
    program: Path, tmp_path: Path
) -> None:
    """Of a motion at an uneven rate, and of a hostile stream."""
    run = samples(4.0, True, push(2.0, 3.0, 0.0, 30.0, 0.0))
    rows = np.sort(np.random.default_rng(0).permutation(len(run.time))[: len(run.time) * 2 // 3])
    for stream in stream_of(run.at(rows)), *streams(1):
        check_header(program, arm_file(), [(t, q, None, i) for t, q, _, i in stream], tmp_path)


def test_what_a_fit_finds_of_rotors_adds_to_the_momentum() -> None:
    """By r q̇ of each joint."""
    arm = robot()
    known, found = friction(arm), [0.3, -0.2, 0.1, 0.05, 0.02, 0.01]  # Nm s²/rad
    joints = []
    for joint, rotor in zip(known.fit.joints, found, strict=True):
        own = joint.estimate.coefficients
        estimate = replace(joint.estimate, coefficients=np.append(own, rotor * own[0]))
        joints.append(replace(joint, terms=(*joint.terms, "rotor"), estimate=estimate))
    turned = replace(known, fit=replace(known.fit, joints=tuple(joints)))
    q, qd = np.random.default_rng(0).uniform(-2, 2, (2, 6))
    without, with_rotors = (
        Live(arm_file() | numbers(arm, own, "", None)).sweep(q, qd).momentum
        for own in (known, turned)
    )
    np.testing.assert_allclose(with_rotors - without, found * qd, rtol=0, atol=1e-12)


def check_header(
    program: Path, arm: dict[str, Any], stream: list[Sample], folder: Path
) -> tuple[set[int], set[str]]:
    """The header answers as the reference does, and allocates nothing.

    Returns the states and the contacts that occurred.
    """
    arm = exported(**arm) if "input" not in arm else arm
    found, said = in_cpp(program, arm, stream, folder)
    reference = Live(arm)
    rows, states, words = [], [], []
    for sample in stream:
        answer = reference.step(*sample)
        arrays = (own for own in answer if isinstance(own, np.ndarray))
        located = reference.evidence, answer.link, answer.off_flange
        rows.append([*np.concatenate([*arrays, reference.torque]), *located])
        states.append(reference.state)
        words.append(answer.contact)
    own = np.delete(found, [*range(22, 34, 2), 33], axis=1)
    np.testing.assert_allclose(own, rows, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(found[:, 22:33:2], states)
    names = (FREE, SUSPECTED, CONTACT, UNKNOWN)
    assert [names[int(code)] for code in found[:, 33]] == words
    assert said.startswith("0 allocations")
    assert said.endswith(f"reason: {reference.reason}\n")
    return {*np.ravel(states).tolist()}, {*words}


def of_its_own(value: Any, random: np.random.Generator) -> Any:
    """Return a part of a file, each number by up to a tenth another."""
    if isinstance(value, dict):
        return {key: of_its_own(part, random) for key, part in value.items()}
    if isinstance(value, list):
        return [of_its_own(part, random) for part in value]
    return value * random.uniform(0.9, 1.1) if isinstance(value, float) else value


def uneven_arm(noise: float, **constants: float) -> dict[str, Any]:
    """Return an arm with all terms of friction, and no two numbers alike."""
    random = np.random.default_rng(4)  # reaches all states
    quick = {"settle": 0.4, "thaw": 0.1, "slow": 2.0, "stays": 0.2, "reversal": 0.2}
    arm = arm_file(noise, **{"quiet": [0.5], "freeze": 1.0} | quick | constants)
    arm["friction"]["terms"] |= {name: [0.15] * 6 for name in TERMS if name not in FRICTION_TERMS}
    arm["friction"]["presliding"] = [
        {"distance": 1e-4, "share": 0.6, "held": [-0.5] * 6},
        {"distance": 0.02, "share": 0.3, "held": [0.3] * 6},
    ]
    arm["noise"] |= {
        "hidden": {state: [0.5] * 6 for state in STATES},
        "absorbed": {state: [2.0] * 6 for state in STATES},
    }
    arm["noise"]["std"] = {s: [noise * (1 + k / 8)] * 6 for k, s in enumerate(STATES)}
    arm["contacts"] |= {"place": [0.02, -0.03, 0.12], "lever": 0.05}
    arm["speed"] = [0.45] * 6  # of which samples are faster
    return dict(of_its_own(arm, random))


def through_all_states() -> list[Sample]:
    """A motion, a rest in which it is pushed and touched, one joint's turn, and a gap in each."""
    run = samples(7.0, False, push(3.2, 3.8, 25.0, -30.0, 20.0))
    time, q = run.time, run.q.copy()
    q[time >= 4.6, 1] += 4e-4
    for start, joint in ((5.4, 0), (5.7, 3)):
        q[:, joint] += np.clip(0.4 * (time - start), 0.0, 0.1)
    qd = np.gradient(q, PERIOD, axis=0)
    qd[(time > 4.5) & (time < 4.7)] = 0.0  # a touch is felt by positions alone
    stamps = time + 10.0 * (time > 6.2)
    return [*zip(stamps, q, qd, run.current, strict=True)]


@pytest.mark.parametrize(
    ("noise", "constants", "expected"),
    [
        (0.3, {}, {FREE, SUSPECTED, CONTACT, UNKNOWN}),
        (40.0, {}, {FREE, UNKNOWN}),  # which hides all pushes at rest
        (
            0.3,
            {"freeze": 1e3, "duration": 1e2, "stopping": 1e2},
            {FREE, SUSPECTED},
        ),  # by the force's size alone
    ],
)
def test_the_header_is_the_reference_whatever_an_arm_s_numbers(
    program: Path, tmp_path: Path, noise: float, constants: dict[str, float], expected: set[str]
) -> None:
    """Each joint, state and axis has a number of its own, and none is zero."""
    arm = uneven_arm(noise, **constants)
    states, words = check_header(program, arm, through_all_states(), tmp_path)
    assert states == {*range(len(STATES))}
    assert words >= expected


@pytest.mark.thorough
def test_the_header_is_the_reference_on_a_thousand_hostile_streams(
    program: Path, tmp_path: Path
) -> None:
    for first in range(0, 1000, 50):
        stream = [sample for one in streams(50, first) for sample in one]
        check_header(program, arm_file(), stream, tmp_path)
