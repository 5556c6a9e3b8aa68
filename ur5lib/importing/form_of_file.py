"""How a file was read, so that others of its form and arm are read alike."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ur5lib.checks.readings import Order
from ur5lib.importing.account import Names

Factors = tuple[float, ...]  # by which the numbers of columns are multiplied
SAME_FACTOR = 2e-3  # relative difference of a driver's constants by two files


@dataclass(frozen=True)
class FormOfFile:
    """How a file was read, so that others of the same form are read alike.

    columns: the names of its blocks; arm: name; order: columns of its joints, None where nothing
    shows it; efforts: channel and factors by block names; amperes: factors that make whole
    milliamperes of efforts, by block names; rows: number of rows; shown: whether a file that is
    read like it supports it; proven: whether the file alone proves what its efforts are.
    """

    name: str
    columns: frozenset[Names]
    arm: str
    order: Order | None
    efforts: Mapping[Names, tuple[str, Factors]]
    amperes: Mapping[Names, Factors]
    rows: int
    shown: bool = False
    proven: bool = False

    def is_like(self, other: "FormOfFile") -> bool:
        """Return whether order of joints and efforts are the same as in another file."""
        return self.order == other.order and self._has_efforts_like(other)

    def _has_efforts_like(self, other: "FormOfFile") -> bool:
        return all(
            (own := self.efforts.get(names, ("", ())))[0] == told[0] and _same(own[1], told[1])
            for names, told in other.efforts.items()
        )

    def supports(self, other: "FormOfFile") -> bool:
        """Return whether this file agrees with how another was read: its order is the same or
        unknown, and its efforts have the same channels and factors, or whole milliamperes by these.
        """
        whole = all(
            _same(np.abs(self.amperes.get(names, ())), np.abs(factors))
            for names, (_, factors) in other.efforts.items()
        )
        may_be = self.order in (None, other.order)
        return may_be and (whole or self._has_efforts_like(other))


def _same(factors: Factors | np.ndarray, others: Factors | np.ndarray) -> bool:
    return len(factors) == len(others) and np.allclose(factors, others, rtol=SAME_FACTOR)
