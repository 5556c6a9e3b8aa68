"""Whether stamps come at the rate that the name of a file or folder says, as `free_125hz.csv`."""

import re
from collections.abc import Iterable, Iterator

from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding

NAMED = re.compile(r"(?<![\d.])(\d+(?:\.\d+)?)[ _-]?(k?hz|ms)(?![a-z])", re.IGNORECASE)
MAX_DEVIATION = 0.03  # a rate differs from its rounded name by at most this share
MAX_RATIO = 1.9  # ratio of a named rate to the stamps'; above, every second sample may be left out


def other_named_rate(names: Iterable[str], period: float) -> Iterator[Finding]:
    """Warn of stamps at another rate than a name says; names: of files and folders; period: [s].

    If one number fits, those in other names mean something else, and there is no warning.
    """
    found = [(match[0], _rate(*match.groups())) for name in names for match in NAMED.finditer(name)]
    ratios = {text: rate * period for text, rate in found if rate > 0}
    if any(abs(ratio - 1) <= MAX_DEVIATION for ratio in ratios.values()):
        return
    for text, ratio in ratios.items():
        if 1 / MAX_RATIO < ratio < MAX_RATIO:
            detail = (
                f"the stamps come at {number(1 / period, '.4g')} Hz, but the name says {text}: if "
                f"it is right, velocities are {number(ratio, '.3g')} times as large; check the "
                "clock, and the unit of `time`"
            )
            yield Finding("robot", Found.OTHER_RATE_THAN_NAMED, "warning", 1, detail)


def _rate(value: str, unit: str) -> float:
    """Return a named rate, or period, as a rate [Hz]."""
    size = float(value)
    if unit.lower() == "ms":
        return 1e3 / size if size else 0.0
    return size * (1e3 if unit.lower() == "khz" else 1.0)
