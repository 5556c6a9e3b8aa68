"""The error that a user can correct."""

import unicodedata

UNSEEN = {"Zl", "Zp"}  # besides all of "C": controls, marks of direction, what is no character


class InputError(Exception):
    """An input is wrong: a file, a setting or a command-line argument.

    The message is one sentence that a user can act on: where the fault is (file, line or key),
    what is wrong, and what to do. It is shown without a traceback.
    """

    def __str__(self) -> str:
        """Return the message as a terminal may print it."""
        return printable(super().__str__())


def printable(text: str) -> str:
    r"""Return text with escapes (`\x1b`) for the characters that would steer a terminal.

    Lines and tabs stay.
    """
    return "".join(_escaped(letter) for letter in text)


def _escaped(letter: str) -> str:
    category = unicodedata.category(letter)
    if letter in "\n\t" or not (category.startswith("C") or category in UNSEEN):
        return letter
    return letter.encode("unicode_escape").decode()
