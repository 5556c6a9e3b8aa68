"""The controller's force of an e-Series arm is its wrist sensor: it is not compared with itself."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ur5lib.pipeline.records.forces import PublishedForces
from ur5lib.pipeline.sensor_comparison import comparable

WRENCH = np.ones((5, 6))


@pytest.mark.parametrize(
    ("wrist", "raw", "by_stamps", "kept"),
    [
        (True, None, None, False),
        (True, WRENCH, None, True),
        (True, None, WRENCH, True),
        (False, None, None, True),
    ],
)
def test_a_sensor_is_not_compared_with_itself(
    wrist: bool, raw: Any, by_stamps: Any, kept: bool
) -> None:
    kinds = {kind: {"Fu": WRENCH, "F": 2 * WRENCH} for kind in ("printed", "corrected")}
    published = PublishedForces(time=np.arange(5.0), segment=np.zeros(5, int), **cast(Any, kinds))
    left = comparable(
        cast(Any, SimpleNamespace(wrist_sensor=wrist)),
        cast(Any, SimpleNamespace(ft_raw_wrench=raw)),
        cast(Any, SimpleNamespace(by_stamps=by_stamps)),
        published,
    )
    for found in (left.printed, left.corrected):
        assert [*found] == (["Fu", "F"] if kept else ["F"])
