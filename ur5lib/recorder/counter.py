"""The counter by which a device numbers its samples: it shows lost, late and repeated ones."""

LONGEST_GAP = 10.0  # s; after a longer jump, the counter is damaged or was restarted


class Counter:
    """Checks the numbers of consecutive samples.

    bits: numbers wrap around at 2^bits; rate_hz: of the samples. Numbers that are repeated, late,
    or more than LONGEST_GAP ahead are not accepted. total: the number without wrap-around.
    """

    def __init__(self, bits: int, rate_hz: float) -> None:
        self._period = 1 << bits
        self._furthest = min(int(LONGEST_GAP * rate_hz), self._period // 2 - 1)
        self._last: int | None = None
        self.total = 0

    def lost_before(self, number: int) -> int | None:
        """Return the count of samples missing before this one; None if it is not accepted."""
        step = 1 if self._last is None else (number - self._last) % self._period
        if not 1 <= step <= self._furthest:
            return None
        self.total += step if self._last is not None else number
        self._last = number
        return step - 1
