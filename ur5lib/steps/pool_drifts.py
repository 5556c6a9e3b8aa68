"""The drift of each host, from contact-free recordings with a clock estimated by motion."""

from collections.abc import Mapping

from ur5lib.records.clocks import HostDrift, OwnClock
from ur5lib.records.step import step
from ur5lib.signals import clock


@step("arm", "drifts.json", recordings="contact_free")
def pool_drifts(
    clocks: Mapping[str, dict[str, OwnClock]], hosts: dict[str, list[str]]
) -> dict[str, HostDrift]:
    """Return the drift of each host by its name; hosts: their devices, which share a clock.

    clocks: of the devices in an arm's contact-free recordings.
    """
    return clock.pool_drifts(dict(clocks), hosts)
