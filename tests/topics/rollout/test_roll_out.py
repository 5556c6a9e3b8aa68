"""Simulated arms beside recordings whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_records import motion_of, signals_of
from tests.made_tables import record
from tests.rubbing_arm import friction, robot
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.current_samples import motion_samples
from ur5lib.identification.currents import predict
from ur5lib.records.friction import Friction, KnownConstants, LeftOut
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.topics.rollout.models import (
    DESCRIBED,
    FRICTIONLESS,
    IDENTIFIED,
    STILL,
    Constants,
    contenders,
    with_described,
)
from ur5lib.topics.rollout.roll_out import Inputs, is_unseen, roll_out
from ur5lib.topics.rollout.rows import RolledOut

PERIOD, SECONDS = 0.004, 24.0  # s
LOAD = Payload(mass=1.0, center_of_mass=(0.0, 0.0, 0.05))
SLOPE = [1.0, -2.0, -9.5]  # m/s²


def known() -> Friction:
    """The true friction, which does not differ at rest, fitted to another recording."""
    own = friction(robot())
    joints = tuple(replace(joint, held=0 * joint.held) for joint in own.fit.joints)
    return replace(own, fit=replace(own.fit, joints=joints))


def recorded(
    arm: Robot, noise: float = 0.0, seed: int = 0, copied: bool = False, **premises: object
) -> Inputs:
    """An arm with a load that swings, and the currents that this takes by the fit."""
    random = np.random.default_rng(7)
    time = PERIOD * np.arange(round(SECONDS / PERIOD))
    rate, phase, middle = (random.uniform(*ends, 6) for ends in ((1, 3), (0, 6), (-1, 1)))
    angle = rate * time[:, None] + phase
    q, qd = middle + 0.5 * np.sin(angle), 0.5 * rate * np.cos(angle)
    motion = motion_of(time, q, qd, -(rate**2) * (q - middle))
    torque = LinkModel(arm.carrying(LOAD).mounted(SLOPE), arm.fullest_model())
    samples = motion_samples("", motion, arm, torque.inverse_dynamics(q, qd, motion.qdd))
    current = predict(known().fit, samples)
    current = current + noise * np.random.default_rng(seed).normal(size=current.shape)
    about = {"load": {"payload": LOAD.model_dump()}, "contradictions": {}, **premises}
    return Inputs(
        signals=signals_of(time, q, actual_current=current),
        motion=motion,
        premises=record(Premises, about),
        prediction=record(Prediction, {"fitted": False, "scores": {"fitted": {}}}),
        quality=record(Quality, {"fingerprint": [*range(20)] if copied else []}),
    )


def rolled_out(recordings: dict[str, Inputs]) -> dict[tuple[str, int | None, float], RolledOut]:
    gravities = dict.fromkeys(recordings, SLOPE)
    rows = roll_out(robot(), recordings, known(), gravities)
    return {(row.model, row.joint, row.horizon_s): row for row in rows}


def test_an_arm_that_is_known_goes_where_it_went() -> None:
    """With its payload and mounting; without friction, or as described, it does not."""
    found = rolled_out({"new": recorded(robot())})
    ours, still = (found[model, None, 2.0] for model in (IDENTIFIED, STILL))
    assert (ours.windows, ours.recordings) == (11, 1)
    assert ours.error < 0.01 * still.error
    for model in ("A", "C", FRICTIONLESS, STILL):
        row = found[model, None, 2.0]
        assert row.beaten == "yes", model
        assert row.error > 10 * ours.error, model
    assert DESCRIBED not in {model for model, _, _ in found}, "without documented constants"
    assert ours.floor is None, "no motion is repeated"


def test_an_arm_as_described_has_described_rotors() -> None:
    """If all are, and not those that were fitted; with documented constants, and no friction."""
    known_rotors, without = (load_robot(robot_path(name)) for name in ("ur5e", "ur5"))
    motors = [known_rotors.motor(joint).reflected_rotor() for joint in range(1, 7)]
    fitted = known_rotors.models["maker+rotors"].model_copy(update={"rotor_inertias": (1.0,) * 6})
    arm = with_described(known_rotors.with_model("maker+rotors", fitted))
    assert [*arm.models[DESCRIBED].rotor_inertias] == motors
    assert with_described(without).models[DESCRIBED] == without.models["C"]
    documented = KnownConstants(np.full(6, 9.0), np.ones(6))
    *_, last = contenders(without, replace(known(), known_constants=documented))
    assert last == (DESCRIBED, DESCRIBED, False, True)
    constants = Constants.of([known().fit], ["coulomb"]).of_contender(
        last, ["coulomb"], 9 * np.ones(6)
    )
    assert (constants.torque_constant == 9).all()
    assert not constants.friction.any()


def test_standing_still_is_off_by_the_motion() -> None:
    recording = recorded(robot())
    q, length = recording.motion.q, round(2.0 / PERIOD)
    moved = np.degrees(np.abs(q[length::length] - q[:-length:length]))[:11]
    found = rolled_out({"new": recording})
    each = [found[STILL, joint, 2.0].error for joint in range(1, 7)]
    np.testing.assert_allclose(each, np.median(moved, axis=0), rtol=1e-6)


def test_repeats_show_what_no_model_avoids() -> None:
    """Two runs with noise of their own: they differ by as much as each errs."""
    pair = {name: recorded(robot(), 0.3, seed) for seed, name in enumerate(("new", "again"))}
    row = rolled_out(pair)[IDENTIFIED, None, 0.5]
    assert (row.windows, row.repeats) == (22, 22)
    assert row.floor == pytest.approx(row.error, rel=0.5)


def test_windows_that_a_fit_has_seen_or_that_are_touched_do_not_count() -> None:
    arm, own = robot(), known()
    assert not is_unseen("one", arm, own)
    left_out = replace(own, left_out=[LeftOut(["one"], own.fit)])
    assert is_unseen("one", arm, left_out)
    assert not is_unseen("one", arm.model_copy(update={"links": "fitted"}), left_out)
    assert is_unseen("new", arm, own)
    assert rolled_out({"one": recorded(arm)}) == {}
    touched = recorded(arm, touched=[(0.0, 9.0)])
    assert rolled_out({"new": touched})[IDENTIFIED, None, 2.0].windows == 7
    copies = {name: recorded(arm, copied=True) for name in ("new", "one", "same")}
    assert rolled_out(copies) == {}
    del copies["one"]
    assert rolled_out(copies)[IDENTIFIED, None, 2.0].recordings == 1
    loaded = {"mass": 1.0, "std_error": 0.1, "taken": True}
    carries = record(Prediction, {"scores": {"fitted": {}}, "load": loaded})
    unknown = Inputs(**{**vars(recorded(arm)), "prediction": carries})
    assert rolled_out({"new": unknown}) == {}
