"""The files of one recording or arm, each opened when it is first used."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any


class Opened:
    """The records of one recording or arm as fields, each read from its file when it is first used,
    and kept.

    The fields of a step's `Opened` are those inputs and params of its rule with the same names.
    name: of the recording or the arm.
    """

    name: str = ""

    def __init__(
        self, loads: Mapping[str, Callable[[], Any]] = MappingProxyType({}), /, **known: Any
    ) -> None:
        """Take fields in memory, `known`; loads: a function for each other field that reads it."""
        vars(self).update(known, _loads=loads)

    if not TYPE_CHECKING:  # a type checker knows the fields by their annotations

        def __getattr__(self, name: str) -> Any:
            """Read a field. Raises AttributeError where nothing was given for it."""
            if name not in self.__dict__.get("_loads", ()):
                raise AttributeError(f"{type(self).__name__} was given no {name}: see its rule")
            self.__dict__[name] = self._loads[name]()
            return self.__dict__[name]
