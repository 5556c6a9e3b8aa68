"""Contacts that check finds in a recording to fit on leave its friction and its errors alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.current_study import CONSTANT, FRICTION, noisy, prior, smooth
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import physical_values
from ur5lib.identification.samples import CurrentSamples
from ur5lib.records.currents import Currents
from ur5lib.steps import fit_residuals
from ur5lib.steps.fit_friction import untouched
from ur5lib.timeseries.arrays import Array

CONTACT = 8.0, 12.0  # s
PUSH = 15.0  # Nm, on each of the big joints


def pushed(record: CurrentSamples) -> tuple[CurrentSamples, Array]:
    """A record with a contact, and its times."""
    time = np.asarray(record.period * np.arange(len(record.q)), np.float64)
    inside = (time >= CONTACT[0]) & (time <= CONTACT[1])
    torque = PUSH * np.array([1, 1, 1, 0, 0, 0])
    return replace(record, current=record.current - inside[:, None] * torque / CONSTANT), time


def coulomb_errors(records: list[CurrentSamples]) -> Array:
    """Errors (3,) [Nm] of the big joints' Coulomb friction."""
    fit = fit_currents(records, smooth, prior())
    found = [physical_values(own.estimate.coefficients)[2] for own in fit.joints[:3]]
    return np.abs(np.array(found) - [own[0] for own in FRICTION[:3]])


def test_friction_without_a_contact_is_as_if_none_had_been() -> None:
    free = noisy(range(3))
    touched = [pushed(record) for record in free]
    known = [untouched(record, time, [CONTACT]) for record, time in touched]
    assert np.isnan(known[0].current[500]).all()
    assert np.isfinite(known[0].current[:300]).all()
    with_contact = coulomb_errors([record for record, _ in touched]).max()
    assert coulomb_errors(known).max() < 0.5 * with_contact
    assert coulomb_errors(known).max() < coulomb_errors(free).max() + 0.5


@pytest.mark.parametrize("contacts", [[], [CONTACT]])
def test_an_external_torque_is_unknown_in_a_contact(contacts: list[tuple[float, float]]) -> None:
    time, zero = 0.1 * np.arange(200), np.zeros((200, 6))
    currents = Currents(time=5 + time, segment=np.zeros(200, int), external_torque=zero)
    known = fit_residuals.untouched(currents, contacts).external_torque
    assert known is not None
    inside = (time >= 7.5 - 1e-9) & (time <= 12.5 + 1e-9)
    np.testing.assert_array_equal(np.isnan(known).any(axis=1), inside & bool(contacts))
