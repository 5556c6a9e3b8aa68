"""The notation of numbers and lists in the sentences of findings, remarks and next steps."""

import math
from collections.abc import Iterable

import numpy as np

# A larger number in a sentence only says that something is wrong.
MAX_STATED_NUMBER = 9999


def number(value: float | None, form: str = "") -> str:
    """Return a number as text, with a true minus sign and without an exponent.

    "unknown" for None and numbers that are not finite, "above 9999" with more than four digits
    before the point. form: as of an f-string.
    """
    if value is None or not math.isfinite(value):
        return "unknown"
    return _bounded(value, form).replace("-", "−")


def as_written(values: Iterable[float], form: str = "") -> str:
    """Return numbers in the notation of a study: commas, hyphens as minus; form: as of `number`."""
    return ", ".join(_bounded(value, form) for value in values)


def _bounded(value: float, form: str) -> str:
    text = format(value, form)
    if form.endswith("g") and "e" in text:
        return np.format_float_positional(float(text), trim="-")
    most = MAX_STATED_NUMBER / 100 if form.endswith("%") else MAX_STATED_NUMBER
    if form[-1:] not in ("f", "%") or not abs(value) > most:
        return text
    bound = format(math.copysign(most, value), f".0{form[-1]}")
    return f"{'above' if value > 0 else 'below'} {bound}"


def numbered(joints: Iterable[object]) -> str:
    """Return joints by their numbers: joint 4; joints 2, 3."""
    known = [*map(str, joints)]
    return f"joint{'s' * (len(known) > 1)} {', '.join(known)}"
