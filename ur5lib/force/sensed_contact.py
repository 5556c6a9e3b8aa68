"""Contacts at a force sensor: where it is touched, where it is free."""

import numpy as np
import scipy  # loads scipy.ndimage at its first use

from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import Span, spans

# At the sensor, a contact reaches the first force and lasts above the second.
TOUCH_FORCE = 3.0  # N
RELEASE_FORCE = 2.0  # N
CONTACT_FORCE = 5.0  # N; above it, a sample is in contact
FREE_FORCE = 1.0  # N; below it, a sample is free if it is far from any touch
CONTACT_CLEARANCE = 0.5  # s; a free sample is this far from any touch
FREE_ROLES = ("fit", "validate")  # in recordings of these roles, nothing should touch the arm


def contacts(force: Array, least_force: float = TOUCH_FORCE) -> list[Span]:
    """Return the spans of contacts that reach a force [N]; force: (N,) [N], of the sensor, NaN
    where unknown.
    """
    return spans(np.nan_to_num(force), least_force, RELEASE_FORCE)


def in_contact(force: Array) -> Mask:
    """Return the samples (N,) in contact; force: (N,) [N], of the sensor, NaN where unknown."""
    return np.asarray(force > CONTACT_FORCE)


def is_free(force: Array, period: float) -> Mask:
    """Return the samples (N,) without contact and half a second away from any.

    force: (N,) [N], of the sensor, NaN where unknown; period: [s].
    """
    reach = 2 * round(CONTACT_CLEARANCE / period) + 1
    touched = scipy.ndimage.maximum_filter1d(
        (force >= TOUCH_FORCE).astype(np.int8), reach, mode="nearest"
    )
    return np.asarray((force < FREE_FORCE) & (touched == 0))
