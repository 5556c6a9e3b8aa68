"""Sentences and cells of the report: templates of Jinja, filled with numbers.

Sentences stand in `sentences.yaml`, cells in `contents.yaml`. A sentence knows the numbers that it
states, in their order, so that none is read from its text.
"""

import re
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from numbers import Real
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd
from jinja2.environment import TemplateExpression

from ur5lib.pipeline.estimators import ESTIMATES, PUBLISHED
from ur5lib.report import cells
from ur5lib.strict import read_yaml


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


def say(name: str, /, **values: Any) -> Sentence:
    """Return the sentence of a template, `topic.name`, filled with values.

    Raises KeyError where there is no such template.
    """
    numbers: list[Stated] = []
    text = _templates()[name].render(values, _numbers=numbers)
    return sentence(re.sub(r" +", " ", text).strip(), numbers)


def cell(template: str, values: Mapping[Hashable, object]) -> str | None:
    """Return the text of a cell: an expression of Jinja or, with braces, a template.

    None where the expression is none: the cell is empty.
    """
    if "{" in template:
        return filled(template, values)
    found = _expression(template)(values)
    return None if found is None else str(found)


def filled(template: str, values: Mapping[Hashable, object]) -> str:
    """Return a template filled with values."""
    return _template(template).render(values, _numbers=[])


def name(value: str, topic: str) -> str:
    """Return the name of a value in the report, the value itself where it has no other."""
    return names(topic).get(value, value)


@cache
def names(topic: str) -> dict[str, str]:
    """Return the names of the values of a topic, in the report's order; empty if it has none."""
    return {"estimate": ESTIMATES, **_written()[0]}.get(topic, {})


@jinja2.pass_context
def _noted(context: jinja2.runtime.Context, value: Any) -> Any:
    """Collect the numbers that a template shows."""
    if isinstance(value, Real) and not isinstance(value, bool):
        value = sentence(f"{value}", [Stated(float(value))])
    context["_numbers"].extend(getattr(value, "numbers", ()))
    return value


def _fixed(value: float, digits: int = 0, unit: str = "") -> Sentence:
    """Format a value with some decimals, and its unit; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    return _with_unit(cells.fixed(value, digits), round(float(value), digits), unit)


def _rounded(value: float, digits: int = 0, unit: str = "") -> Sentence:
    """Format a value with some decimals, or as a bound if they would all be zeros."""
    stated = round(float(value), digits) or float(value)  # a value given as a bound stays
    return _with_unit(cells.rounded(value, digits), stated, unit)


def _significant(value: float, digits: int, unit: str = "") -> Sentence:
    """Format a value with some significant digits; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    text = cells.significant(value, digits).replace("-", "−")
    return _with_unit(text, float(f"{value:.{digits}g}"), unit)


def _percent(share: float, digits: int = 0) -> Sentence:
    return _fixed(100 * share, digits, "%")


def _error(value: float, std: float, digits: int, unit: str = "") -> Sentence:
    """Format a value with its standard error and its unit; a dash for NaN."""
    if pd.isna(value):
        return sentence("–")
    text = f"{cells.fixed(value, digits)} ± {cells.rounded(std, digits)}"
    return _with_unit(text, round(float(value), digits), unit, round(float(std), digits))


def _to(low: float, high: float, digits: int, unit: str = "") -> Sentence:
    """Format an interval and its unit without a line break within the interval."""
    ends = [Stated(round(float(end), digits), None, unit) for end in (low, high)]
    return sentence(f"{cells.interval(low, high, digits)} {unit}".rstrip(), ends)


def _counted(count: int) -> Sentence:
    """Format a count with commas between thousands."""
    return _with_unit(f"{count:,}", float(count), "")


def _with_unit(text: str, value: float, unit: str, std: float | None = None) -> Sentence:
    return sentence(f"{text} {unit}".rstrip(), [Stated(value, std, unit)])


def _each(
    values: Iterable[float], digits: int = 2, unit: str = "", bounds: bool = True
) -> Sentence:
    """Format values one after the other, and their unit after the last.

    bounds: whether values that would round to zero are given as a bound (< 0.01).
    """
    parts = [(_rounded if bounds else _fixed)(value, digits) for value in values]
    numbers = [Stated(part.numbers[0].value, None, unit) for part in parts]
    return sentence(f"{', '.join(parts)} {unit}".rstrip(), numbers)


def _joints(numbers: Iterable[float]) -> Sentence:
    """Format joint numbers: joint 2; joints 1, 3; joints 1 to 6."""
    joints = [*numbers]
    return sentence(cells.joints(joints), [Stated(float(joint)) for joint in joints])


FILTERS = {
    "fixed": _fixed,
    "rounded": _rounded,
    "significant": _significant,
    "signed": cells.signed,
    "percent": _percent,
    "error": _error,
    "to": _to,
    "each": _each,
    "joints": _joints,
    "joined": joined,
    "capital": capital,
    "counted": _counted,
    "power": cells.power,
    "days": cells.days,
    "flange_speeds": cells.flange_speeds,
    "name": name,
}


@cache
def _written() -> tuple[dict[str, dict[str, str]], dict[str, dict[str, str]]]:
    """Return the names and the templates in `sentences.yaml`, by topic."""
    templates = dict(read_yaml(Path(__file__).with_name("sentences.yaml")))
    return templates.pop("names"), templates


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, finalize=_noted)
    environment.filters |= FILTERS
    environment.tests |= {"known": pd.notna, "published": PUBLISHED.__contains__}
    return environment


@cache
def _template(text: str) -> jinja2.Template:
    return _environment().from_string(text)


@cache
def _expression(text: str) -> TemplateExpression:
    return _environment().compile_expression(text, undefined_to_none=False)


@cache
def _templates() -> dict[str, jinja2.Template]:
    return {
        f"{topic}.{name}": _template(text)
        for topic, texts in _written()[1].items()
        for name, text in texts.items()
    }
