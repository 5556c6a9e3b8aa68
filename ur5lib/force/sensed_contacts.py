"""When something touches the arm, as its force sensor tells it."""

import numpy as np
from scipy.ndimage import maximum_filter1d

from ur5lib.force.detection import Span, spans
from ur5lib.timeseries.arrays import Array, Mask

TOUCH, RELEASE = 3.0, 2.0  # N: what a contact reaches, and above what it lasts
CONTACT = 5.0  # N, above which errors count as those in contact
FREE, CLEAR = 1.0, 0.5  # N, s: below, and so far from any touch, a sample is free


def contacts(force: Array, least: float = TOUCH) -> list[Span]:
    """Contacts that reach at least a force. force: (N,) [N], of the sensor, NaN where unknown."""
    return spans(np.nan_to_num(force), least, RELEASE)


def in_contact(force: Array) -> Mask:
    """Samples (N,) in contact; force: (N,) [N], of the sensor, NaN where unknown."""
    return np.asarray(force > CONTACT)


def is_free(force: Array, period: float) -> Mask:
    """Samples (N,) of which nothing touches the arm, nor within half a second.

    force: (N,) [N], of the sensor, NaN where unknown; period: [s].
    """
    reach = 2 * round(CLEAR / period) + 1
    touched = maximum_filter1d((force >= TOUCH).astype(np.int8), reach, mode="nearest")
    return np.asarray((force < FREE) & (touched == 0))
