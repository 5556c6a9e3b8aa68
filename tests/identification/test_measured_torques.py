"""Links, gears and counterbalances from measured torques: of made-up arms whose truth is known."""

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tests.current_study import cut
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import identified_model
from ur5lib.identification.consistency import LinkBounds, smallest_eigenvalues
from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.identification.measured_torques import (
    CENTER_MARGIN_SHARE,
    ArmFit,
    fit_arm,
    link_bounds,
)
from ur5lib.identification.samples import CurrentSamples
from ur5lib.identification.torque_rows import MeasuredRun, TorqueRows, torque_rows
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.friction import friction_direction
from ur5lib.robots.inertia import link_tail
from ur5lib.steps.identify_model import with_fitted
from ur5lib.timeseries.arrays import Array

SMOOTH = ZeroPhaseLowpass(4, 2.0)
PERIOD = 0.02
TRUE_WEIGHT = 40.0  # kg, a little more than all links of a UR10e, base and all


@pytest.fixture(scope="module")
def arm() -> Robot:
    """A UR10e, of which the fit knows axes and weight alone."""
    return load_robot(robot_path("ur10e")).model_copy(update={"weight": TRUE_WEIGHT})


def drawn_run(arm: Robot, seed: int, balance: float = 0.0, gears: float = 0.0) -> MeasuredRun:
    """A motion of 20 s with friction 8 sign(q̇) + 15 q̇ - gears q̇ |q̇| on each joint.

    balance: torque balance · sin q₂ of a spring on joint 2 [Nm].
    """
    random = np.random.default_rng(seed)
    time = PERIOD * np.arange(1000)
    order = 2 * np.pi / 20 * np.arange(1, 7)[:, None, None]
    size = 0.5 * random.normal(size=(6, 1, 6)) / np.arange(1, 7)[:, None, None]
    angle = order * time[:, None] + random.uniform(0, 2 * np.pi, (6, 1, 6))
    q = (size * np.sin(angle)).sum(axis=0) + random.uniform(-1, 1, 6)
    qd = (size * order * np.cos(angle)).sum(axis=0)
    qdd = -(size * order**2 * np.sin(angle)).sum(axis=0)
    model, segment = LinkModel(arm, arm.chosen_model), np.zeros(len(time), int)
    direction = np.stack([friction_direction(joint, segment) for joint in q.T], axis=1)
    friction = 8 * direction + 15 * qd - gears * qd * np.abs(qd)
    torque = model.inverse_dynamics(q, qd, qdd) + friction
    torque[:, 1] += balance * np.sin(q[:, 1])
    torque += random.normal(size=torque.shape)
    samples = CurrentSamples(f"run {seed}", PERIOD, segment, q, qd, 0 * q, torque)
    return MeasuredRun(samples, qdd, model.regressor)


def runs(arm: Robot, balance: float = 0.0, gears: float = 0.0) -> list[MeasuredRun]:
    return [drawn_run(arm, seed, balance, gears) for seed in range(6)]


def unseen_gravity(arm: Robot, parameters: Array) -> tuple[Array, Array]:
    """Gravity's torque in drawn postures, by fitted links and by the true ones."""
    found = arm.with_model("found", identified_model(arm, parameters, ""))
    q = np.random.default_rng(9).uniform(-1.5, 1.5, (200, 6))
    return (
        LinkModel(found, "found").gravity_torque(q),
        LinkModel(arm, arm.chosen_model).gravity_torque(q),
    )


def test_a_part_of_a_path_is_of_one_recording(arm: Robot) -> None:
    """Where a path is repeated, its runs are left out part by part, and none with another one."""
    run = drawn_run(arm, 0)
    again = replace(run, samples=replace(run.samples, name="again"))
    one, two = (torque_rows(known, [], SMOOTH, np.eye(6)) for known in ([run], [run, again]))
    assert len(one.units) > 1
    short = replace(run, samples=cut(run.samples, slice(300), name="short"), qdd=run.qdd[:300])
    both, alone = (torque_rows(own, [], SMOOTH, np.eye(6)) for own in ([short, run], [short]))
    assert len(both.units) == len(alone.units) + len(one.units)
    assert [len(torque) for _, torque in two.units] == 2 * [len(torque) for _, torque in one.units]


def test_links_are_bodies_that_hold_in_other_postures(arm: Robot) -> None:
    fitted = fit_arm(arm, runs(arm), SMOOTH)
    assert fitted.balanced == []
    assert (smallest_eigenvalues(fitted.parameters) > 0).all()
    found, true = unseen_gravity(arm, fitted.parameters)
    assert np.abs(found - true).max() < 0.03 * np.abs(true).max()


def test_links_from_recordings_tell_nothing_against_them(arm: Robot) -> None:
    """Nor against others: friction, which is in these torques, is not gravity's."""
    assert arm.tells_gravity()
    assert not with_fitted(arm, fit_arm(arm, runs(arm), SMOOTH)).tells_gravity()


def test_a_counterbalance_is_no_link(arm: Robot) -> None:
    """With it in its place, gravity is still that of the links."""
    fitted = fit_arm(arm, runs(arm, balance=-250.0), SMOOTH)
    assert fitted.balanced == [2]
    unweighed = fit_arm(arm.model_copy(update={"balanced_joints": [2]}), runs(arm, -250.0), SMOOTH)
    np.testing.assert_allclose(unweighed.parameters, fitted.parameters)


class ToldErrors(ArmFit):
    """A fit of which the errors on left-out units are told, by the joints that are balanced."""

    def __init__(
        self,
        by_joints: dict[tuple[int, ...], list[float]],
        any_links: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    ) -> None:
        self.told, self.any_links = by_joints, any_links
        places = SimpleNamespace(joints=4, places=lambda _, own=(): tuple(own))
        self.rows, self.bounds = cast(TorqueRows, places), cast(LinkBounds, "bodies")

    def unseen_errors(self, places: Sequence[int], bounds: LinkBounds | None) -> Array:
        """The same in each fold; any_links: of links that need not be bodies."""
        own = self.any_links if bounds is None else self.told.get(tuple(places), [30.0] * 4)
        return np.tile(own, (5, 1))


def test_a_counterbalance_has_to_explain_its_own_joint() -> None:
    """What it does for other joints shows no counterbalance."""
    own = ToldErrors({(): [9.0, 1.0, 1.2, 9.0], (3,): [1.0, 1.0, 1.19, 1.0]})
    assert own.balanced_joints([]) == []
    own = ToldErrors({(): [9.0, 1.0, 1.2, 9.0], (3,): [9.0, 1.0, 1.05, 9.0]})
    assert own.balanced_joints([]) == [3]
    own = ToldErrors({(): [1.0, 1.0, 9.0, 1.0], (3,): [1.0, 1.0, 1.6, 1.0]})
    assert own.balanced_joints([]) == []  # not even so as well as any numbers
    told = {(): [9.0, 1.0, 9.0, 1.0], (3,): [9.0, 1.0, 1.05, 1.0]}
    assert ToldErrors(told, (1.0, 1.0, 8.9, 1.0)).balanced_joints([]) == []  # nothing to explain


def test_counterbalances_are_found_one_after_the_other() -> None:
    """First the one that explains most."""
    told = {(): [1.0, 20.0, 50.0, 1.0], (2,): [1.0, 1.1, 50.0, 1.0], (3,): [1.0, 20.0, 1.1, 1.0]}
    assert ToldErrors(told | {(3, 2): [1.0] * 4}).balanced_joints([]) == [3, 2]
    assert ToldErrors(told).balanced_joints([]) == [3]


def test_gears_that_lose_less_at_speed_are_no_links(arm: Robot) -> None:
    fitted = fit_arm(arm, runs(arm, gears=12.0), SMOOTH)
    found, true = unseen_gravity(arm, fitted.parameters)
    assert np.abs(found - true).max() < 0.03 * np.abs(true).max()


def test_one_short_motion_is_too_little(arm: Robot) -> None:
    """It has no part that the others could predict."""
    (run,) = runs(arm)[:1]
    short = {
        name: getattr(run.samples, name)[:100]
        for name in ("segment", "q", "qd", "torque", "current")
    }
    with pytest.raises(RefusalError):
        fit_arm(
            arm, [replace(run, samples=replace(run.samples, **short), qdd=run.qdd[:100])], SMOOTH
        )


def test_recordings_without_torques_are_left_out(arm: Robot) -> None:
    """They may be all."""
    one = runs(arm)[0]
    without = replace(
        one, samples=replace(one.samples, current=np.full_like(one.samples.q, np.nan))
    )
    shown = [fit_arm(arm, some, SMOOTH).parameters for some in (runs(arm), [without, *runs(arm)])]
    np.testing.assert_allclose(*shown)
    for none in ([], [without]):
        with pytest.raises(RefusalError, match="no fit torques"):
            fit_arm(arm, none, SMOOTH)


@pytest.mark.parametrize("name", ["ur3", "ur10e"])
def test_a_link_s_box_reaches_as_far_beyond_its_ends_as_the_arm_is_long(name: str) -> None:
    """By a share of the sum of all links' lengths, to all sides."""
    arm = load_robot(robot_path(name))
    bounds = link_bounds(arm)
    tails = [link_tail(pose)[1] for pose in arm.link_poses()]
    margin = CENTER_MARGIN_SHARE * sum(math.hypot(*tail) for tail in tails)
    for tail, low, high in zip(tails, bounds.low, bounds.high, strict=True):
        for end, least, most in zip(tail, low, high, strict=True):
            assert (least, most) == pytest.approx((min(end, 0) - margin, max(end, 0) + margin))
