"""Sentences and cells of the report: templates of Jinja, filled with values.

Sentences stand in `sentences.yaml`, cells in `contents.yaml`, those of a topic in its
`report.yaml`; their filters are `formats`.
"""

import re
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd
from jinja2.environment import TemplateExpression

from ur5lib.channels import CURRENT, Effort
from ur5lib.force.estimators import ESTIMATES, LEADING, PUBLISHED
from ur5lib.report.page import formats
from ur5lib.report.page.document import topic_pages
from ur5lib.strict import read_yaml

_SPOKEN = ContextVar("_SPOKEN", default=CURRENT)
FORMAT_NAMES = ["between", "capital", "counted", "days", "each", "fixed", "joints", "measured"]
FORMAT_NAMES += ["percent", "power", "rounded", "signed", "significant", "to", "with_error"]
FORMAT_NAMES += ["within"]


@contextmanager
def speaking_of(effort: Effort) -> Iterator[None]:
    """Speak of currents or of torques, by whichever is measured."""
    token = _SPOKEN.set(effort)
    try:
        yield
    finally:
        _SPOKEN.reset(token)


def spoken(text: str) -> str:
    """Return a text of the declarations with its words in braces, such as {quantity}, filled in."""
    for word, meant in _SPOKEN.get()._asdict().items():
        text = text.replace(f"{{{word}}}", meant)
        text = text.replace(f"{{{word.capitalize()}}}", meant.capitalize())
    return text


def say(name: str, /, **values: Any) -> str:
    """Return the sentence of a template, `topic.name`, filled with values.

    Raises KeyError where there is no such template.
    """
    topic, _, key = name.partition(".")
    text = _template(spoken(_written()[1][topic][key])).render(values)
    return re.sub(r" +", " ", text).strip()


def cell(template: str, values: Mapping[Hashable, object]) -> str | None:
    """Return the text of a cell: an expression of Jinja or, with braces, a template.

    None where the expression is none: the cell is empty.
    """
    if "{" in (template := spoken(template)):
        return filled(template, values)
    value = _expression(template)(values)
    return None if value is None else str(value)


def filled(template: str, values: Mapping[Hashable, object]) -> str:
    """Return a template filled with values."""
    return _template(spoken(template)).render(values)


def name(value: str, topic: str) -> str:
    """Return the name of a value in the report, the value itself where it has no other."""
    return spoken(names(topic).get(value, value))


@cache
def names(topic: str) -> dict[str, str]:
    """Return the names of the values of a topic, in the report's order; empty if it has none."""
    return {"estimate": ESTIMATES, **_written()[0]}.get(topic, {})


@cache
def _written() -> tuple[dict[str, dict[str, str]], dict[str, dict[str, str]]]:
    """Return the names and the templates of all sentences, by topic."""
    templates = dict(read_yaml(Path(__file__).with_name("sentences.yaml")))
    names = dict(templates.pop("names"))
    for topic, page in topic_pages().items():
        names |= {of: names.get(of, {}) | own for of, own in page.names.items()}
        templates[topic] = page.sentences
    return names, templates


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    environment.filters |= {function: getattr(formats, function) for function in FORMAT_NAMES}
    environment.filters["name"] = name
    environment.globals["leading"] = ESTIMATES[LEADING]
    environment.tests |= {"known": pd.notna, "published": PUBLISHED.__contains__}
    return environment


@cache
def _template(text: str) -> jinja2.Template:
    return _environment().from_string(text)


@cache
def _expression(text: str) -> TemplateExpression:
    return _environment().compile_expression(text, undefined_to_none=False)
