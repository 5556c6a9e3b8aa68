"""The error that a user can correct."""


class InputError(Exception):
    """An input is wrong: a file, a setting or a command-line argument.

    The message is one sentence that a user can act on: where the fault is (file, line or key),
    what is wrong, and what to do. It is shown without a traceback.
    """
