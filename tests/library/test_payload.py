"""A payload from currents alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.library.current_study import make_record, prior, smooth, with_noise
from ur5lib.identification.currents import CurrentFit, fit_currents, predict
from ur5lib.identification.payload import estimate_payload
from ur5lib.identification.samples import Record

CARRIED = np.array([2.8, 0.1, -0.3])


@pytest.fixture(scope="module")
def fitted() -> CurrentFit:
    records = [with_noise(make_record(seed), seed) for seed in range(6)]
    return fit_currents(records, smooth, prior(), ())


def regressor(record: Record) -> np.ndarray:
    """Torque per mass and moments, as gravity would cause it on a made-up arm."""
    lever = np.array([0.0, 6.0, 5.0, 2.0, 1.0, 0.0])
    angles = np.stack([record.q, 2 * record.q + 1, record.q - np.roll(record.q, 1, axis=1)], axis=2)
    return lever[:, None] * np.cos(angles)


def test_a_payload_comes_back_with_the_friction_it_adds(fitted: CurrentFit) -> None:
    record = make_record(50)
    heavy = replace(record, torque=record.torque + regressor(record) @ CARRIED)
    loaded = replace(record, current=predict(fitted, heavy))
    payload = estimate_payload(fitted, loaded, regressor(record), smooth)
    np.testing.assert_allclose(payload.parameters, CARRIED, atol=0.01)


def test_its_interval_holds_the_mass_and_not_zero(fitted: CurrentFit) -> None:
    record = make_record(51)
    heavy = replace(record, torque=record.torque + regressor(record) @ CARRIED)
    loaded = with_noise(replace(record, current=predict(fitted, heavy)), 51)
    payload = estimate_payload(fitted, loaded, regressor(record), smooth)
    low, high = payload.mass_interval
    assert 0 < low < CARRIED[0] < high
    assert high - low < 1.0


def test_an_empty_flange_weighs_nothing(fitted: CurrentFit) -> None:
    empty = with_noise(make_record(52), 52)
    low, high = estimate_payload(fitted, empty, regressor(empty), smooth).mass_interval
    assert low < 0 < high


def test_a_few_wild_draws_do_not_set_the_error(fitted: CurrentFit) -> None:
    """Some draws of recordings leave out all that determines a friction parameter."""

    def wild(values: np.ndarray) -> np.ndarray:
        return np.where(np.arange(len(values))[:, None] % 20, values, 30 * values)

    joints = [
        replace(j, estimate=replace(j.estimate, replicates=wild(j.estimate.replicates)))
        for j in fitted.joints
    ]
    record = with_noise(make_record(53), 53)
    tame, torn = (
        estimate_payload(fit, record, regressor(record), smooth).std_error[0]
        for fit in (fitted, replace(fitted, joints=tuple(joints)))
    )
    assert torn < 1.5 * tame


def test_a_mass_that_motion_does_not_tell_is_stated_as_unknown(fitted: CurrentFit) -> None:
    record = with_noise(make_record(54), 54)
    blind = regressor(record) * [0, 1, 1]
    low, high = estimate_payload(fitted, record, blind, smooth).mass_interval
    assert low < -100 < 100 < high
    still = replace(record, qd=np.zeros_like(record.qd))
    low, high = estimate_payload(fitted, still, regressor(record), smooth).mass_interval
    assert low < -100 < 100 < high
