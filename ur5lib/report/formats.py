"""Formats of numbers, dates and joints, as text that knows the numbers which it states.

Most are filters of the templates in `sentences.yaml` and `contents.yaml`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date

import numpy as np
import pandas as pd

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SMALLEST_DIFFERENCE = 5e-5  # visible with four decimals


@dataclass(frozen=True)
class Stated:
    """A number as a sentence states it: rounded, with its standard error if it gives one."""

    value: float
    std_error: float | None = None
    unit: str = ""


class Sentence(str):
    """Text that knows the numbers which it states, in their order."""

    numbers: tuple[Stated, ...] = ()


def sentence(text: str, numbers: Iterable[Stated] = ()) -> Sentence:
    """Return a text with its numbers."""
    numbered = Sentence(text)
    numbered.numbers = tuple(numbers)
    return numbered


def joined(parts: Iterable[str], between: str = " ") -> Sentence:
    """Return texts one after the other, with the numbers of all."""
    texts = [*parts]
    numbers = [number for part in texts for number in getattr(part, "numbers", ())]
    return sentence(between.join(texts), numbers)


def capital(text: str) -> Sentence:
    """Return a text with a capital letter."""
    return sentence(text[:1].upper() + text[1:], getattr(text, "numbers", ()))


def fixed(value: float, digits: int = 0, unit: str = "") -> Sentence:
    """Format a value with some decimals, and its unit; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    text = f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")  # + 0.0: no −0
    return _with_unit(text, round(float(value), digits), unit)


def rounded(value: float, digits: int = 0, unit: str = "") -> Sentence:
    """Format a value with some decimals, or as a bound if they would all be zeros."""
    if 0 < abs(value) < 0.5 * 10**-digits:  # a value given as a bound stays as it is
        return _with_unit(f"< {10**-digits:.{digits}f}", float(value), unit)
    return fixed(value, digits, unit)


def significant(value: float, digits: int, unit: str = "") -> Sentence:
    """Format a value with some significant digits, without an exponent; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    text = np.format_float_positional(value, digits, fractional=False, trim="-")
    return _with_unit(text.replace("-", "−"), float(f"{value:.{digits}g}"), unit)


def percent(share: float, digits: int = 0) -> Sentence:
    """Format a share in per cent."""
    return fixed(100 * share, digits, "%")


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


def counted(count: int) -> Sentence:
    """Format a count with commas between thousands."""
    return _with_unit(f"{count:,}", float(count), "")


def error(value: float, std: float, digits: int, unit: str = "") -> Sentence:
    """Format a value with its standard error and its unit; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    text = f"{fixed(value, digits)} ± {rounded(std, digits)}"
    return _with_unit(text, round(float(value), digits), unit, round(float(std), digits))


def to(low: float, high: float, digits: int, unit: str = "") -> Sentence:
    """Format an interval and its unit without a line break within the interval."""
    ends = [Stated(round(float(end), digits), None, unit) for end in (low, high)]
    return sentence(
        f"{fixed(low, digits)}\u00a0to\u00a0{fixed(high, digits)} {unit}".rstrip(), ends
    )


def each(values: Iterable[float], digits: int = 2, unit: str = "", bounds: bool = True) -> Sentence:
    """Format values one after the other, and their unit after the last.

    bounds: whether values that would round to zero are given as a bound (< 0.01).
    """
    parts = [(rounded if bounds else fixed)(value, digits) for value in values]
    numbers = [Stated(part.numbers[0].value, None, unit) for part in parts]
    return sentence(f"{', '.join(parts)} {unit}".rstrip(), numbers)


def _with_unit(text: str, value: float, unit: str, std: float | None = None) -> Sentence:
    return sentence(f"{text} {unit}".rstrip(), [Stated(value, std, unit)])


def joints(numbers: Iterable[float]) -> Sentence:
    """Format joint numbers: joint 2; joints 1, 3; joints 1 to 6."""
    integers = [round(number) for number in numbers]
    text = f"joint{'s' if len(integers) > 1 else ''} {numbered(integers)}"
    return sentence(text, [Stated(float(number)) for number in integers])


def numbered(numbers: Sequence[int]) -> str:
    """Format numbers in order: 6; 2, 3; 2 to 4; 1, 5, 6."""
    row = len(numbers) > 2 and [*numbers] == [*range(numbers[0], numbers[-1] + 1)]
    return f"{numbers[0]} to {numbers[-1]}" if row else ", ".join(map(str, numbers))


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
