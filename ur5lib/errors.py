"""The one kind of error that a user can mend."""


class InputError(Exception):
    """Something given from outside is wrong.

    The message is one sentence a user can act on: where it is (file, line or
    key), what is wrong, and what to do. It is shown without a traceback.
    """
