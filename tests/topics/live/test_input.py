"""What is given as effort: taken where it fits the arm, else refused with the reason."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.rubbing_arm import robot
from tests.topics.live.made_arm import PERIOD, arm_file, efforts_of, exported, push, samples
from tests.topics.live.test_live import check_header, fed, program, stream_of
from ur5lib.records.measured import Measured
from ur5lib.topics.live.arm_file import with_input
from ur5lib.topics.live.live import KINDS, LONGEST_MOTION, UNKNOWN, Live

__all__ = ["program"]  # a fixture
PAIRS = [(own, given) for own in KINDS for given in KINDS]


def given(run: Measured, kind: str) -> Measured:
    return run._replace(current=efforts_of(run, kind))


@pytest.mark.parametrize(("own", "kind"), PAIRS)
def test_efforts_fit_or_are_refused_within_two_seconds_of_motion(own: str, kind: str) -> None:
    """While the arm is pushed, too."""
    run = samples(6.0, True, push(3.0, 4.0, 20.0, 0.0, 10.0))
    right, arm = Live(exported()), Live(exported(own))
    for number, (sample, usual) in enumerate(
        zip(stream_of(given(run, kind)), stream_of(run), strict=True)
    ):
        answer, expected = arm.step(*sample), right.step(*usual)
        if own == kind:
            np.testing.assert_allclose(answer.wrench, expected.wrench, rtol=0, atol=1e-8)
            assert answer.contact == expected.contact
        elif number * PERIOD > LONGEST_MOTION:
            assert answer.contact == UNKNOWN
            assert not answer.wrench.any()
    assert bool(arm.reason) == (own != kind)
    assert (KINDS[kind] in arm.reason) == (own != kind)


@pytest.mark.parametrize(("own", "kind"), PAIRS)
def test_the_header_refuses_as_the_reference_does(
    own: str, kind: str, program: Path, tmp_path: Path
) -> None:
    run = given(samples(3.0, True), kind)
    check_header(program, exported(own), stream_of(run), tmp_path)


def test_a_refusal_stays_while_no_sample_can_be_used(program: Path, tmp_path: Path) -> None:
    """After a gap, with currents that no arm has; for long, without velocities."""
    run = samples(3.0, True)
    beyond, lost = (
        stream_of(given(own, kind))
        for own, kind in ((run, "torque"), (run._replace(qd=None), "torque_less_gravity"))
    )
    time, q, qd, current = beyond[-1]
    beyond += [(time + 10.0, q, qd, current + 1e3)]
    lost += [(time + PERIOD, q * np.nan, None, current)] * 20
    for own, stream in (("current", beyond), ("torque", lost)):
        arm = Live(exported(own))
        fed(arm, stream)
        assert "are expected" in arm.reason
        check_header(program, exported(own), stream, tmp_path)


def test_a_resting_arm_tells_nothing_of_its_efforts() -> None:
    """As no second of motion does; a motion then does."""
    run = given(samples(8.0, False), "torque")
    arm = Live(exported())
    for sample in stream_of(run)[round(2.1 / PERIOD) :]:
        arm.step(*sample)
    assert "expected" not in arm.reason
    for sample in stream_of(given(samples(4.0, True), "torque")):
        arm.step(*sample)
    assert "currents [A] are expected; let the driver publish currents" in arm.reason


def test_a_driver_that_changes_its_efforts_is_taken_after_a_gap() -> None:
    """A restart of the driver takes longer than a run's longest gap."""
    run, arm = samples(4.0, True), Live(exported())
    for sample in stream_of(given(run, "torque")):
        arm.step(*sample)
    assert arm.reason
    for time, *sample in stream_of(run):
        arm.step(time + 10.0, *sample)
    assert not arm.reason


@pytest.mark.parametrize(
    ("own", "kind", "words"),
    [
        ("current", "torque", "torques [Nm], but currents [A] are expected; let the driver"),
        ("torque", "current", "let the driver publish torques"),
        ("torque", "effort", "unknown input 'effort'; available: auto, current, torque"),
    ],
)
def test_an_input_of_another_unit_is_refused_at_once(own: str, kind: str, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        Live(exported(own), kind)


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_has_the_unit_of_the_recordings(kind: str) -> None:
    """Torques of a UR are divided by its documented constants before a study is fitted."""
    run, arm = samples(3.0, True), robot()
    documented = np.array(arm.maker_torque_constants())
    known, right = Live(with_input(arm_file(), arm, kind)), Live(arm_file())
    gravity = right.sweep(run.q, 0 * run.q).gravity
    efforts = run.current if kind == "current" else documented * run.current
    efforts = efforts - gravity if kind == "torque_less_gravity" else efforts
    for one, other in zip(stream_of(run._replace(current=efforts)), stream_of(run), strict=True):
        answer, expected = known.step(*one), right.step(*other)
        np.testing.assert_allclose(answer.wrench, expected.wrench, rtol=0, atol=1e-8)
    assert known.input == kind


def test_an_arm_that_was_identified_by_torques_takes_them_less_gravity() -> None:
    run = samples(4.0, True)
    whole, less = Live(exported("torque")), Live(exported("torque"), "torque_less_gravity")
    for one, other in zip(
        *(stream_of(given(run, kind)) for kind in ("torque", "torque_less_gravity")), strict=True
    ):
        np.testing.assert_allclose(
            whole.step(*one).wrench, less.step(*other).wrench, rtol=0, atol=1e-8
        )
