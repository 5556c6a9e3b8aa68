"""Errors that a user can correct, and remarks about doubtful results."""

import traceback
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from os import PathLike
from pathlib import Path

OVERRULED_BY = "; if the study is right, "  # between a stop sign and the line that overrules it
SEPARATOR_CATEGORIES = {"Zl", "Zp"}  # "C…" has controls, marks of direction, surrogates
_OWN_CODE = Path(__file__).parent
_LINES = {"\n", "\t"}  # allowed in texts, but not in names


class InputError(Exception):
    """An input is wrong: a file, a setting or a command-line argument.

    The message is one sentence that a user can act on: where the fault is (file, line or key),
    what is wrong, and what to do. It is shown without a traceback.

        >>> try:
        ...     ur5lib.read_arm("ur55")
        ... except ur5lib.InputError as error:
        ...     reason = str(error)
    """

    def __str__(self) -> str:
        """Return the message as a terminal may print it."""
        return printable(super().__str__())


def fault_of_ours(error: Exception) -> InputError:
    """Return an exception that no input should cause as an error with its place in this package."""
    places = traceback.extract_tb(error.__traceback__)
    own = [place for place in places if Path(place.filename).is_relative_to(_OWN_CODE)]
    place = own[-1] if own else None
    where = f"{Path(place.filename).relative_to(_OWN_CODE.parent)}:{place.lineno}" if place else ""
    said = f"{type(error).__name__}: {error}".splitlines()[0]
    return InputError(
        f"a fault of ours, in {where or 'ur5lib'}, not of what you gave ({said:.200}); "
        "report it, with the file if you may"
    )


class RecordingWarning(UserWarning):
    """A recording lacks what is needed for an answer, which has a gap there.

    >>> issubclass(ur5lib.RecordingWarning, UserWarning)
    True
    """


class UnreadableError(InputError):
    """A recording cannot be read; the rest of its study goes on without it."""


class NameTaken(InputError):  # noqa: N818, a fact that some answer by another name
    """A file exists already, and must not be replaced."""


@dataclass(frozen=True)
class Remark:
    """A remark of a step about its result, or the reason why it has none.

    code: name in tables and for other steps; text: the sentence, made printable; kind: name by
    which a study accepts a stop sign, "" if it cannot; motion: the motion to record that it
    advises, "" without one; constants: fitted and documented constant of a joint [Nm/A, or Nm/Nm],
    if they contradict each other.
    """

    code: str
    text: str
    kind: str = ""
    motion: str = ""
    constants: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Make the sentence printable."""
        object.__setattr__(self, "text", printable(self.text))

    def sentence(self) -> str:
        """Return the sentence; for a stop sign, with how to overrule it."""
        return overrulable(self.text, self.kind)


class RefusalError(ValueError):
    """The recordings do not allow a fit; arguments: those of the `Remark` with the reason."""

    def __init__(self, code: str, text: str, kind: str = "") -> None:
        """Keep the remark."""
        super().__init__(f"{code}: {text}")
        self.remark = Remark(code, text, kind)

    def __reduce__(self) -> tuple[type, tuple[str, str, str]]:
        """Return the class and arguments for pickle, to pass the error between processes."""
        return type(self), (self.remark.code, self.remark.text, self.remark.kind)


def reason(error: ValueError) -> Remark:
    """Return the reason of a failed computation as a remark."""
    if isinstance(error, RefusalError):
        return error.remark
    return Remark("other reason", str(error))


def overrulable(sign: str, kind: str) -> str:
    """Return the sentence of a stop sign, with the key of the study that overrules it; kind: that
    key under `accept`, "" if it cannot be overruled.
    """
    return f"{sign}{OVERRULED_BY}`accept: {{{kind}: the reason}}` overrules this" if kind else sign


def unknown(kind: str, name: object, known: Iterable[str]) -> InputError:
    """Return the error for a name not in `known`; kind: of the named thing, such as a recording."""
    names = [*known]
    return InputError(
        f"unknown {kind} {briefly(name)}{perhaps(name, names)}; available: {', '.join(names)}"
    )


def expect_known(kind: str, name: object, known: Iterable[str]) -> str:
    """Return `name` unchanged. Raises InputError if it is not in `known`; kind: of the
    named thing.
    """
    names = [*known]
    if isinstance(name, str) and name in names:
        return name
    raise unknown(kind, name, names)


def briefly(given: object) -> str:
    """Return a value as a message shows it: on a line, an array or a frame by its shape."""
    shape = getattr(given, "shape", ())
    return f"{type(given).__name__} {shape}" if shape else " ".join(f"{given!r:.80}".split())


def expect_text(given: object, what: str) -> str:
    """Return a name or a path as text. Raises InputError for other types and empty texts."""
    text = str(given) if isinstance(given, str | PathLike) else ""
    if not text or "\0" in text:
        raise InputError(f"{briefly(given)} names no {what}; give its name, as text")
    return text


def perhaps(name: object, known: Iterable[str]) -> str:
    """Return " (did you mean `x`?)" with the name in `known` closest to `name`, "" if none is
    close.
    """
    near = get_close_matches(str(name), [*known], n=1, cutoff=0.5)
    return f" (did you mean `{near[0]}`?)" if near else ""


def some(names: Sequence[str], most: int = 5) -> str:
    """Return the first `most` names of a list for a sentence, followed by "..." if there
    are more.
    """
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")


def printable(text: str) -> str:
    r"""Return text with escapes (`\x1b`) for characters that control a terminal.

    Line breaks and tabs stay.
    """
    if text.isprintable():  # nearly all are
        return text
    return "".join(_escaped(letter) for letter in text)


def with_controls(names: Iterable[str]) -> str | None:
    """Return the first name with a character that controls a terminal, or ends a line or cell."""
    return next((name for name in names if _LINES & {*name} or printable(name) != name), None)


def _escaped(letter: str) -> str:
    category = unicodedata.category(letter)
    if letter in "\n\t" or not (category.startswith("C") or category in SEPARATOR_CATEGORIES):
        return letter
    return letter.encode("unicode_escape").decode()
