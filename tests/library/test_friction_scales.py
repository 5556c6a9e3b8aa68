"""The scales of UR's friction compensation, on made-up recordings whose friction is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.library.current_study import (
    CONSTANT,
    OFFSET,
    TERMS,
    coefficients,
    make_record,
    with_noise,
)
from ur5lib.commands.exported import exported
from ur5lib.commands.friction_scales import Expected, Scales, friction_scales, written
from ur5lib.errors import InputError
from ur5lib.identification.currents import CurrentFit, JointFit
from ur5lib.identification.estimation import Estimate
from ur5lib.identification.samples import Record, columns_of
from ur5lib.timeseries.arrays import Array

PLAIN = [0, 3, 4, 5]  # joints with Coulomb and viscous friction only
SHARES = np.array([[0.8, 0.5, 1.25, 0.9, 0.7, 1.1], [0.9, 0.8, 0.6, 1.3, 1.0, 0.75]])
SEEDS = range(3)


def fit(doubt: float = 0.0) -> CurrentFit:
    """The true one; doubt: relative standard deviation of the torque constants."""
    drawn = 1 + doubt * np.random.default_rng(1).standard_normal(500)
    joints = []
    for joint, terms in enumerate(TERMS):
        exact = coefficients(joint)
        replicates = np.tile(exact, (500, 1))
        replicates[:, 0] *= drawn
        estimate = Estimate(exact, 0 * exact, replicates, 0 * exact)
        joints.append(JointFit(terms, estimate, 3e-4, (), 0.0, 0.1, 0.1, 0 * exact, ()))
    return CurrentFit(tuple(joints), len(SEEDS))


def expected(record: Record) -> Expected:
    """What a controller expects that knows these shares of viscous and Coulomb friction."""
    qd = record.qd
    known = np.zeros_like(qd)
    for joint in range(6):
        columns, _ = columns_of(record.joint(joint, 3e-4), TERMS[joint][:2])
        coulomb, viscous = coefficients(joint)[2:4]
        known[:, joint] = SHARES[0, joint] * viscous * qd[:, joint]
        known[:, joint] += SHARES[1, joint] * coulomb * columns[:, 2]
    qdd = np.gradient(qd, record.period, axis=0)
    current = (record.torque + 0.2 * qdd) / (1.1 * CONSTANT) + known
    return Expected(record, qd, qdd, record.torque, current)


@pytest.fixture(scope="module")
def runs() -> list[Expected]:
    return [expected(make_record(seed)) for seed in SEEDS]


def test_without_noise_the_scales_are_exact(runs: list[Expected]) -> None:
    """Whatever constant the controller takes the torque for."""
    found = friction_scales(fit(), runs)
    np.testing.assert_allclose(found.value[:, PLAIN], 1 / SHARES[:, PLAIN], rtol=2e-3)
    assert found.std_error[:, PLAIN].max() < 0.02


def test_with_noise_they_are_within_their_errors(runs: list[Expected]) -> None:
    """Residuals as real ones are; half of the errors of 144 scales lie within 0.67 of theirs."""
    off = []
    for seed in range(6):
        noisy = [
            run._replace(record=with_noise(run.record, 10 * seed + k)) for k, run in enumerate(runs)
        ]
        found = friction_scales(fit(), noisy)
        off.append(((found.value - 1 / SHARES) / found.std_error)[:, PLAIN])
    assert 0.4 < np.median(np.abs(off)) < 1.0
    assert np.abs(off).max() < 6


def test_an_uncertain_torque_constant_makes_them_uncertain(runs: list[Expected]) -> None:
    sure, unsure = friction_scales(fit(), runs), friction_scales(fit(0.1), runs)
    np.testing.assert_array_equal(sure.value, unsure.value)
    assert (unsure.std_error[:, :5] > 1.1 * sure.std_error[:, :5]).all()


def test_a_joint_that_never_moves_has_none(runs: list[Expected]) -> None:
    still = []
    for run in runs:
        qd = run.record.qd.copy()
        qd[:, 2] = 0.0
        still.append(run._replace(record=replace(run.record, qd=qd), qd=qd))
    found = friction_scales(fit(), still)
    assert np.isnan(found.value[:, 2]).all()
    assert np.isfinite(np.delete(found.value, 2, axis=1)).all()


def test_what_is_written_is_what_the_controller_takes() -> None:
    """From 0 to 1; what was identified stands beside it."""
    value = np.array([[0.5, 0.9, 1.2, 1.0, 0.8, 0.7], [-0.1, 0.9, 0.9, 0.9, 0.9, 0.9]])
    told = yaml.safe_load(written("ur5e", Scales(value, np.full((2, 6), 0.02))))
    assert told["parameters"]["viscous_scale"] == [0.5, 0.9, 1.0, 1.0, 0.8, 0.7]
    assert told["parameters"]["coulomb_scale"][0] == 0.0
    assert told["identified"]["viscous_scale"] == value[0].tolist()
    assert told["std_error"]["coulomb_scale"] == [0.02] * 6


def without_coulomb(run: Expected) -> Expected:
    qd: Array = run.qd
    friction = np.stack([coefficients(joint)[3] * qd[:, joint] for joint in range(6)], axis=1)
    return run._replace(current=run.moment / CONSTANT + friction + OFFSET / CONSTANT)


def test_undetermined_scales_are_refused(runs: list[Expected]) -> None:
    """The target current of an arm of the CB series holds viscous friction only."""
    found = friction_scales(fit(), [*map(without_coulomb, runs)])
    np.testing.assert_allclose(found.value[0, PLAIN], 1, atol=0.02)
    with pytest.raises(InputError, match=r"coulomb_scale of ur5 .* joints 1, 2, 3, 4, 5, 6"):
        written("ur5", found)


def test_without_a_study_there_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--results"):
        exported("ur5e", None, "direct-torque", None, "")
