"""Contacts at a force sensor: where it is touched, where it is free."""

import numpy as np
from scipy.ndimage import maximum_filter1d

from ur5lib.records.force_errors import Sensed
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import Span, spans

# At the sensor, a contact reaches the first force and lasts above the second.
TOUCH_FORCE = 3.0  # N
RELEASE_FORCE = 2.0  # N
CONTACT_FORCE = 5.0  # N, above which a sample is in contact
FREE_FORCE = 1.0  # N, below which a sample is free, if it is far from any touch
CONTACT_CLEARANCE = 0.5  # s, of a free sample from any touch
TOUCHED = "touched"  # the finding that a sensor reads contacts which the role rules out
FREE_ROLES = ("fit", "validate")  # of recordings in which nothing should touch the arm


def contacts(force: Array, least_force: float = TOUCH_FORCE) -> list[Span]:
    """Return contacts that reach a force. force: (N,) [N], of the sensor, NaN where unknown."""
    return spans(np.nan_to_num(force), least_force, RELEASE_FORCE)


def in_contact(force: Array) -> Mask:
    """Return the samples (N,) in contact; force: (N,) [N], of the sensor, NaN where unknown."""
    return np.asarray(force > CONTACT_FORCE)


def sensed_contact(force: Array, time: Array) -> Sensed | None:
    """Return what a sensor reads, None if it has no reading.

    force: (N,) [N], of the sensor, NaN where unknown; time: (N,) [s].
    """
    if not np.isfinite(force).any():
        return None
    peak = int(np.nanargmax(force))
    share = float(in_contact(force).mean())
    return Sensed(
        largest_force_n=float(force[peak]),
        at_s=float(time[peak]),
        share_in_contact=share,
        contacts=len(contacts(force, CONTACT_FORCE)),
    )


def touched(felt: Sensed | None, role: str) -> Finding | None:
    """Return an error where a sensor reads contacts on a recording that should be free of them."""
    if felt is None or not felt.contacts or role not in FREE_ROLES:
        return None
    count = f"{felt.contacts} contact{'s' * (felt.contacts > 1)}"
    largest = number(felt.largest_force_n, ".0f")
    detail = (
        f"the sensor reads up to {largest} N in {count}, although the role {role} "
        f"means that nothing touches the arm; give it the role contact"
    )
    return Finding("force", TOUCHED, "error", felt.contacts, detail)


def is_free(force: Array, period: float) -> Mask:
    """Return the samples (N,) without contact and half a second away from any.

    force: (N,) [N], of the sensor, NaN where unknown; period: [s].
    """
    reach = 2 * round(CONTACT_CLEARANCE / period) + 1
    touched = maximum_filter1d((force >= TOUCH_FORCE).astype(np.int8), reach, mode="nearest")
    return np.asarray((force < FREE_FORCE) & (touched == 0))
