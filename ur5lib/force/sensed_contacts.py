"""Contacts according to the force sensor."""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d

from ur5lib.force.detection import Span, spans
from ur5lib.timeseries.arrays import Array, Mask

TOUCH, RELEASE = 3.0, 2.0  # N: a contact reaches the first and lasts above the second
CONTACT = 5.0  # N, above which a sample is in contact
FREE, CLEAR = 1.0, 0.5  # N, s: a free sample is below this force and this far from any touch


def contacts(force: Array, least: float = TOUCH) -> list[Span]:
    """Return contacts that reach a force. force: (N,) [N], of the sensor, NaN where unknown."""
    return spans(np.nan_to_num(force), least, RELEASE)


def in_contact(force: Array) -> Mask:
    """Return the samples (N,) in contact; force: (N,) [N], of the sensor, NaN where unknown."""
    return np.asarray(force > CONTACT)


class Felt(NamedTuple):
    """What a force sensor reads: largest [N], at_s: the time of the largest force [s]; contact: the
    share of the recording in contact; contacts: their number.
    """

    largest: float
    at_s: float
    contact: float
    contacts: int


def felt(force: Array, time: Array) -> Felt | None:
    """Return what a sensor reads, None if it has no reading.

    force: (N,) [N], of the sensor, NaN where unknown; time: (N,) [s].
    """
    if not np.isfinite(force).any():
        return None
    peak = int(np.nanargmax(force))
    share = float(in_contact(force).mean())
    return Felt(float(force[peak]), float(time[peak]), share, len(contacts(force, CONTACT)))


def is_free(force: Array, period: float) -> Mask:
    """Return the samples (N,) without contact and half a second away from any.

    force: (N,) [N], of the sensor, NaN where unknown; period: [s].
    """
    reach = 2 * round(CLEAR / period) + 1
    touched = maximum_filter1d((force >= TOUCH).astype(np.int8), reach, mode="nearest")
    return np.asarray((force < FREE) & (touched == 0))
