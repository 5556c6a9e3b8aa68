"""One state in microseconds is the batch's, of arms with every kind of friction."""

import sys
from typing import Any

import numpy as np
import pytest

import ur5lib
from ur5lib.chain.efforts import Fits, States, effort_of_states
from ur5lib.chain.single import Single
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.friction import CoefficientEstimate, CurrentFit, JointFit
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.friction import INERTIA, REST_DISTANCES, TERMS, coefficient_names
from ur5lib.timeseries.lowpass import Butterworth

ARMS = ["ur5", "ur10e", "kuka-kr300"]  # the last with coupled motors and a counterbalance
EVERY = tuple(name for name in TERMS if name != INERTIA)
FEW = ("coulomb", "viscous", "load")


def drawn(robot: Robot, draw: np.random.Generator) -> CurrentFit:
    """A fit of which each joint has other terms, and one has another constant than the known."""

    def joint(k: int) -> JointFit:
        terms = FEW if k == 1 else EVERY
        values = draw.uniform(0.1, 1, 2 + len(coefficient_names(terms)))
        none = np.zeros((4, len(values)))
        return JointFit(
            terms=terms, distances=REST_DISTANCES, held=draw.uniform(0.1, 1, 3),
            estimate=CoefficientEstimate(values, none, none, none[0]),
            band_moving=0.1, band_reversing=0.1, band_standing=0.1, band_unknown=0.1,
            unseen=none[0], remarks=(), alone=1.1 * values if k == 2 else None,
        )  # fmt: skip

    return CurrentFit(tuple(joint(k) for k in range(len(robot.joints))), 5)


def states(draw: np.random.Generator, joints: int) -> np.ndarray:
    """Of which some joints rest, or nearly do."""
    found = draw.uniform(-2, 2, (3, 30, joints))
    found[1, :10] *= 1e-2
    found[1, 3:6] = 0
    return found


@pytest.mark.parametrize("usual", [False, True])
@pytest.mark.parametrize("name", ARMS)
def test_a_state_alone_is_that_of_the_batch(name: str, usual: bool) -> None:
    """Of a fit to one path, too, which has rest from other arms."""
    draw, robot = np.random.default_rng(3), load_robot(robot_path(name))
    fit, q_qd_qdd = drawn(robot, draw), states(draw, len(robot.joints))
    fits = Fits(fit, drawn(robot, draw) if usual else None)
    single, given = Single(robot, fits, True), States.of(*q_qd_qdd, None, len(robot.joints))
    found = effort_of_states(given, robot, fits, Butterworth(2, 5.0), [])
    rows = [*zip(*q_qd_qdd, strict=True)]
    currents, torques = ([ask(*row) for row in rows] for ask in (single.current, single.torque))
    np.testing.assert_allclose(currents, found.value, rtol=0, atol=1e-10)
    np.testing.assert_allclose(torques, found.as_torque().value, rtol=0, atol=1e-10)
    model = LinkModel(robot, robot.fullest_model())
    bare = [single.inverse_dynamics(*row) for row in rows]
    np.testing.assert_allclose(bare, model.inverse_dynamics(*q_qd_qdd), rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", ARMS)
def test_its_parts_make_up_the_motion(name: str) -> None:
    """τ = D q̈ + C q̇ + g, q̈ of τ, and the power of a force at the flange."""
    draw, robot = np.random.default_rng(4), load_robot(robot_path(name))
    single = Single(robot, Fits(drawn(robot, draw)), True)
    q, qd, qdd = draw.uniform(-1, 1, (3, len(robot.joints)))
    torque, still = single.inverse_dynamics(q, qd, qdd), single.inverse_dynamics(q, qd, 0 * q)
    np.testing.assert_allclose(torque - still, single.mass_matrix(q) @ qdd, atol=1e-9)
    np.testing.assert_allclose(single.forward_dynamics(q, qd, torque), qdd, atol=1e-8)
    np.testing.assert_allclose(single.gravity(q), single.inverse_dynamics(q, 0 * q, 0 * q))
    # a mass at the frame's origin is held by Jᵀ of its weight
    loaded = Single(robot.carrying(Payload(mass=2.0)), Fits(drawn(robot, draw)), True)
    weight = np.append(-2.0 * np.array(robot.gravity), [0.0, 0.0, 0.0])
    held = loaded.gravity(q) - single.gravity(q)
    np.testing.assert_allclose(held, single.jacobian(q).T @ weight, atol=1e-9)


def test_friction_in_a_loop_is_that_of_the_model(model: ur5lib.Model) -> None:
    single, draw = model.single(), np.random.default_rng(6)
    velocity, load = draw.uniform(-1, 1, (2, 50, 6))
    table = model.friction(velocity, np.abs(load)).to_numpy()[:, :6]
    found = [single.friction(*row) for row in zip(velocity, load, strict=True)]
    np.testing.assert_allclose(found, table, rtol=0, atol=1e-10)
    assert not single.friction(np.zeros(6), 5.0).any()
    heavy = model.single(payload=(2.0, (0, 0, 0.1)))
    q = draw.uniform(-1, 1, 6)
    np.testing.assert_allclose(
        heavy.torque(q, q, q), model.torque(q, q, q, payload=(2.0, (0, 0, 0.1))), atol=1e-10
    )


def test_without_pinocchio_a_sentence_tells_what_to_install(
    model: ur5lib.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(ur5lib.InputError, match="install it: pip install 'pin>"):
        model.single()
    answer: Any = model.torque(np.zeros(6), 0, 0)
    assert answer.shape == (6,)
