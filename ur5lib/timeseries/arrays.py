"""The types of the arrays that all modules exchange."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_plain_validator_function as by


@dataclass(frozen=True)
class FromLists:
    """An annotation of a field by which pydantic reads an array from JSON: rows are lists, null is
    NaN.
    """

    dtype: type

    def __get_pydantic_core_schema__(self, _: Any, __: Any) -> CoreSchema:
        return by(lambda rows: np.array(rows, self.dtype))


Array = Annotated[NDArray[np.float64], FromLists(np.float64)]
Labels = Annotated[NDArray[np.int64], FromLists(np.int64)]
Mask = Annotated[NDArray[np.bool_], FromLists(np.bool_)]
Six = tuple[float, float, float, float, float, float]  # a pose, a wrench, an inertia tensor
