"""The controller's force of an e-Series arm is its wrist sensor: it is not compared with itself."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ur5lib.steps.judge_sensor import compared_estimates

WRENCH = np.ones((5, 6))


@pytest.mark.parametrize(
    ("wrist", "raw", "own_clock", "kept"),
    [
        (True, None, False, False),
        (True, WRENCH, False, True),
        (True, None, True, True),
        (False, None, False, True),
    ],
)
def test_a_sensor_is_not_compared_with_itself(
    wrist: bool, raw: Any, own_clock: bool, kept: bool
) -> None:
    robot: Any = SimpleNamespace(wrist_sensor=wrist)
    signals: Any = SimpleNamespace(ft_raw_wrench=raw)
    reading: Any = SimpleNamespace(own_clock=own_clock)
    both = {"Fu": WRENCH, "F": 2 * WRENCH}
    published: Any = SimpleNamespace(printed=both, corrected=both)
    forces: Any = SimpleNamespace(wrench={}, std={}, log_odds={})
    found = compared_estimates(robot, signals, reading, published, forces)
    assert {*found} == {"printed", "corrected", "compensated"}
    for estimates in found.values():
        assert [*estimates] == (["Fu", "F"] if kept else ["F"])
