"""The words of a report on arms whose joints sense torque, where those of UR arms have currents."""

import re
from dataclasses import fields, is_dataclass, replace
from typing import Any

from ur5lib.report.document import Code, Document, Equation

WORDS = {
    r"Nm/A\b": "Nm/Nm",
    r"\[A\]": "[Nm]",
    r"(?<=\d) A\b": " Nm",
    r"^A$": "Nm",  # a unit
    r"\bcurrent(s?)\b": r"torque\1",
    r"\bCurrent(s?)\b": r"Torque\1",
}
KEPT = ("drawing", "figure", "home", "label", "link", "of", "path", "rule", "source")


def in_torques(document: Document) -> Document:
    """Return a report that speaks of sensed torques [Nm] instead of currents [A]."""
    reworded: Document = _reworded(document)
    return reworded


def _reworded(part: Any) -> Any:
    """Return a part of a document with other words; files, labels and code stay."""
    match part:
        case Code() | Equation():
            return part
        case str():
            return _words(part)
        case list() | tuple():
            return type(part)(map(_reworded, part))
    if not is_dataclass(part) or isinstance(part, type):
        return part
    names = (own.name for own in fields(part) if own.name not in KEPT)
    return replace(part, **{name: _reworded(getattr(part, name)) for name in names})


def _words(text: str) -> str:
    for pattern, word in WORDS.items():
        text = re.sub(pattern, word, text)
    return text
