"""Formats of numbers, dates and joints as text.

Most are filters of the templates in `sentences.yaml` and `contents.yaml`.
"""

import math
from collections.abc import Iterable, Sequence
from datetime import date

import numpy as np
import pandas as pd

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MOST_DECIMALS = 4
VISIBLE_DIFFERENCE = 5e-5  # visible with them


def capital(text: str) -> str:
    """Return a text with a capital letter."""
    return text[:1].upper() + text[1:]


def fixed(value: float, digits: int = 0, unit: str = "") -> str:
    """Format a value with some decimals, and its unit; a dash for NaN.

    digits: of the decimals; below zero, of the zeros before the point.
    """
    if pd.isna(value):
        return "–"
    text = f"{round(value, digits) + 0.0:.{max(digits, 0)}f}".replace("-", "−")  # + 0.0: no −0
    return _with_unit(text, unit)


def rounded(value: float, digits: int = 0, unit: str = "") -> str:
    """Format a value with some decimals, or as a bound if they would all be zeros."""
    if 0 < abs(value) < 0.5 * 10**-digits:  # a value given as a bound stays as it is
        return _with_unit(f"< {10**-digits:.{digits}f}", unit)
    return fixed(value, digits, unit)


def significant(value: float, digits: int, unit: str = "") -> str:
    """Format a value with some significant digits, without an exponent; a dash for NaN."""
    if pd.isna(value):
        return "–"
    text = np.format_float_positional(value, digits, fractional=False, trim="-")
    return _with_unit(text.replace("-", "−"), unit)


def measured(value: float, unit: str = "") -> str:
    """Format a value of unknown error with three significant digits, but at most four decimals, and
    a count as it is.
    """
    if pd.isna(value) or value == 0 or isinstance(value, int):
        return fixed(value, 0, unit)
    return rounded(value, min(max(_decimals(value, 3), 0), MOST_DECIMALS), unit)


def percent(share: float, digits: int = 0) -> str:
    """Format a share in per cent."""
    return fixed(100 * share, digits, "%")


def signed(value: float, digits: int, unit: str = "") -> str:
    """Format a difference with its sign; a dash for NaN."""
    if np.isnan(value):
        return "–"
    text = f"{rounded:+.{digits}f}" if (rounded := round(value, digits)) else f"{0:.{digits}f}"
    return text.replace("-", "−") + unit


def power(value: float, digits: int = 3) -> str:
    """Format a value with some significant digits, as a power of ten where it is far from one."""
    if np.isnan(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    factor = f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return mantissa.replace("-", "−") + factor


def counted(count: int) -> str:
    """Format a count with commas between thousands."""
    return f"{count:,}"


def with_error(value: float, std: float, unit: str = "") -> str:
    """Format a value with its standard error, two significant digits of which decide both."""
    if pd.isna(value) or not 0 < std < math.inf:
        return measured(value, unit)
    digits = _decimals(std, 2)
    return _with_unit(" ± ".join(fixed(part, digits) for part in (value, std)), unit)


def within(
    value: float, low: float | None = None, high: float | None = None, unit: str = ""
) -> str:
    """Format a value with the decimals of its 95 % interval, if known, but no more than `measured`
    shows.
    """
    if low is None or high is None or not low < high or value == 0:
        return measured(value, unit)
    digits = min(_decimals((high - low) / 4, 2), _decimals(value, 3))
    return rounded(value, min(max(digits, 0), MOST_DECIMALS), unit)


def _decimals(value: float, digits: int) -> int:
    """Return the number of decimals, or of whole digits below zero, of some significant digits."""
    return digits - 1 - math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))


def to(low: float, high: float, digits: int, unit: str = "") -> str:
    """Format an interval and its unit without a line break within the interval, or the one value
    that both ends read as.
    """
    ends = dict.fromkeys((fixed(low, digits), fixed(high, digits)))
    return _with_unit("\u00a0to\u00a0".join(ends), unit)


def between(low: float, high: float, value: float = math.nan) -> str:
    """Format an interval, after its value if known, which has two significant digits; without, the
    upper end has.
    """
    digits = _decimals(high if math.isnan(value) else value, 2)
    digits = digits if abs(low) > 10**-digits / 2 else max(digits, 0)  # no end of zero
    ends = "–".join(fixed(end, digits) for end in (low, high))
    return ends if math.isnan(value) else f"{fixed(value, digits)} ({ends})"


def each(
    values: Iterable[float],
    digits: int = 2,
    unit: str = "",
    bounds: bool = True,
    most: float = math.inf,
) -> str:
    """Format values one after the other, and their unit after the last.

    bounds: whether values that would round to zero are given as a bound (< 0.01); most: from which
    on a value is given as a bound, too (> 100).
    """
    form = rounded if bounds else fixed
    parts = [f"> {fixed(most, digits)}" if v >= most else form(v, digits) for v in values]
    return _with_unit(", ".join(parts), unit)


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}".rstrip()


def joints(numbers: Iterable[float]) -> str:
    """Format joint numbers: joint 2; joints 1, 3; joints 1 to 6."""
    integers = [round(number) for number in numbers]
    return f"joint{'s' if len(integers) > 1 else ''} {numbered(integers)}"


def numbered(numbers: Sequence[int]) -> str:
    """Format numbers in order: 6; 2, 3; 2 to 4; 1, 5, 6."""
    row = len(numbers) > 2 and [*numbers] == [*range(numbers[0], numbers[-1] + 1)]
    return f"{numbers[0]} to {numbers[-1]}" if row else ", ".join(map(str, numbers))


def days(first: str, last: str, word: str) -> str:
    """Return two ISO dates in words, without repeating month and year."""
    _, month, year = day(last).split()
    return f"{day(first).removesuffix(f' {year}').removesuffix(f' {month}')} {word} {day(last)}"


def day(iso: str) -> str:
    """Return an ISO date in words."""
    parsed = date.fromisoformat(iso)
    return f"{parsed.day} {parsed:%B %Y}"
