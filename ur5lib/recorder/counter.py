"""The counter by which a device numbers its samples: what is lost, late or repeated."""

LONGEST_GAP = 10.0  # s; a counter that jumps further is damaged, or the device was restarted


class Counter:
    """Checks the numbers of consecutive samples.

    Numbers wrap around at 2^bits. A number that is repeated, late, or further ahead than
    LONGEST_GAP at `rate_hz` is not accepted, so that accepted ones always increase. `total` counts
    on where they wrap around.
    """

    def __init__(self, bits: int, rate_hz: float) -> None:
        self._period = 1 << bits
        self._furthest = min(int(LONGEST_GAP * rate_hz), self._period // 2 - 1)
        self._last: int | None = None
        self.total = 0

    def lost_before(self, number: int) -> int | None:
        """Return how many samples are missing before this one; None if it is not accepted."""
        step = 1 if self._last is None else (number - self._last) % self._period
        if not 1 <= step <= self._furthest:
            return None
        self.total += step if self._last is not None else number
        self._last = number
        return step - 1
