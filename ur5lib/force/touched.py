"""What a force sensor reads of a recording, and whether that contradicts its role."""

import numpy as np

from ur5lib.force.sensed_contact import CONTACT_FORCE, FREE_ROLES, contacts, in_contact
from ur5lib.records.codes import Found
from ur5lib.records.force_errors import Sensed
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array


def sensed_contact(force: Array, time: Array) -> Sensed | None:
    """Return the largest force, and number and share of contacts, at a sensor; None if it has no
    reading.

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
    """Return an error if a sensor reads contacts in a recording with a role that excludes them;
    else None.
    """
    if felt is None or not felt.contacts or role not in FREE_ROLES:
        return None
    count = f"{felt.contacts} contact{'s' * (felt.contacts > 1)}"
    largest = number(felt.largest_force_n, ".0f")
    detail = (
        f"the sensor reads up to {largest} N in {count}, although the role {role} "
        f"means that nothing touches the arm; give it the role contact"
    )
    return Finding("force", Found.TOUCHED, "error", felt.contacts, detail)
