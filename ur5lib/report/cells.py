"""Formats of numbers, dates and joints in the report's tables and sentences."""

from collections.abc import Hashable, Iterable, Mapping, Sequence
from datetime import date
from typing import TypeVar

import numpy as np
import pandas as pd

from ur5lib.report.document import Mark

Name = TypeVar("Name", bound=Hashable)
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SMALLEST_DIFFERENCE = 5e-5  # visible with four decimals


def fixed(value: float, digits: int) -> str:
    """Format a value with some decimals."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")  # + 0.0: no −0


def significant(value: float, digits: int) -> str:
    """Format a value with some significant digits, without an exponent."""
    return np.format_float_positional(value, digits, fractional=False, trim="-")


def rounded(value: float, digits: int) -> str:
    """Format a value with some decimals, or as a bound if they would all be zeros."""
    if 0 < abs(value) < 0.5 * 10**-digits:
        return f"< {10**-digits:.{digits}f}"
    return fixed(value, digits)


def signed(value: float, digits: int, unit: str = "") -> str:
    """Format a difference with its sign; a dash for NaN."""
    return "–" if np.isnan(value) else f"{value:+.{digits}f}{unit}".replace("-", "−")


def power(value: float, digits: int = 3) -> str:
    """Format a value with some significant digits, as a power of ten where it is far from one."""
    if np.isnan(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    factor = f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return mantissa.replace("-", "−") + factor


def flange_speeds(low: float, high: float) -> str:
    """Return a range of the flange's speeds [m/s] in words; the slowest counts as rest."""
    if pd.isna(high):
        return f"≥ {low:g}"
    return f"{low:g}–{high:g}" if low > 0 else "at rest"


def days(first: str, last: str, word: str) -> str:
    """Return two ISO dates in words, without repeating month and year."""
    _, month, year = day(last).split()
    return f"{day(first).removesuffix(f' {year}').removesuffix(f' {month}')} {word} {day(last)}"


def day(iso: str) -> str:
    """Return an ISO date in words."""
    parsed = date.fromisoformat(iso)
    return f"{parsed.day} {parsed:%B %Y}"


def interval(low: float, high: float, digits: int) -> str:
    """Format an interval without a line break."""
    return f"{fixed(low, digits)}\u00a0to\u00a0{fixed(high, digits)}"


def joints(numbers: Iterable[float]) -> str:
    """Format joint numbers: joint 2; joints 1, 3; joints 1 to 6."""
    integers = [round(number) for number in numbers]
    return f"joint{'s' if len(integers) > 1 else ''} {numbered(integers)}"


def numbered(numbers: Sequence[int]) -> str:
    """Format numbers in order: 6; 2, 3; 2 to 4; 1, 5, 6."""
    row = len(numbers) > 2 and [*numbers] == [*range(numbers[0], numbers[-1] + 1)]
    return f"{numbers[0]} to {numbers[-1]}" if row else ", ".join(map(str, numbers))


def extremes(values: Mapping[Name, float]) -> dict[Name, Mark | None]:
    """Mark the lowest and the highest entry; none if they agree."""
    marks: dict[Name, Mark | None] = dict.fromkeys(values)
    lowest, highest = min(values, key=values.__getitem__), max(values, key=values.__getitem__)
    if values[highest] - values[lowest] > SMALLEST_DIFFERENCE:
        marks |= {lowest: "lowest", highest: "highest"}
    return marks
