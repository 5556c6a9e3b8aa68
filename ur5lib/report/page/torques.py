"""The words of a report on arms whose joints sense torque, where those of UR arms have currents."""

import re
from collections.abc import Collection
from dataclasses import fields, is_dataclass, replace
from typing import Any

from ur5lib.report.page.document import Code, Document, Equation

TORQUE_WORDS = {
    r"Nm/A\b": "Nm/Nm",
    r"\[A\]": "[Nm]",
    r"(?<=\d) A\b": " Nm",
    r"^A$": "Nm",  # a unit
    r"\bcurrent(s?)\b": r"torque\1",
    r"\bCurrent(s?)\b": r"Torque\1",
}
UNCHANGED_FIELDS = ("drawing", "figure", "home", "label", "link", "of", "path", "rule", "source")


def in_torques(document: Document, names: Collection[str]) -> Document:
    """Return a report that speaks of sensed torques [Nm] instead of currents [A].

    names: of recordings, arms and studies, and titles, which a user has given and which stay.
    """
    longest_first = sorted(names, key=len, reverse=True)
    given_names = re.compile(rf"(?<![\w-])({'|'.join(map(re.escape, longest_first))})(?![\w-])")
    reworded: Document = _reworded(document, given_names)
    return reworded


def _reworded(part: Any, given_names: re.Pattern[str]) -> Any:
    """Return a part of a document with other words; files, labels and code stay."""
    match part:
        case Code() | Equation():
            return part
        case str():
            words = given_names.split(part)  # in turn, text and a given name
            return "".join(text if k % 2 else _words(text) for k, text in enumerate(words))
        case list() | tuple():
            return type(part)(_reworded(item, given_names) for item in part)
    if not is_dataclass(part) or isinstance(part, type):
        return part
    changed = (field.name for field in fields(part) if field.name not in UNCHANGED_FIELDS)
    return replace(part, **{name: _reworded(getattr(part, name), given_names) for name in changed})


def _words(text: str) -> str:
    for pattern, word in TORQUE_WORDS.items():
        text = re.sub(pattern, word, text)
    return text
