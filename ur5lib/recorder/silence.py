"""Detection of a device that has stopped sending."""

import time

from ur5lib.recorder.device import DeviceLost

LONGEST = 1.0  # s


class Silence:
    """Detects that a device has stopped sending; name: of the device, for messages."""

    def __init__(self, name: str) -> None:
        """Start the timer."""
        self._name, self._last = name, time.monotonic()

    def check(self, samples: int) -> None:
        """Restart the timer if there are samples; raise DeviceLost after 1 s without any."""
        now = time.monotonic()
        if samples:
            self._last = now
        elif now - self._last > LONGEST:
            raise DeviceLost(f"{self._name} has sent nothing for {LONGEST:g} s")
