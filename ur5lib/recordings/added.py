"""Names of what `ur5 convert --into` adds to copies of recordings: estimates, which no device
measured, and which no reader takes for a channel.
"""

import re

GROUP = "ur5lib"  # the group of arrays, and what names of columns and topics begin with
ADDED = re.compile(rf"/?{GROUP}([/_]|$)")


def is_added(name: str) -> bool:
    """Return whether an array, a column or a topic is one that was added."""
    return ADDED.match(name) is not None
