"""How long a device may be silent before it counts as lost."""

import time

from ur5lib.recorder.device import DeviceLost

LONGEST = 1.0  # s


class Silence:
    """Detects that a device has stopped sending; name: of the device, for messages."""

    def __init__(self, name: str) -> None:
        """Begin now, as if a sample had just come."""
        self._name, self._heard = name, time.monotonic()

    def check(self, samples: int) -> None:
        """Note how many samples have just come; raise DeviceLost if the last came over 1 s ago."""
        now = time.monotonic()
        if samples:
            self._heard = now
        elif now - self._heard > LONGEST:
            raise DeviceLost(f"{self._name} has sent nothing for {LONGEST:g} s")
