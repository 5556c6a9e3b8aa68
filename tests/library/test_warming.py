"""Friction that changes with the motors' temperatures, where these were recorded."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tests.library.current_study import CONSTANT, FRICTION, make_record, prior, smooth, with_noise
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import CurrentFit, parameters, predict
from ur5lib.identification.samples import Record
from ur5lib.pipeline.friction_fit import temperatures_differ
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.friction import USUAL, JointMotion, Term
from ur5lib.stand.friction import COULOMB_WARMING, VISCOUS_WARMING, Friction, friction_of

WARMING = Term("warming")
TEMPERATURES = (20, 45, 21, 44, 22, 43)  # °C, of six recordings: a cold arm, and a warm one
COULOMB, VISCOUS = -0.006, -0.02  # 1/K, of each joint's friction


def truth(joint: int) -> list[float]:
    """Change of Coulomb and viscous friction [Nm/K, Nm s/rad/K]."""
    coulomb, viscous, *_ = FRICTION[joint]
    return [COULOMB * coulomb, VISCOUS * viscous]


def warmed(seed: int, temperature: float) -> Record:
    """A recording at a temperature, with what friction gains by it."""
    record = with_noise(make_record(seed), seed)
    record = replace(record, temperature=np.full(record.q.shape, temperature))
    motions = [record.joint(joint, 3e-4) for joint in range(6)]
    gained = [WARMING.columns(motions[j]) @ truth(j) for j in range(6)]
    return replace(record, current=record.current + np.stack(gained, axis=1) / CONSTANT)


@pytest.fixture(scope="module")
def records() -> list[Record]:
    return [warmed(seed, temperature) for seed, temperature in enumerate(TEMPERATURES)]


def rmse(fit: CurrentFit, record: Record) -> float:
    residual = smooth(record.current - predict(fit, record), record)
    return float(np.sqrt(np.nanmean(residual**2)))


def test_its_columns_are_friction_s_per_kelvin() -> None:
    qd = np.array([-0.5, 0.2, 1.0])
    motion = JointMotion(qd, qd, qd, np.sign(qd), warmth=np.array([-5.0, 0.0, 10.0]))
    np.testing.assert_allclose(WARMING.columns(motion), [[5, 2.5], [0, 0], [10, 10]])
    assert WARMING.names() == ["warming_coulomb", "warming_viscous"]


def test_it_is_found_and_predicts_a_colder_arm(records: list[Record]) -> None:
    fit = fit_currents(records, smooth, prior(), [WARMING])
    chosen = [j for j, joint in enumerate(fit.joints) if WARMING in joint.terms]
    assert len(chosen) >= 3  # the wrists' friction is small beside its noise
    for row in parameters(fit):
        if row.name == "warming_viscous":
            assert abs(row.value - truth(row.joint - 1)[1]) < 4 * row.std_error
    without = fit_currents(records, smooth, prior(), [])
    cold = warmed(17, 15.0)
    assert rmse(fit, cold) < 0.8 * rmse(without, cold)


@pytest.mark.parametrize(
    ("temperatures", "tell"),
    [([20, 30], True), ([30, 31], False), ([], False), ([20, None], False), ([None], False)],
)
def test_only_temperatures_that_differ_tell(
    temperatures: Sequence[float | None], tell: bool
) -> None:
    bare = make_record(1, seconds=2)
    found = [t if t is None else np.full(bare.q.shape, float(t)) for t in temperatures]
    assert temperatures_differ([replace(bare, temperature=one) for one in found]) is tell


def test_without_temperatures_friction_is_that_of_the_usual_one() -> None:
    bare = make_record(1, seconds=2)
    usual = replace(bare, temperature=np.full(bare.q.shape, USUAL))
    without, known = (WARMING.columns(one.joint(2, 3e-4)) for one in (bare, usual))
    np.testing.assert_array_equal(without, known)
    assert not without.any()


def test_the_stand_s_friction_falls_as_it_warms() -> None:
    parameters = friction_of(load_robot(robot_path("ur5")), True)
    torque = []
    for warmth in (0.0, 10.0):
        friction = Friction(parameters, np.zeros(6))
        for _ in range(2000):
            slid = friction.torque(np.zeros(6), np.ones(6), np.zeros(6), 0.001, warmth)
        torque.append(slid)
    lost = parameters.coulomb * COULOMB_WARMING + parameters.viscous * VISCOUS_WARMING
    np.testing.assert_allclose(torque[1] - torque[0], 10 * lost, rtol=1e-6)
