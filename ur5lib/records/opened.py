"""What is on disk of one recording or arm, each file opened when it is first used."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any


class Opened:
    """Records by the names of their fields, each read when it is first used, and kept.

    A step that takes one is given, under the names of its fields, what its rule names so among its
    inputs and params. name: of the recording or the arm.
    """

    name: str = ""

    def __init__(
        self, loads: Mapping[str, Callable[[], Any]] = MappingProxyType({}), /, **known: Any
    ) -> None:
        """Take what is in memory by field; loads: what reads each other field."""
        vars(self).update(known, _loads=loads)

    if not TYPE_CHECKING:  # a type checker knows the fields by their annotations

        def __getattr__(self, name: str) -> Any:
            """Read a field. Raises AttributeError where nothing was given for it."""
            if name not in self.__dict__.get("_loads", ()):
                raise AttributeError(f"{type(self).__name__} was given no {name}: see its rule")
            self.__dict__[name] = self._loads[name]()
            return self.__dict__[name]
