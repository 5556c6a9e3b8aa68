"""Long recordings in chunks, so that intermediate results take constant memory."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array

T = TypeVar("T", bound=np.generic)
SIZE = 1 << 14  # samples


def chunks(count: int, size: int = SIZE) -> list[slice]:
    """Return slices of `size` successive samples that cover `count`."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def in_chunks(function: Callable[..., NDArray[T]], *arrays: Array) -> NDArray[T]:
    """Return function(*arrays), computed in chunks of independent samples (N, ...)."""
    first, *others = chunks(len(arrays[0])) or [slice(0)]
    part = function(*(array[first] for array in arrays))
    if not others:
        return part
    result = np.empty((len(arrays[0]), *part.shape[1:]), part.dtype)
    result[first] = part
    for rows in others:
        result[rows] = function(*(array[rows] for array in arrays))
    return result
