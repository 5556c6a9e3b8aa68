"""Findings about recordings and remarks of steps in words: by code, with values."""

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Any

import numpy as np

from ur5lib.errors import printable
from ur5lib.strict import read_yaml

LIBRARY = Path(__file__).parents[1]
WORDS = "*.words.yaml"  # the sentences of a module's codes, beside it
# A larger number in a sentence only says that something is wrong.
MAX_STATED_NUMBER = 9999


class Words(Formatter):
    """Values in a sentence: lists are joined by commas, as a study writes them, remarks by their
    format; `{numbers:joints}` is "joint 4", or "joints 2, 3".
    """

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value in words; NaN, which JSON does not know, is unknown."""
        if value is None:
            return "unknown"
        if isinstance(value, Mapping):
            return sentence(value["code"], value["values"])
        if format_spec == "joints":
            return f"joint{'s' * (len(value) > 1)} {', '.join(map(str, value))}"
        if not isinstance(value, list | tuple):
            text = self._bounded(value, format_spec)
            return text if isinstance(value, str) else text.replace("-", "−")
        if all(isinstance(part, Mapping | str) for part in value):
            return (format_spec or ", ").join(self.format_field(part, "") for part in value)
        return ", ".join(self._bounded(part, format_spec) for part in value)

    def _bounded(self, value: Any, format_spec: str) -> str:
        """Return a value in words, beyond four digits before the point as `above 9999`, and
        never with an exponent.
        """
        most = MAX_STATED_NUMBER / 100 if format_spec.endswith("%") else MAX_STATED_NUMBER
        text = str(super().format_field(value, format_spec))
        if format_spec.endswith("g") and "e" in text:
            return np.format_float_positional(float(text), trim="-")
        if format_spec[-1:] not in ("f", "%") or not abs(value) > most:
            return text
        bound = super().format_field(math.copysign(most, value), f".0{format_spec[-1]}")
        return f"{'above' if value > 0 else 'below'} {bound}"


@cache
def templates() -> dict[str, str]:
    """Return the sentences by code, which stand beside the modules that write it.

    Lists are joined by commas; in `{names: and }`, by “ and ”.
    """
    parts = (read_yaml(path) for path in sorted(LIBRARY.rglob(WORDS)))
    return {code: sentence for part in parts for code, sentence in part.items()}


def sentence(code: str, values: Mapping[str, Any]) -> str:
    """Return the sentence of a code, made printable: its values quote hostile files."""
    return _filled(templates()[code], values)


def _filled(template: str, values: Mapping[str, Any]) -> str:
    return printable(Words().vformat(template, (), values))
