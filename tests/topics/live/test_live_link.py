"""Which link is touched while the arm runs: contacts before the flange, without a wrench at it."""

import numpy as np
import pytest

from tests.rubbing_arm import robot
from tests.topics.live.made_arm import PERIOD, arm_file, push, samples
from tests.topics.live.test_live import fed, stream_of
from ur5lib.force.touched_link import (
    GEAR_LOSS_STD,
    LAST_LINK_SHARE,
    PLACE_SPACING,
    SIZES,
    SURFACE_DISTANCE,
    TOOL_LENGTH,
    off_flange,
    place_jacobians,
    place_probabilities,
    places,
)
from ur5lib.robots.statics import link_frames
from ur5lib.topics.live.live import (
    AT_FLANGE,
    CONTACT,
    LIKELY,
    LOST,
    PLACE_SIZES,
    SPACING,
    SURFACE,
    TOOL,
    Live,
)
from ur5lib.topics.live.live_recording import follow


def test_a_contact_before_the_flange_names_its_link_and_no_wrench() -> None:
    """In blocks as sample by sample; a file without its log-odds states none."""
    run = samples(8.0, True, push(4.0, 6.0, 0.0, 30.0, 40.0), link=3)
    arm, inside = arm_file(1.0), slice(round(4.6 / PERIOD), round(5.9 / PERIOD))
    found, estimator = follow(arm, run, limited=True), Live(arm)
    answers = fed(estimator, stream_of(run))
    assert found.contact[inside].all()
    assert {*found.link[inside].tolist()} <= {2, 3, 4}
    assert (found.off_flange[inside] >= LIKELY).all()
    assert not found.wrench[inside, :3].any()
    assert len(found.alarms()) == 1
    for name in ("wrench", "std", "untouched", "hidden", "link", "off_flange"):
        own, expected = getattr(found, name), [getattr(one, name) for one in answers]
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-9)
    assert found.contact.tolist() == [one.contact == CONTACT for one in answers]
    assert found.before_flange[-1] == pytest.approx(estimator.before_flange)
    del arm["threshold"]["before_flange"]
    assert not np.isfinite(Live(arm).threshold_before)
    assert (follow(arm, run, limited=True).contact <= found.contact).all()


def test_a_contact_at_the_flange_keeps_its_wrench() -> None:
    run = samples(8.0, True, push(4.0, 6.0, 0.0, 30.0, 40.0))
    found = follow(arm_file(1.0), run, limited=True)
    [(first, last)] = found.alarms()
    settled = slice(first + round(0.3 / PERIOD), last)
    assert (found.link[settled] == 6).all()
    assert (found.off_flange[settled] < LIKELY).all()


def test_links_are_compared_as_after_a_recording() -> None:
    """By the same places, sizes and probabilities."""
    assert (SPACING, TOOL, SURFACE) == (PLACE_SPACING, TOOL_LENGTH, SURFACE_DISTANCE)
    assert (LOST, AT_FLANGE, PLACE_SIZES) == (GEAR_LOSS_STD, LAST_LINK_SHARE, SIZES)
    run, estimator = samples(1.0, True), Live(arm_file(1.0))
    torque, noise = np.random.default_rng(0).normal(0.0, 5.0, (len(run.time), 6)), np.full(6, 2.0)
    swept = estimator.sweep(run.q, run.qd)
    density = estimator.at_places(torque, noise + 0 * torque, swept).mean(axis=0)
    poses = link_frames(robot(), run.q)
    levers = place_jacobians(*poses, places(*poses))
    sizes = [share * estimator.set["typical"] for share in PLACE_SIZES]
    expected = place_probabilities(torque, levers, np.diag(noise) + 0 * noise, sizes)
    assert estimator.touched_link(density)[1] == pytest.approx(off_flange(expected))
